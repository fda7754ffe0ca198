"""Live traffic: AIS, NMEA 0183 and Signal K as reports, and the picture that they make together."""
