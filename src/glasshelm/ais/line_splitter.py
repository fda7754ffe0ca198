"""From pieces of a byte stream to its lines, with bounded memory."""

from collections.abc import Iterator

from glasshelm.ais.nmea_sentence import MAX_SENTENCE_BYTES


class LineSplitter:
    """Cuts a stream at its line ends.

    Of a line longer than may be, its beginning comes out at once, so long that it
    is refused as too long; the rest of it is passed over.
    """

    def __init__(self) -> None:
        self._rest = b""
        self._skip = False

    def feed(self, piece: bytes) -> Iterator[bytes]:
        """The lines that a piece completes."""
        *whole, rest = (self._rest + piece).replace(b"\r", b"\n").split(b"\n")
        self._rest = b""
        for line in whole:
            if self._skip:
                self._skip = False
            else:
                yield line
        if self._skip:
            return
        self._rest = rest
        if len(rest) > MAX_SENTENCE_BYTES:
            self._rest, self._skip = b"", True
            yield rest[: MAX_SENTENCE_BYTES + 1]

    def end(self) -> Iterator[bytes]:
        """What was left without a line end."""
        rest, self._rest, self._skip = self._rest, b"", False
        if rest:
            yield rest
