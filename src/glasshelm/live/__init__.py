"""Live traffic: from AIS reports to an encounter, and advice written back."""
