"""The server: connections, access, protocol, the session shown to all viewers."""
