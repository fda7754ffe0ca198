"""Checks the style of documentation and docstrings: British spelling, plain and short sentences.

    python scripts/check_prose.py [FILE ...]     # default: all documentation, all docstrings

Prints ``FILE:LINE: what is wrong`` for each finding; the exit status is 1 if there is any.
Code, tables' structure, links' addresses and quoted titles are not prose.
"""

import ast
import re
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

TREE = Path(__file__).resolve().parents[1]

#: Words of a sentence, at most.
LONGEST_SENTENCE = 45

#: Titles and names that keep their spelling.
TITLES = ("Decision-Making Processes and Behavioral Intentions", "Rainbow Center")


class Rule(NamedTuple):
    pattern: re.Pattern[str]
    advice: str


def _rule(pattern: str, advice: str) -> Rule:
    return Rule(re.compile(rf"\b(?:{pattern})\b", re.IGNORECASE), advice)


_AMERICAN = (
    r"colors?|colored|behaviors?|behavioral|maneuver\w*|center(?:s|ed|ing)?|gray|neighbors?|"
    r"harbors?|favor\w*|honor\w*|labor|meters|modeled|modeling|labeled|labeling|canceled|"
    r"signaled|traveled|analyze[ds]?|catalog|"
    r"(?:recogn|normal|optim|random|initial|organ|summar|minim|maxim|real|special|general|"
    r"visual|serial|regular|discret|synchron|parametr|emphas|util|character|categor|stabil)"
    r"iz(?:e[ds]?|ing|ation|er)"
)

RULES = (
    _rule(_AMERICAN, "use the British spelling"),
    _rule(r"he|him|his|himself", "a pilot, a critic or a planner is 'it'; a person is 'they'"),
    _rule(r"whom|whomsoever|whosoever", "rewrite: 'who', or name the ship"),
    _rule(r"one who|he who|to who|for who", "name the person or the thing"),
    _rule(r"(?:is|are|was|were|be|being) told|told of|tells? of", "say 'report', 'say' or 'show'"),
    _rule(r"in thought|in her stead|upon which|whereupon|thereof|hereby|lest|aforementioned",
          "archaic: use plain words"),
    _rule(r"is nowhere|nor does|nor is it", "put the verb after its subject"),
    _rule(r"intrud\w+ upon", "say 'intrude into'"),
    _rule(r"in order to", "say 'to'"),
    _rule(r"utili[sz]\w+|leverag\w+", "say 'use'"),
    _rule(r"simply|obviously|basically|please", "leave the filler out"),
    _rule(r"due to the fact that|in the event that|at this point in time", "say it shorter"),
    _rule(r"(the|a|an|of|to|in|is|and|that|it) \1", "a word is doubled"),
)  # fmt: skip

#: Of documentation only: docstrings may call a ship 'she', as seafarers do.
PAGE_RULES = (*RULES, _rule(r"she|her|hers|herself", "a ship is 'it', a viewer is 'they'"))


class Prose(NamedTuple):
    """A paragraph, a table row or a docstring's paragraph, on one line."""

    file: Path
    line: int
    text: str
    is_page: bool
    is_row: bool = False


def main(arguments: list[str]) -> int:
    files = [Path(name).resolve() for name in arguments] or list(_all_files())
    findings = [finding for file in files for prose in _read(file) for finding in check(prose)]
    for finding in findings:
        print(finding)
    print(f"{len(files)} files, {len(findings)} findings")
    return 1 if findings else 0


def check(prose: Prose) -> Iterator[str]:
    """What is wrong with a piece of prose, a line for each finding."""
    where = f"{_shown(prose.file)}:{prose.line}"
    text = prose.text
    for title in TITLES:
        text = text.replace(title, "")
    for rule in PAGE_RULES if prose.is_page else RULES:
        for match in rule.pattern.finditer(text):
            yield f"{where}: '{match[0]}': {rule.advice}"
    if prose.is_row:
        return
    for sentence in re.split(r"(?<=[.!?:;])\s+(?=[A-Z0-9`*(“\"])", text):
        words = [word for word in sentence.split() if re.search(r"[^\W\d_]{2}", word)]
        if len(words) > LONGEST_SENTENCE:
            start = " ".join(sentence.split()[:6])
            yield f"{where}: a sentence of {len(words)} words ('{start} …'): split it"


def _all_files() -> Iterator[Path]:
    yield from sorted((TREE / "docs").rglob("*.md"))
    yield from sorted((TREE / "docs" / "tutorials").glob("*.py"))
    yield from (TREE / name for name in ("README.md", "CONTRIBUTING.md", "SECURITY.md"))
    yield from sorted((TREE / "src").rglob("*.py"))


def _read(file: Path) -> Iterator[Prose]:
    text = file.read_text(encoding="utf-8")
    if file.suffix == ".md":
        yield from _paragraphs(file, text.splitlines(), 1, is_page=True)
    elif "# %%" in text:
        yield from _notebook(file, text.splitlines())
    else:
        yield from _docstrings(file, text)


def _notebook(file: Path, lines: list[str]) -> Iterator[Prose]:
    """The Markdown cells of a py:percent notebook."""
    in_markdown = False
    for number, line in enumerate(lines):
        if line.startswith("# %%"):
            in_markdown = "[markdown]" in line
        lines[number] = line[2:] if in_markdown and line.startswith("# ") else ""
    yield from _paragraphs(file, lines, 1, is_page=True)


def _docstrings(file: Path, text: str) -> Iterator[Prose]:
    kinds = ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, kinds) and (doc := ast.get_docstring(node)):
            line = node.body[0].lineno
            yield from _paragraphs(file, doc.splitlines(), line, is_page=False)


def _paragraphs(file: Path, lines: list[str], first: int, is_page: bool) -> Iterator[Prose]:
    """Prose joined by paragraph, list item or table row; code is left out."""
    fenced, start, parts = False, 0, list[str]()

    def ended() -> Iterator[Prose]:
        if parts:
            yield Prose(file, start, _plain(" ".join(parts)), is_page)
            parts.clear()

    for number, line in enumerate(lines, first):
        bare = line.strip()
        if bare.startswith("```"):
            yield from ended()
            fenced = not fenced
        elif fenced or (line.startswith("    ") and not parts):
            continue
        elif bare.startswith("|"):
            yield from ended()
            yield Prose(file, number, _plain(bare), is_page, is_row=True)
        elif not bare or bare.startswith(("#", "!!!", "===", ">>>", "<", "---")):
            yield from ended()
        else:
            if re.match(r"([*+-]|\d+\.|\w+:( |$)) ?", bare):
                yield from ended()
            if not parts:
                start = number
            parts.append(bare)
    yield from ended()


def _plain(text: str) -> str:
    """Without code, addresses, and what is not words."""
    text = re.sub(r"``.+?``|`[^`]*`", "CODE", text)
    text = re.sub(r"!?\[([^\]]*)\]\([^)]*\)", r"\1", text)
    return re.sub(r"https?://\S+|\*\*|:\w+:`", "", text)


def _shown(file: Path) -> str:
    return str(file.relative_to(TREE) if file.is_relative_to(TREE) else file)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
