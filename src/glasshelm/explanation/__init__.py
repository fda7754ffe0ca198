"""Explanations of a decision: values, priorities, attention, intention."""
