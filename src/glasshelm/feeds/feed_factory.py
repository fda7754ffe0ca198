"""One string names any feed: a TCP server, a UDP port, a file, a Signal K server."""

from pathlib import Path
from urllib.parse import SplitResult, urlsplit

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
    """The feed that ``text`` names.

    ``own`` is own ship's MMSI, where her reports come like those of any ship;
    ``token`` is for a Signal K server that lets nobody read without.
    InputError, in one line, if there is no such feed.
    """
    text = text.strip()
    if own is not None and not (own.isascii() and own.isdigit() and 0 < int(own) < 10**9):
        raise InputError(f"own ship {own!r}: must be an MMSI (up to nine digits)")
    own = None if own is None else str(int(own))
    scheme, found, _ = text.partition("://")
    if not found:
        return _file(text, own)
    if scheme not in ("tcp", "udp", *SIGNALK_PORT):
        raise InputError(f"no feed {text!r}: choose {FEEDS}")
    host, port = _address(text, SIGNALK_PORT.get(scheme))
    if scheme == "tcp":
        return TcpFeed(host, port, own)
    if scheme == "udp":
        return UdpFeed(host, port, own)
    return SignalKFeed(SignalKServer(host, port, scheme == "signalks", token), own)


def is_signalk(text: str) -> bool:
    """Whether this names a Signal K server."""
    scheme, found, _ = text.strip().partition("://")
    return bool(found) and scheme in SIGNALK_PORT


def signalk_server(text: str, token: str | None) -> SignalKServer:
    """The server of ``signalk://…`` for writing back. InputError if it is none, or no token is."""
    scheme = text.strip().partition("://")[0]
    if not is_signalk(text):
        raise InputError(f"{text}: only Signal K can be written back to (signalk://HOST[:PORT])")
    if not token:
        raise InputError("writing back to Signal K needs a token of its server")
    return SignalKServer(
        *_address(text, SIGNALK_PORT[scheme]), tls=scheme == "signalks", token=token
    )


def _address(text: str, default_port: int | None) -> tuple[str, int]:
    problem = f"{text}: must be {text.partition('://')[0]}://HOST:PORT, with a port of 1 to 65535"
    try:
        parts: SplitResult = urlsplit(text.strip())
        host, port = parts.hostname, parts.port or default_port
    except ValueError:
        raise InputError(problem) from None
    rest = parts.path.strip("/") or parts.query or parts.fragment or "@" in parts.netloc
    if not host or not port or rest:
        raise InputError(problem)
    return host, port


def _file(text: str, own: str | None) -> FileFeed:
    path = Path(text)
    try:
        there = path.is_file()
    except (OSError, ValueError):
        there = False
    if not there:
        raise InputError(f"no feed {text!r} (nor such a file): choose {FEEDS}")
    return FileFeed(path, own)
