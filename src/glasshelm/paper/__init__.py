"""The paper made again: its tables and figures, each beside what the paper says of it."""
