"""Choosing a manoeuvre by simulating many: no learning, a known model."""
