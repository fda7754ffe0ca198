"""Where the cases of an evaluation come from."""
