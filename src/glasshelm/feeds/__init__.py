"""Connections to live AIS: NMEA 0183 over TCP, UDP or a file, and Signal K."""
