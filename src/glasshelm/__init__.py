"""Glasshelm: explainable AI for ship collision avoidance."""

__version__ = "0.1.0"
