"""Where the cases of an examination come from."""
