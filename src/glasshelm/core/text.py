"""Text from outside, made safe to show: a ship calls herself what she likes."""

import re
import zlib

#: Joiners that letters of Persian or Hindi need: invisible, and harmless.
_JOINERS = "\u200c\u200d"
#: A longer name is nobody's.
MAX_NAME_LENGTH = 120
_MARKDOWN = re.compile(r"[\\`|*<$]|\](?=[(\[:])|\b_|_\b")


def printable(text: str) -> str:
    """``text`` on one line, with nothing in it that a terminal or a page would obey.

    Control characters, marks that turn the direction of writing, line and page
    separators, halves of surrogate pairs and unknown characters are written as
    Python writes them (``\\x1b``, ``\\u202e``); spaces of any width are spaces.
    """
    if text.isprintable():
        return text
    return "".join(map(_shown, text))


def printable_lines(text: str) -> str:
    """:func:`printable` for a text of several lines."""
    return "\n".join(map(printable, text.split("\n")))


def safe_name(text: str) -> str:
    """A name from outside: :func:`printable`, and no longer than :data:`MAX_NAME_LENGTH`."""
    name = printable(text)
    return name if len(name) <= MAX_NAME_LENGTH else f"{name[: MAX_NAME_LENGTH - 1]}…"


def file_name(text: str, longest: int = 80) -> str:
    """A part of a file name for anything: letters, digits, ``-`` and ``_`` of ASCII.

    What had to be changed ends in digits that tell it from what looks alike then.
    """
    kept = "".join(c if c.isascii() and (c.isalnum() or c in "-_") else "-" for c in text)
    if kept == text and len(text) <= longest:
        return text
    return f"{kept[:longest]}-{zlib.crc32(printable(text).encode()):08x}"


def markdown_text(text: str) -> str:
    """:func:`printable` for Markdown, in a table too: no character of it means anything."""
    return _MARKDOWN.sub(r"\\\g<0>", printable(text))


def markdown_code(text: str) -> str:
    """:func:`printable` as Markdown's code, whatever backticks it has."""
    shown = printable(text)
    longest = max(map(len, re.findall("`+", shown)), default=0)
    fence, space = "`" * (longest + 1), " " if longest else ""
    return f"{fence}{space}{shown}{space}{fence}"


def _shown(character: str) -> str:
    if character.isprintable() or character in _JOINERS:
        return character
    if character.isspace() and character not in "\t\n\v\f\r\x1c\x1d\x1e\x1f\x85\u2028\u2029":
        return " "
    return character.encode("unicode_escape").decode("ascii")
