"""A file as it comes: packed or not, in any encoding, opened by what is in it, read in blocks.

What is packed (gzip, zstd, bzip2, xz, a zip with one file in it) is unpacked as it is read, and
text of any encoding becomes UTF-8. The name of a file says nothing.
"""

import bz2
import codecs
import gzip
import io
import lzma
import re
import zipfile
import zlib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from glasshelm.core.errors import InputError

#: A line is not longer [bytes]; what is, is no line of AIS.
MAX_LINE_BYTES = 65_536
#: A document (JSON) is not longer [bytes].
MAX_DOCUMENT_BYTES = 16_000_000
#: What the first bytes of a Parquet table are.
PARQUET = b"PAR1"
#: Bytes that tell what a file is.
HEAD = 65_536

_LAYERS = 3  # a packed file in a packed file in a packed file
_READ = 1 << 20
_PACKED = re.compile(
    rb"(?P<gzip>\x1f\x8b)|(?P<zstd>\x28\xb5\x2f\xfd|[\x50-\x5f]\x2a\x4d\x18)"
    rb"|(?P<bzip2>BZh[1-9](?:1AY&SY|\x17rE8P\x90))|(?P<xz>\xfd7zXZ\x00)|(?P<zip>PK\x03\x04)"
)
#: What cannot be used, by its first bytes; what to do about it.
_UNPACK = "unpack it first"
_OTHERS: tuple[tuple[bytes, str, str], ...] = (
    (b"7z\xbc\xaf\x27\x1c", "a 7z archive", _UNPACK),
    (b"Rar!\x1a\x07", "a RAR archive", _UNPACK),
    (b"\x04\x22\x4d\x18", "an LZ4 file", _UNPACK),
    (b"\x1f\x9d", "a file packed by compress", _UNPACK),
    (b"PK\x05\x06", "an empty zip archive", "choose another"),
    (b"%PDF", "a PDF document", ""),
    (b"SQLite format 3\x00", "an SQLite database", "write its reports to a CSV table"),
    (b"\xd0\xcf\x11\xe0", "a document of Excel or Word", "save it as a CSV table"),
    (b"\x89HDF", "an HDF5 file", "write its reports to a CSV table"),
    (b"CDF\x01", "a netCDF file", "write its reports to a CSV table"),
    (b"ARROW1", "an Arrow file", "write it as Parquet"),
    (b"FEA1", "a Feather file", "write it as Parquet"),
    (b"Obj\x01", "an Avro file", "write it as Parquet"),
    (b"\x00\x00\x27\x0a", "a shapefile", "write its reports to a CSV table"),
    (b"\xd4\xc3\xb2\xa1", "a capture of network packets", "write its lines to a text file"),
    (b"\x0a\x0d\x0d\x0a", "a capture of network packets", "write its lines to a text file"),
    (b"\x89PNG", "a picture", ""),
    (b"\xff\xd8\xff", "a picture", ""),
    (b"GIF8", "a picture", ""),
)
_RIGHT = "give a table of AIS (CSV, Parquet), NMEA 0183 sentences, or a situation (JSON)"
#: What comes with a table in an archive and is none.
_BESIDE = re.compile(r"(^|/)(__MACOSX/|\.|thumbs\.db$|readme|license|metadata)|\.(xml|pdf|html?)$")
_DAMAGED = (EOFError, OSError, zlib.error, lzma.LZMAError, zipfile.BadZipFile, RuntimeError)


class Unpacked:
    """The bytes of a file, unpacked as they are read; a context manager.

    ``notes`` says afterwards what could not be read. InputError, in one line, if it cannot be
    opened or unpacked, or is something that holds no AIS.
    """

    def __init__(self, path: str | Path):
        self.path = path
        self.notes: list[str] = []
        self.torn = False
        self._packed: list[str] = []
        self._given = False
        self._open: list[Any] = []
        try:
            self._stream: Any = self._opened()
        except BaseException:
            self.close()
            raise

    def __enter__(self) -> "Unpacked":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Close the file and what unpacks it."""
        for stream in reversed(self._open):
            stream.close()

    def peek(self) -> bytes:
        """The first bytes, or those that come next; they stay to be read."""
        try:
            return self._stream.peek(HEAD)[:HEAD]
        except _DAMAGED as error:
            raise self._damaged(error) from None

    def read(self) -> bytes:
        """The next bytes, at most about a megabyte; none at the end.

        A file that is cut off or damaged ends there, and a note says so.
        """
        try:
            data = self._stream.read1(_READ)
        except _DAMAGED as error:
            if not self._given:
                raise self._damaged(error) from None
            self.torn = True
            what = f"the {self._packed[-1]} file" if self._packed else "the file"
            self.notes.append(f"{what} is cut off or damaged: read as far as it goes")
            return b""
        self._given = self._given or bool(data)
        return data

    def _opened(self) -> Any:
        try:
            stream: Any = Path(self.path).open("rb")  # noqa: SIM115
        except (OSError, ValueError) as error:
            reason = getattr(error, "strerror", None) or error
            raise InputError(f"{self.path}: cannot be read ({reason})") from None
        self._open.append(stream)
        self._stream = stream
        for _ in range(_LAYERS):
            head = self.peek()
            self._refuse_others(head)
            found = _PACKED.match(head)
            if found is None:
                return stream
            kind = str(found.lastgroup)
            if kind == "zip" and self._packed:
                raise InputError(f"{self.path}: a zip archive in a {self._packed[-1]} file: unpack")
            self._packed.append(kind)
            stream = _UNPACKERS[kind](stream) if kind != "zip" else self._of_zip(stream)
            self._open.append(stream)
            self._stream = stream
        raise InputError(f"{self.path}: packed more than {_LAYERS} times: {_UNPACK}")

    def _refuse_others(self, head: bytes) -> None:
        for magic, what, instead in _OTHERS:
            if head.startswith(magic):
                raise InputError(f"{self.path}: {what}: {instead or _RIGHT}")
        if head[257:262] == b"ustar":
            raise InputError(f"{self.path}: a tar archive: {_UNPACK}")
        if head.startswith(PARQUET) and self._packed:
            raise InputError(f"{self.path}: a Parquet table in a {self._packed[-1]} file: unpack")

    def _of_zip(self, stream: Any) -> Any:
        """The one file of an archive that may be a table."""
        try:
            archive = zipfile.ZipFile(stream)
            self._open.append(archive)
            names = [info.filename for info in archive.infolist() if not info.is_dir()]
            if "[Content_Types].xml" in names:
                raise InputError(f"{self.path}: a document of Excel or Word: save it as CSV")
            inside = [n for n in names if not _BESIDE.search(n.lower())]
            if len(inside) != 1:
                shown = ", ".join(inside[:3]) + (", …" if len(inside) > 3 else "")
                what = f"{len(inside)} files in it ({shown})" if inside else "no table in it"
                raise InputError(f"{self.path}: a zip archive with {what}: unpack it, choose one")
            return archive.open(inside[0])
        except (*_DAMAGED, NotImplementedError) as error:
            why = "needs a password" if "password" in str(error) else "is cut off or damaged"
            raise InputError(f"{self.path}: a zip archive that {why}") from None

    def _damaged(self, error: Exception) -> InputError:
        if self._packed:
            return InputError(
                f"{self.path}: cannot be read (a {self._packed[-1]} file, cut off or damaged)"
            )
        reason = getattr(error, "strerror", None) or error
        return InputError(f"{self.path}: cannot be read ({reason})")


def _zstd(stream: Any) -> Any:
    import pyarrow as pa

    packed = pa.PythonFile(stream, mode="rb")
    return io.BufferedReader(pa.CompressedInputStream(packed, "zstd"), _READ)  # pyright: ignore


_UNPACKERS: dict[str, Callable[[Any], Any]] = {
    "gzip": lambda stream: gzip.GzipFile(fileobj=stream, mode="rb"),
    "bzip2": bz2.BZ2File,
    "xz": lzma.LZMAFile,
    "zstd": _zstd,
}


class TextFile:
    """The lines of a text file in UTF-8, without its byte order mark; a context manager.

    UTF-16 and UTF-32 are known by their marks, UTF-16 also by its zeros; a line that is not
    UTF-8 is read as Latin-1. Lines end as they may (LF, CR LF, CR); bytes of zero are left out.
    """

    def __init__(self, path: str | Path):
        self._file = Unpacked(path)
        self.path, self.notes = path, self._file.notes

    def __enter__(self) -> "TextFile":
        return self

    def __exit__(self, *_: object) -> None:
        self._file.close()

    def blocks(self, size: int = 1) -> Iterator[bytes]:
        """Whole lines, each with its end (LF), in blocks of ``size`` bytes or a little more.

        A line that is longer than ``LONGEST_LINE`` and than a block is passed over as an empty one;
        a note says so.
        """
        decoder = _decoder(self._file.peek())
        whole, rest, given, long, overlong = b"", b"", False, 0, False
        while data := self._file.read():
            text = rest + decoder(data).replace(b"\0", b"")
            # A CR at the end may be half of an end.
            text, cr = (text[:-1], b"\r") if text.endswith(b"\r") else (text, b"")
            text = _with_lf(text)
            end = text.rfind(b"\n") + 1
            if overlong and end:
                text = text[text.find(b"\n") :]
                end, overlong = text.rfind(b"\n") + 1, False
            whole, rest = whole + text[:end], text[end:] + cr
            if overlong or len(rest) > MAX_LINE_BYTES:
                long += not overlong
                overlong, rest = True, cr
            if whole and len(whole) >= size:
                yield _utf8(whole)
                whole, given = b"", True
        # The last line of a file that is cut off is cut off itself.
        rest = b"" if overlong or self._file.torn else _with_lf(rest + decoder(b""))
        whole += rest + b"\n" if rest and not rest.endswith(b"\n") else rest
        if self._file.torn and not (whole or given):
            raise InputError(f"{self.path}: cut off or damaged: no line of it can be read")
        if whole:
            yield _utf8(whole)
        if long:
            lines = "line" if long == 1 else "lines"
            self.notes.append(f"{long} {lines} longer than {MAX_LINE_BYTES} bytes passed over")

    def lines(self) -> Iterator[bytes]:
        """The lines one by one, without their ends."""
        for block in self.blocks():
            yield from block.split(b"\n")[:-1]


def read_document(path: str | Path) -> bytes:
    """The whole of a text file that is one document, in UTF-8. InputError if it is too long."""
    with Unpacked(path) as file:
        decoder = _decoder(file.peek())
        parts, length = [], 0
        while data := file.read():
            parts.append(decoder(data))
            length += len(parts[-1])
            if length > MAX_DOCUMENT_BYTES:
                most = MAX_DOCUMENT_BYTES // 1_000_000
                raise InputError(f"{path}: longer than {most} MB: not one document")
        document = b"".join([*parts, decoder(b"")])
    return as_utf8(document)


def read_head(path: str | Path) -> bytes:
    """The first lines of a text file, in UTF-8; InputError if it is empty, or no text."""
    with TextFile(path) as file:
        text = next(file.blocks(HEAD), b"")[:HEAD]
    if not text.strip():  # perhaps one line, longer than any of a table
        with Unpacked(path) as packed:
            head = packed.peek()
        text = _utf8(_with_lf(_decoder(head)(head).replace(b"\0", b"")))
    if not text.strip():
        raise InputError(f"{path}: nothing is in it")
    odd = sum(text.count(bytes([code])) for code in (*range(1, 9), *range(14, 27), *range(28, 32)))
    if odd > len(text) // 20:
        raise InputError(f"{path}: neither text nor a kind of file that is known: {_RIGHT}")
    if re.match(rb"\s*<(!doctype|html|\?xml|[a-z]+[ >])", text, re.IGNORECASE):
        kind = "an HTML page" if b"<html" in text[:1000].lower() else "an XML document"
        raise InputError(f"{path}: {kind}: {_RIGHT}")
    return text


def is_parquet(path: str | Path) -> bool:
    """Whether a file is a Parquet table. InputError if it is something that holds no AIS."""
    with Unpacked(path) as file:
        return file.peek().startswith(PARQUET)


def _with_lf(block: bytes) -> bytes:
    if b"\r" not in block:
        return block
    return block.replace(b"\r\n", b"\n").replace(b"\r", b"\n")


def _decoder(head: bytes) -> Callable[[bytes], bytes]:
    """What turns the bytes of a file into UTF-8, piece by piece; the last piece is empty."""
    for mark, name in (
        (codecs.BOM_UTF32_LE, "utf-32"),
        (codecs.BOM_UTF32_BE, "utf-32"),
        (codecs.BOM_UTF16_LE, "utf-16"),
        (codecs.BOM_UTF16_BE, "utf-16"),
    ):
        if head.startswith(mark):
            return _recoder(name)
    if head.startswith(codecs.BOM_UTF8):
        return _without_mark()
    sample = head[:4096]
    even, odd = sample[::2].count(0), sample[1::2].count(0)
    if max(even, odd) > len(sample) // 6 and min(even, odd) <= len(sample) // 100:
        return _recoder("utf-16-le" if odd > even else "utf-16-be")
    return lambda data: data


def _recoder(name: str) -> Callable[[bytes], bytes]:
    decoder = codecs.getincrementaldecoder(name)(errors="replace")
    return lambda data: decoder.decode(data, final=not data).encode("utf-8", errors="replace")


def _without_mark() -> Callable[[bytes], bytes]:
    begun = False

    def rest(data: bytes) -> bytes:
        nonlocal begun
        found, begun = (data if begun else data.removeprefix(codecs.BOM_UTF8)), True
        return found

    return rest


def _utf8(block: bytes) -> bytes:
    """Lines of which those that are not UTF-8 are read as Latin-1."""
    if block.isascii():
        return block
    try:
        block.decode("utf-8")
    except UnicodeDecodeError:
        return b"\n".join(map(as_utf8, block.split(b"\n")))
    return block


def as_utf8(data: bytes) -> bytes:
    """Bytes that are UTF-8, or else are read as Latin-1."""
    try:
        data.decode("utf-8")
    except UnicodeDecodeError:
        return data.decode("latin-1").encode("utf-8")
    return data
