"""Choosing a manoeuvre by trying many in thought: no learning, a known model."""
