"""What the rudder can be, at most and at least, while the sensors err within known bounds."""
