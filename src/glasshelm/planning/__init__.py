"""Manoeuvres, and critics that value them: by simulation with a known model, or learned."""
