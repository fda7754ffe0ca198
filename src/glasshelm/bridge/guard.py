"""Who may connect: by address, by Origin, by token."""

import hmac
from collections.abc import Mapping
from urllib.parse import urlsplit

from starlette.requests import HTTPConnection

from glasshelm.errors import InputError

LOOPBACK = ("127.0.0.1", "localhost", "::1")
SHORTEST_TOKEN = 12
COOKIE = "glasshelm-token"

#: Sent with every answer: nothing comes from elsewhere, nobody may frame the page.
HEADERS = {
    "Content-Security-Policy": (
        "default-src 'self'; style-src 'self' 'unsafe-inline'; img-src 'self' data: blob:; "
        "font-src 'self' data:; connect-src 'self'; object-src 'none'; base-uri 'none'; "
        "form-action 'none'; frame-ancestors 'none'"
    ),
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Permissions-Policy": "camera=(), microphone=(), geolocation=()",
}


class Guard:
    """Lets pass what comes from this machine's own page, or knows the token.

    Without a token only names of this machine are answered to, so that no other
    site can have its name point here. InputError for an address that others
    can reach without a token, or for a token that can be guessed.
    """

    def __init__(self, host: str, token: str | None):
        if token is None and host not in LOOPBACK:
            raise InputError(
                f"--host {host}: others can reach this address; "
                f"give a --token of {SHORTEST_TOKEN} characters or more as well"
            )
        if token is not None and (len(token) < SHORTEST_TOKEN or not token.isascii()):
            raise InputError(f"--token: must be {SHORTEST_TOKEN} ASCII characters or more")
        self.token = token

    def problem(self, connection: HTTPConnection) -> str | None:
        """Why a connection is refused, in one line; None if it may pass."""
        headers = connection.headers
        host = headers.get("host", "")
        if self.token is None and (_name(host) not in LOOPBACK):
            return "this server answers to 127.0.0.1 and localhost only"
        origin = headers.get("origin")
        if origin is not None and urlsplit(origin).netloc != host:
            return "the request comes from another site"
        if self.token is not None and not self.knows(connection):
            return "open the address with ?token= as it was printed when the server began"
        return None

    def knows(self, connection: HTTPConnection) -> bool:
        """Whether the token comes with it, in the address or as the cookie set for it."""
        given: Mapping[str, str] = connection.query_params
        texts = (given.get("token", ""), connection.cookies.get(COOKIE, ""))
        wanted = (self.token or "").encode()
        return any(hmac.compare_digest(text.encode(), wanted) for text in texts)


def _name(host: str) -> str:
    """The name in a Host header, without its port."""
    try:
        return urlsplit(f"//{host}").hostname or ""
    except ValueError:
        return ""
