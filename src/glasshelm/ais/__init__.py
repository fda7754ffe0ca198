"""AIS as data: decoding, files, tables, cleaning, plausibility, time."""
