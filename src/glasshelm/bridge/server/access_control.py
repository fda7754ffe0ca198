"""Who may connect, and as whom: by address, by Origin, by token."""

import hmac
from collections.abc import Mapping
from urllib.parse import urlsplit

from starlette.requests import HTTPConnection

from glasshelm.bridge.server.protocol import Role
from glasshelm.core.errors import InputError

LOOPBACK = ("127.0.0.1", "localhost", "::1")
MIN_TOKEN_LENGTH = 12
TOKEN_COOKIE = "glasshelm-token"

#: Sent with every answer: nothing comes from elsewhere, nobody may frame the page.
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
    """Lets pass what comes from this machine's own page, or knows a token.

    Who knows ``token`` is an owner, who knows ``viewer_token`` may only look on; without tokens
    everybody is an owner, and only names of this machine are answered to, so that no
    other site can have its name point here. InputError for an address that others
    can reach without a token, or for a token that can be guessed.
    """

    def __init__(self, host: str, token: str | None, viewer_token: str | None = None):
        if token is None and host not in LOOPBACK:
            raise InputError(
                f"--host {host}: others can reach this address; "
                f"give a --token of {MIN_TOKEN_LENGTH} characters or more as well"
            )
        for option, given in (("--token", token), ("--viewer-token", viewer_token)):
            if given is not None and not _is_token(given):
                raise InputError(
                    f"{option}: must be {MIN_TOKEN_LENGTH} ASCII characters or more, without spaces"
                )
        if viewer_token is not None and token is None:
            raise InputError("--viewer-token: give the owner's --token as well")
        if viewer_token is not None and viewer_token == token:
            raise InputError("--viewer-token: must be another than the --token of the owner")
        self.token, self.viewer_token = token, viewer_token

    def refusal(self, connection: HTTPConnection) -> str | None:
        """Why a connection is refused, in one line; None if it may pass."""
        host = connection.headers.get("host", "")
        if self.token is None and (_hostname(host) not in LOOPBACK):
            return "this server answers to 127.0.0.1 and localhost only"
        for origin in connection.headers.getlist("origin"):
            if origin.lower() not in (f"http://{host.lower()}", f"https://{host.lower()}"):
                return "the request comes from another site"
        if self.role(connection) is None:
            return "open the address with ?token= as it was printed when the server began"
        return None

    def role(self, connection: HTTPConnection) -> Role | None:
        """As whom somebody comes; None for a stranger.

        By the token of the address, or else by that of the cookie set for it.
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
        """What the browser is to show from now on: the token that it came with."""
        return {"owner": self.token, "viewer": self.viewer_token, None: None}[self.role(connection)]


def _is_token(text: str) -> bool:
    """Whether it can be a secret, and stand in an address and a cookie."""
    return len(text) >= MIN_TOKEN_LENGTH and all("!" <= letter <= "~" for letter in text)


def _matches(text: str, token: str | None) -> bool:
    """Whether it is the token, in a time that does not tell how much of it is right."""
    wanted = token or ""
    same = hmac.compare_digest(text.encode(errors="replace"), wanted.encode())
    return same and token is not None


def _hostname(host: str) -> str:
    """The name in a Host header, without its port."""
    try:
        return urlsplit(f"//{host}").hostname or ""
    except ValueError:
        return ""
