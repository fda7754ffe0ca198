"""Input files of any packing and encoding, known by their contents, read in blocks.

A packed file (gzip, zstd, bzip2, xz, a zip with one file in it) is unpacked as it is read, and
text of any encoding becomes UTF-8. The name of a file is not looked at.
"""

import bz2
import codecs
import contextlib
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

#: A longer line is not one of AIS.
MAX_LINE_BYTES = 65_536
#: A longer document (JSON) is not read.
MAX_DOCUMENT_BYTES = 16_000_000
#: The first bytes of a Parquet table.
PARQUET = b"PAR1"
#: So many first bytes tell what a file is.
HEAD = 65_536

_MAX_LAYERS = 3  # a packed file in a packed file in a packed file
_READ = 1 << 20
_PACKED = re.compile(
    rb"(?P<gzip>\x1f\x8b)|(?P<zstd>\x28\xb5\x2f\xfd|[\x50-\x5f]\x2a\x4d\x18)"
    rb"|(?P<bzip2>BZh[1-9](?:1AY&SY|\x17rE8P\x90))|(?P<xz>\xfd7zXZ\x00)|(?P<zip>PK\x03\x04)"
)
#: Files that cannot be used, by their first bytes; and what to do about it.
_UNPACK = "unpack it first"
_UNUSABLE: tuple[tuple[bytes, str, str], ...] = (
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
_USABLE = "give a table of AIS (CSV, Parquet), NMEA 0183 sentences, or a situation (JSON)"
#: Files in an archive that are no table.
_NO_TABLE = re.compile(
    r"(^|/)(__MACOSX/|\.|thumbs\.db$|readme|license|metadata)|\.(xml|pdf|html?)$"
)
_DAMAGED = (EOFError, OSError, zlib.error, lzma.LZMAError, zipfile.BadZipFile, RuntimeError)
#: Byte order marks, and the encodings that they stand for.
_MARKS = (
    (codecs.BOM_UTF32_LE, "utf-32"),
    (codecs.BOM_UTF32_BE, "utf-32"),
    (codecs.BOM_UTF16_LE, "utf-16"),
    (codecs.BOM_UTF16_BE, "utf-16"),
    (codecs.BOM_UTF8, "utf-8-sig"),
)
#: Characters that text hardly holds.
_CONTROL = bytes((*range(1, 9), *range(14, 27), *range(28, 32)))


class UnpackedFile:
    """The bytes of a file, unpacked as they are read; a context manager.

    Attributes:
        notes: What could not be read, once the end is reached.
        truncated: Whether the file is cut off or damaged.

    Raises:
        InputError: It cannot be opened or unpacked, or is known to hold no AIS.
    """

    def __init__(self, path: str | Path):
        self.path = path
        self.notes: list[str] = []
        self.truncated = False
        self._packings: list[str] = []
        self._begun = False
        self._to_close = contextlib.ExitStack()
        try:
            self._stream: Any = self._open()
        except BaseException:
            self._to_close.close()
            raise

    def __enter__(self) -> "UnpackedFile":
        return self

    def __exit__(self, *_: object) -> None:
        self._to_close.close()

    def peek(self) -> bytes:
        """The first bytes, or those that come next; they stay to be read."""
        try:
            return self._stream.peek(HEAD)[:HEAD]
        except _DAMAGED as error:
            raise self._unreadable(error) from None

    def read(self) -> bytes:
        """The next bytes, at most about a megabyte; none at the end.

        A file that is cut off or damaged ends there, and a note says so.
        """
        try:
            data = self._stream.read1(_READ)
        except _DAMAGED as error:
            if not self._begun:
                raise self._unreadable(error) from None
            self.truncated = True
            what = f"the {self._packings[-1]} file" if self._packings else "the file"
            self.notes.append(f"{what} is cut off or damaged: read as far as it goes")
            return b""
        self._begun = self._begun or bool(data)
        return data

    def _open(self) -> Any:
        try:
            self._stream = self._to_close.enter_context(open(self.path, "rb"))  # noqa: SIM115
        except (OSError, ValueError) as error:
            raise self._unreadable(error) from None
        for _ in range(_MAX_LAYERS):
            head = self.peek()
            self._reject_unusable(head)
            found = _PACKED.match(head)
            if found is None:
                return self._stream
            packing = str(found.lastgroup)
            if packing == "zip" and self._packings:
                raise self._error(f"a zip archive in a {self._packings[-1]} file: unpack")
            unpack = self._unzip if packing == "zip" else _UNPACKERS[packing]
            self._packings.append(packing)
            self._stream = self._to_close.enter_context(unpack(self._stream))
        raise self._error(f"packed more than {_MAX_LAYERS} times: {_UNPACK}")

    def _reject_unusable(self, head: bytes) -> None:
        for magic, what, instead in _UNUSABLE:
            if head.startswith(magic):
                raise self._error(f"{what}: {instead or _USABLE}")
        if head[257:262] == b"ustar":
            raise self._error(f"a tar archive: {_UNPACK}")
        if head.startswith(PARQUET) and self._packings:
            raise self._error(f"a Parquet table in a {self._packings[-1]} file: unpack")

    def _unzip(self, stream: Any) -> Any:
        """The one file of an archive that may be a table."""
        try:
            archive = self._to_close.enter_context(zipfile.ZipFile(stream))
            names = [info.filename for info in archive.infolist() if not info.is_dir()]
            if "[Content_Types].xml" in names:
                raise self._error("a document of Excel or Word: save it as CSV")
            tables = [name for name in names if not _NO_TABLE.search(name.lower())]
            if len(tables) != 1:
                shown = ", ".join(tables[:3]) + (", …" if len(tables) > 3 else "")
                what = f"{len(tables)} files in it ({shown})" if tables else "no table in it"
                raise self._error(f"a zip archive with {what}: unpack it, choose one")
            return archive.open(tables[0])
        except (*_DAMAGED, NotImplementedError) as error:
            why = "needs a password" if "password" in str(error) else "is cut off or damaged"
            raise self._error(f"a zip archive that {why}") from None

    def _unreadable(self, error: Exception) -> InputError:
        reason = getattr(error, "strerror", None) or error
        if self._packings:
            reason = f"a {self._packings[-1]} file, cut off or damaged"
        return self._error(f"cannot be read ({reason})")

    def _error(self, what: str) -> InputError:
        return InputError(f"{self.path}: {what}")


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
    UTF-8 is read as Latin-1. Lines end in LF, CR LF or CR; bytes of zero are left out.
    """

    def __init__(self, path: str | Path):
        self._file = UnpackedFile(path)
        self.path, self.notes = path, self._file.notes

    def __enter__(self) -> "TextFile":
        return self

    def __exit__(self, *details: object) -> None:
        self._file.__exit__(*details)

    def blocks(self, size: int = 1) -> Iterator[bytes]:
        """Whole lines, each with its end (LF), in blocks of ``size`` bytes or a little more.

        A line longer than ``MAX_LINE_BYTES`` and than a block is passed over as an empty one;
        a note says so.
        """
        decode = _decoder(self._file.peek())
        whole, rest, any_block, n_long, in_long_line = b"", b"", False, 0, False
        while data := self._file.read():
            text = rest + decode(data).replace(b"\0", b"")
            # A CR at the end may be half of a line end.
            text, cr = (text[:-1], b"\r") if text.endswith(b"\r") else (text, b"")
            text = _with_lf(text)
            end = text.rfind(b"\n") + 1
            if in_long_line and end:
                text = text[text.find(b"\n") :]
                end, in_long_line = text.rfind(b"\n") + 1, False
            whole, rest = whole + text[:end], text[end:] + cr
            if in_long_line or len(rest) > MAX_LINE_BYTES:
                n_long += not in_long_line
                in_long_line, rest = True, cr
            if whole and len(whole) >= size:
                yield _lines_as_utf8(whole)
                whole, any_block = b"", True
        # The last line of a file that is cut off is cut off itself.
        if not (in_long_line or self._file.truncated):
            rest = _with_lf(rest + decode(b""))
            whole += rest + b"\n" if rest and not rest.endswith(b"\n") else rest
        if self._file.truncated and not (whole or any_block):
            raise InputError(f"{self.path}: cut off or damaged: no line of it can be read")
        if whole:
            yield _lines_as_utf8(whole)
        if n_long:
            lines = "line" if n_long == 1 else "lines"
            self.notes.append(f"{n_long} {lines} longer than {MAX_LINE_BYTES} bytes passed over")

    def lines(self) -> Iterator[bytes]:
        """The lines one by one, without their ends."""
        for block in self.blocks():
            yield from block.split(b"\n")[:-1]


def read_document(path: str | Path) -> bytes:
    """The whole of a text file that is one document, in UTF-8. InputError if it is too long."""
    with UnpackedFile(path) as file:
        decode = _decoder(file.peek())
        document = b""
        while data := file.read():
            document += decode(data)
            if len(document) > MAX_DOCUMENT_BYTES:
                most = MAX_DOCUMENT_BYTES // 1_000_000
                raise InputError(f"{path}: longer than {most} MB: not one document")
    return as_utf8(document + decode(b""))


def read_head(path: str | Path) -> bytes:
    """The first lines of a text file, in UTF-8; InputError if it is empty, or no text."""
    with TextFile(path) as file:
        text = next(file.blocks(HEAD), b"")[:HEAD]
    if not text.strip():  # perhaps one line, longer than any of a table
        with UnpackedFile(path) as packed:
            head = packed.peek()
        text = _lines_as_utf8(_with_lf(_decoder(head)(head).replace(b"\0", b"")))
    if not text.strip():
        raise InputError(f"{path}: nothing is in it")
    if len(text) - len(text.translate(None, _CONTROL)) > len(text) // 20:
        raise InputError(f"{path}: neither text nor a kind of file that is known: {_USABLE}")
    if re.match(rb"\s*<(!doctype|html|\?xml|[a-z]+[ >])", text, re.IGNORECASE):
        kind = "an HTML page" if b"<html" in text[:1000].lower() else "an XML document"
        raise InputError(f"{path}: {kind}: {_USABLE}")
    return text


def is_parquet(path: str | Path) -> bool:
    """Whether a file is a Parquet table. InputError if it is known to hold no AIS."""
    with UnpackedFile(path) as file:
        return file.peek().startswith(PARQUET)


def _with_lf(block: bytes) -> bytes:
    if b"\r" not in block:
        return block
    return block.replace(b"\r\n", b"\n").replace(b"\r", b"\n")


def _decoder(head: bytes) -> Callable[[bytes], bytes]:
    """What turns the bytes of a file into UTF-8, piece by piece; the last piece is empty."""
    for mark, name in _MARKS:
        if head.startswith(mark):
            return _recoder(name)
    sample = head[:4096]
    even, odd = sample[::2].count(0), sample[1::2].count(0)
    if max(even, odd) > len(sample) // 6 and min(even, odd) <= len(sample) // 100:
        return _recoder("utf-16-le" if odd > even else "utf-16-be")
    return lambda data: data


def _recoder(name: str) -> Callable[[bytes], bytes]:
    # What is not UTF-8 behind its mark passes unchanged: it may be Latin-1.
    errors = "surrogateescape" if name == "utf-8-sig" else "replace"
    decoder = codecs.getincrementaldecoder(name)(errors)
    return lambda data: decoder.decode(data, final=not data).encode("utf-8", errors)


def _lines_as_utf8(block: bytes) -> bytes:
    """Lines of which those that are not UTF-8 are read as Latin-1."""
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
