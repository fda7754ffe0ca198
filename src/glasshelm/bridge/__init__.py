"""The bridge: a server that shows a voyage to any number of viewers, live, recorded or replayed."""
