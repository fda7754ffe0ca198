"""Simulation: an encounter and a pilot become a stream of frames."""
