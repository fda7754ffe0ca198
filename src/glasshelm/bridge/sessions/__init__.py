"""Sessions: simulated, replayed and live voyages, and their logs."""
