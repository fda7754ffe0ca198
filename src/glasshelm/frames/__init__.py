"""Frames: the schema, logs, Parquet, time series and summaries of a voyage."""
