"""Access control: who may connect, and in which role, by address, Origin and token."""

import hmac
from collections.abc import Mapping
from urllib.parse import urlsplit

from starlette.requests import HTTPConnection

from glasshelm.bridge.server.protocol import Role
from glasshelm.core.errors import InputError

LOOPBACK_HOSTS = ("127.0.0.1", "localhost", "::1")
MIN_TOKEN_LENGTH = 12
TOKEN_COOKIE = "glasshelm-token"

#: Sent with every response: nothing is loaded from elsewhere, and nobody may frame the page.
SECURITY_HEADERS = {
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


class AccessControl:
    """Admits this machine's own page, or whoever knows a token.

    ``token`` makes an owner, ``viewer_token`` a viewer. Without tokens everybody is an owner, and
    only requests to this machine's own names are answered, so that no other site can point its
    name here.

    Raises:
        InputError: Others can reach ``host`` and there is no token, or a token can be guessed.
    """

    def __init__(self, host: str, token: str | None, viewer_token: str | None = None):
        if token is None and host not in LOOPBACK_HOSTS:
            raise InputError(
                f"--host {host}: others can reach this address; "
                f"also give a --token of {MIN_TOKEN_LENGTH} characters or more"
            )
        for option, given in (("--token", token), ("--viewer-token", viewer_token)):
            if given is not None and not _is_token(given):
                raise InputError(
                    f"{option}: must be {MIN_TOKEN_LENGTH} ASCII characters or more, without spaces"
                )
        if viewer_token is not None and token is None:
            raise InputError("--viewer-token: also give the owner's --token")
        if viewer_token is not None and viewer_token == token:
            raise InputError("--viewer-token: must differ from the owner's --token")
        self.token, self.viewer_token = token, viewer_token

    def refusal(self, connection: HTTPConnection) -> str | None:
        """Return why a connection is refused, in one line; None if it is admitted."""
        host = connection.headers.get("host", "")
        if self.token is None and _hostname(host) not in LOOPBACK_HOSTS:
            return "this server answers to 127.0.0.1 and localhost only"
        for origin in connection.headers.getlist("origin"):
            if origin.lower() not in (f"http://{host.lower()}", f"https://{host.lower()}"):
                return "the request comes from another site"
        if self.role(connection) is None:
            return "open the address with ?token= as it was printed when the server started"
        return None

    def role(self, connection: HTTPConnection) -> Role | None:
        """Return the role of a connection; None without a valid token.

        The token of the address comes before that of the cookie.
        """
        if self.token is None:
            return "owner"
        given: Mapping[str, str] = connection.query_params
        for text in (given.get("token", ""), connection.cookies.get(TOKEN_COOKIE, "")):
            owns, views = _matches(text, self.token), _matches(text, self.viewer_token)
            if owns or views:
                return "owner" if owns else "viewer"
        return None

    def cookie_token(self, connection: HTTPConnection) -> str | None:
        """Return the token to keep in the browser's cookie: the one it came with."""
        return {"owner": self.token, "viewer": self.viewer_token, None: None}[self.role(connection)]


def _is_token(text: str) -> bool:
    """Whether it is long enough, and can stand in an address and a cookie."""
    return len(text) >= MIN_TOKEN_LENGTH and all("!" <= letter <= "~" for letter in text)


def _matches(text: str, token: str | None) -> bool:
    """Compare with the token in constant time."""
    return hmac.compare_digest(text.encode(errors="replace"), (token or "").encode()) and bool(
        token
    )


def _hostname(host: str) -> str:
    """The name in a Host header, without the port."""
    try:
        return urlsplit(f"//{host}").hostname or ""
    except ValueError:
        return ""
