"""What all connections need: waiting before they try again, and why they failed, in words."""

import asyncio
import os
import re
import ssl

from websockets.exceptions import ConnectionClosed, InvalidStatus

#: A server that is silent for so long [s] is taken for gone, and connected to again.
SILENT_S = 120.0
#: An attempt to connect is given up after so long [s].
CONNECT_S = 10.0

#: What asyncio writes where no attempt to connect succeeded, in place of the system's words.
_NOT_CONNECTED = "Connect call failed"
_ERROR_NUMBER = re.compile(r"\[Errno (\d+)\]")


class Backoff:
    """Waits 0.5 s, then twice as long each time up to 15 s; success sets it back."""

    FIRST_S = 0.5
    LONGEST_S = 15.0

    def __init__(self) -> None:
        self._next_s = self.FIRST_S

    async def wait(self) -> None:
        """Wait until the next attempt."""
        delay, self._next_s = self._next_s, min(2 * self._next_s, self.LONGEST_S)
        await asyncio.sleep(delay)

    def succeeded(self) -> None:
        """Something was received: begin with the shortest wait again."""
        self._next_s = self.FIRST_S


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
        numbers = dict.fromkeys(_ERROR_NUMBER.findall(str(error)))
        text = ", ".join(os.strerror(int(number)) for number in numbers) or text
    text = " ".join(text.split())
    return text[:1].lower() + text[1:] if text[1:2].islower() else text
