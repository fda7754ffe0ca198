"""The story of a voyage in plain sentences and on one page, made from frames."""
