"""Encounters: what a scenario is, and where it comes from."""
