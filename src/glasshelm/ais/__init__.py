"""AIS as data: what its numbers may be, tables of reports, and the files that hold them."""
