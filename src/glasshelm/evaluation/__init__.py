"""Evaluation of pilots: suites of encounters, measures, statistics, tables, figures."""
