"""Why a connection failed, in words for people: no addresses in brackets, no error numbers."""

import os
import re
import ssl

from websockets.exceptions import ConnectionClosed, InvalidStatus

#: What asyncio writes where no attempt to connect succeeded, in place of the system's words.
_NOT_CONNECTED = "Connect call failed"
_NUMBER = re.compile(r"\[Errno (\d+)\]")


def describe_error(error: BaseException, silent: str = "no answer") -> str:
    """One line about a connection that failed; ``silent`` where nothing came in time."""
    if isinstance(error, TimeoutError):
        return silent
    if isinstance(error, InvalidStatus):
        status = error.response.status_code
        hint = ": a token is needed, or this one is not valid" if status in (401, 403) else ""
        return f"refused with HTTP status {status}{hint}"
    if isinstance(error, ConnectionClosed):
        return "the server closed the connection"
    if isinstance(error, ssl.SSLCertVerificationError):
        return f"its certificate is not valid: {error.verify_message}"
    text = getattr(error, "strerror", None) or str(error)
    if not text:
        return type(error).__name__
    if _NOT_CONNECTED in text:
        # Of a name with several addresses each has its own error; mostly the same.
        numbers = dict.fromkeys(_NUMBER.findall(str(error)))
        text = ", ".join(os.strerror(int(number)) for number in numbers) or text
    text = " ".join(text.split())
    return text[:1].lower() + text[1:] if text[1:2].islower() else text
