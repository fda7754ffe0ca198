"""What every package may use: errors, geometry, safe text, output files, compiled programs."""
