"""Figures and the report, made from frames."""
