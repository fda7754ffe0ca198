"""Own ship: Nomoto's model (Eq. 6-7), ship domain (13-15), autopilot, hull overlap."""
