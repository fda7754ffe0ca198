"""One string names any feed: a TCP server, a UDP port, a file, a Signal K server."""

from pathlib import Path
from urllib.parse import urlsplit

from glasshelm.ais.limits import is_mmsi
from glasshelm.ais.mmsi import is_number
from glasshelm.ais.reports import Feed
from glasshelm.core.errors import InputError
from glasshelm.feeds.nmea_transport import FileFeed, TcpFeed, UdpFeed
from glasshelm.feeds.signalk_client import SignalKFeed, SignalKServer

FEEDS = (
    "tcp://HOST:PORT, udp://HOST:PORT (listens there), signalk://HOST[:PORT], "
    "signalks://HOST[:PORT] (TLS), or a file of NMEA 0183 (also .gz)"
)
#: Ports of Signal K where none is given.
SIGNALK_PORT = {"signalk": 3000, "signalks": 3443}


def create_feed(text: str, own: str | None = None, token: str | None = None) -> Feed:
    """The feed that a string names.

    Args:
        text: One of :data:`FEEDS`.
        own: Own ship's MMSI, where its reports come like those of any ship.
        token: For a Signal K server that lets nobody read without.

    Raises:
        InputError: There is no such feed.
    """
    text = text.strip()
    if own is not None:
        if not (is_number(own) and len(own) < 20 and is_mmsi(int(own))):
            raise InputError(f"own ship {own!r}: must be an MMSI (up to nine digits)")
        own = str(int(own))
    scheme, separator, _ = text.partition("://")
    if not separator:
        return _file_feed(text, own)
    match scheme:
        case "tcp":
            return TcpFeed(*_address(text), own)
        case "udp":
            return UdpFeed(*_address(text), own)
        case "signalk" | "signalks":
            return SignalKFeed(_signalk_server(text, token), own)
    raise InputError(f"no feed {text!r}: choose {FEEDS}")


def is_signalk(text: str) -> bool:
    """Whether a string names a Signal K server."""
    scheme, separator, _ = text.strip().partition("://")
    return bool(separator) and scheme in SIGNALK_PORT


def signalk_server(text: str, token: str | None) -> SignalKServer:
    """The server to write to. InputError if it is no ``signalk://…``, or there is no token."""
    if not is_signalk(text):
        raise InputError(f"{text}: only Signal K can be written back to (signalk://HOST[:PORT])")
    if not token:
        raise InputError("writing back to Signal K needs a token of its server")
    return _signalk_server(text.strip(), token)


def _signalk_server(text: str, token: str | None) -> SignalKServer:
    scheme = text.partition("://")[0]
    host, port = _address(text, SIGNALK_PORT[scheme])
    return SignalKServer(host, port, scheme == "signalks", token)


def _address(text: str, default_port: int | None = None) -> tuple[str, int]:
    problem = f"{text}: must be {text.partition('://')[0]}://HOST:PORT, with a port of 1 to 65535"
    try:
        parts = urlsplit(text)
        host, port = parts.hostname, parts.port or default_port
    except ValueError:
        raise InputError(problem) from None
    rest = parts.path.strip("/") or parts.query or parts.fragment or "@" in parts.netloc
    if not host or not port or rest:
        raise InputError(problem)
    return host, port


def _file_feed(text: str, own_mmsi: str | None) -> FileFeed:
    path = Path(text)
    try:
        exists = path.is_file()
    except (OSError, ValueError):
        exists = False
    if not exists:
        raise InputError(f"no feed {text!r} (nor such a file): choose {FEEDS}")
    return FileFeed(path, own_mmsi)
