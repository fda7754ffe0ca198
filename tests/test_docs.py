"""What the documentation cites exists, and the check of its style can fail."""

import ast
import importlib.util
import json
import re
import tomllib
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest

TREE = Path(__file__).parents[1]
PACKAGE = TREE / "src" / "glasshelm"
PAGES = sorted([
    *(TREE / "docs").rglob("*.md"), *(TREE / "docs" / "tutorials").glob("*.py"),
    *(TREE / name for name in (
        "README.md", "CONTRIBUTING.md", "SECURITY.md", "NOTICE", "CITATION.cff",
    )),
])  # fmt: skip

#: Pages of the site that scripts/docs_hooks.py makes.
GENERATED = {
    "contributing.md", "changelog.md", "security.md", "reference/cli.md",
    *(f"tutorials/{path.stem}.md" for path in (TREE / "docs" / "tutorials").glob("*.py")),
}  # fmt: skip

#: Files that an example has its reader write.
EXAMPLES = {"somebody.py"}

_TOP = r"(?:src|tests|benchmarks|scripts|docs|web|requirements|\.ci)"
_ROOTED = re.compile(rf"(?<![\w./:-]){_TOP}/[\w./*-]*[\w*/]")
_SOURCE = re.compile(r"`([\w./-]+\.(?:py|ts))`")
_LINK = re.compile(r"\]\(([^)\s#]+)(?:#[^)]*)?\)")
_DOTTED = re.compile(r"(?<![\w./-])glasshelm(?:\.\w+)+")
_SHORT_DOTTED = re.compile(r"`([a-z]\w*(?:\.\w+){2,})`")
_IDENTIFIER = re.compile(r"`(?:\w+\.)*([a-z][a-z0-9]*_\w+)`")


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(TREE)))
def test_everything_that_a_page_cites_exists(page: Path):
    missing = sorted(set(_missing(page)))
    assert missing == []


def _missing(page: Path) -> Iterator[str]:
    text = page.read_text(encoding="utf-8")
    for path in _ROOTED.findall(text):
        if "NAME" not in path and not any(TREE.glob(path.rstrip("/"))):
            yield path
    for path in _SOURCE.findall(text):
        if path not in EXAMPLES and "NAME" not in path and not _is_source(path):
            yield path
    for target in _LINK.findall(text):
        if "://" not in target and not _is_linked(page, target):
            yield target
    for name in _DOTTED.findall(text):
        if not _is_name(name):
            yield name
    for name in _SHORT_DOTTED.findall(text):
        if (PACKAGE / name.split(".")[0]).is_dir() and not _is_name(f"glasshelm.{name}"):
            yield name
    yield from (name for name in _IDENTIFIER.findall(text) if name not in _words())


def _is_source(path: str) -> bool:
    """Whether it is a file of the tree, its package or its tests; a bare name may be anywhere."""
    if "/" not in path:
        return path in _file_names()
    return any((root / path).is_file() for root in (TREE, PACKAGE, TREE / "tests"))


@cache
def _file_names() -> frozenset[str]:
    roots = (
        TREE / "src",
        TREE / "tests",
        TREE / "benchmarks",
        TREE / "scripts",
        TREE / "web" / "src",
    )
    return frozenset(path.name for root in roots for path in root.rglob("*.*"))


@cache
def _words() -> frozenset[str]:
    """Every identifier of the code."""
    roots = TREE / "src", TREE / "tests", TREE / "benchmarks", TREE / "web" / "src"
    files = (file for root in roots for file in root.rglob("*") if file.suffix in {".py", ".ts"})
    return frozenset(
        word for file in files if file != Path(__file__) for word in re.findall(r"\w+", _text(file))
    )


def _is_linked(page: Path, target: str) -> bool:
    path = (page.parent / target).resolve()
    docs = TREE / "docs"
    return path.exists() or (path.is_relative_to(docs) and str(path.relative_to(docs)) in GENERATED)


def _is_name(name: str) -> bool:
    """Whether it is a module of the package, or is named in one."""
    path = PACKAGE
    parts = name.split(".")[1:]
    for index, part in enumerate(parts):
        if (path / part).is_dir():
            path /= part
        else:
            file = path / f"{part}.py"
            rest = parts[index + 1 :] if file.is_file() else parts[index:]
            source = (file if file.is_file() else path / "__init__.py").read_text(encoding="utf-8")
            return all(re.search(rf"\b{one}\b", source) for one in rest)
    return True


def test_pages_that_the_code_cites_exist():
    cited = {
        (str(file.relative_to(TREE)), path)
        for root in ("src", "tests", "benchmarks", "scripts", "web/src")
        for file in (TREE / root).rglob("*")
        if file.is_file() and file.suffix in {"", ".py", ".ts"} and file != Path(__file__)
        for path in re.findall(r"docs/[\w/-]+\.(?:md|json|py)", _text(file))
    }
    assert len(cited) > 10
    assert [(file, path) for file, path in sorted(cited) if not (TREE / path).exists()] == []


def _text(file: Path) -> str:
    return file.read_text(encoding="utf-8", errors="replace")


def test_the_bridge_page_names_every_message_and_field():
    page = (TREE / "docs" / "reference" / "bridge.md").read_text(encoding="utf-8")
    protocol = page.split("## Protocol")[1].split("## Bounds")[0]
    named = set(re.findall(r"`(\w+)`", protocol))
    schema = json.loads((TREE / "docs" / "protocol.schema.json").read_text(encoding="utf-8"))
    parts = schema["$defs"]
    unions = parts["Request"], parts["ServerMessage"]
    messages = [parts[one["$ref"].rsplit("/", 1)[1]] for union in unions for one in union["anyOf"]]
    assert len(messages) > 20
    for message in messages:
        (kind,) = message["properties"]["type"]["enum"]
        fields = set(message["properties"]) - {"type"}
        assert {kind, *fields} <= named, message["title"]


def test_a_citation_of_what_is_not_there_is_found(tmp_path: Path):
    page = tmp_path / "page.md"
    page.write_text(
        "See `tests/no_such_test.py`, `no_such_file.py`, [a page](no-such-page.md), "
        "`glasshelm.no_such_module`, `figures.no_such_module.f`, `no_such_field` and "
        "scripts/no-such-script."
    )
    assert len(set(_missing(page))) == 7


# The style


def _style():
    spec = importlib.util.spec_from_file_location("prose", TREE / "scripts" / "check_prose.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.parametrize(
    "text",
    [
        "The ship maneuvers.",
        "The pilot and his rudder.",
        "She keeps her course.",
        "The ship whom the pilot sees.",
        "The user is told the reason.",
        "The the ship turns.",
        "A ship " + "turns and " * 50 + "stops.",
        "| a cell | that is nowhere |",
    ],
)
def test_poor_style_is_found(tmp_path: Path, text: str, capsys: pytest.CaptureFixture[str]):
    page = tmp_path / "page.md"
    page.write_text(f"# A title\n\nA sound sentence.\n\n{text}\n")
    assert _style().main([str(page)]) == 1
    assert "page.md:5: " in capsys.readouterr().out


def test_style_is_checked_in_docstrings_too(tmp_path: Path):
    module = tmp_path / "module.py"
    module.write_text('"""The pilot, whom nobody knows."""\n')
    assert _style().main([str(module)]) == 1


def test_code_and_titles_are_no_prose(tmp_path: Path):
    page = tmp_path / "page.md"
    page.write_text(
        "The `color` of a ship.\n\n    color = center\n\n```python\ncolor = whom\n```\n\n"
        "*Decoding Decision-Making Processes and Behavioral Intentions*\n"
    )
    assert _style().main([str(page)]) == 0


def test_cross_references_of_docstrings_resolve():
    references = [
        (f"{file.relative_to(TREE)}:{number}", file, name)
        for file in sorted(PACKAGE.rglob("*.py"))
        for number, line in enumerate(_text(file).splitlines(), 1)
        for name in re.findall(r":(?:mod|func|class|meth|data):`~?([^`]+)`", line)
    ]
    assert len(references) > 50
    assert [(place, name) for place, file, name in references if not _resolves(file, name)] == []


def _resolves(file: Path, name: str) -> bool:
    """A full name of any package, or a name or a method of the file itself."""
    if "." in name and importlib.util.find_spec(name.split(".")[0]) is not None:
        return _is_name(name) if name.startswith("glasshelm") else True
    defined = rf"(def |class |^\s*|import \(?|, ){re.escape(name.split('.')[-1])}\b"
    return re.search(defined, _text(file), re.MULTILINE) is not None


#: Values, not names: words that a class's docstring puts in double backticks.
_VALUES = {"_long", "inf", "none", "starboard", "port", "ship"}


def test_fields_that_docstrings_of_classes_name_exist():
    """A renamed field leaves no old name behind: each is an identifier of its file."""
    unknown = []
    for file in sorted(PACKAGE.rglob("*.py")):
        tree = ast.parse(_text(file))
        classes = [node for node in ast.walk(tree) if isinstance(node, ast.ClassDef)]
        code = re.sub(r'"""[^"]*"""', "", _text(file))
        known = set(re.findall(r"\w+", code)) | _VALUES
        for node in classes:
            named = re.findall(r"``([a-z_][a-z0-9_]*)``", ast.get_docstring(node) or "")
            unknown += [(file.name, node.name, name) for name in named if name not in known]
    assert unknown == []


def test_the_layers_of_the_documentation_are_those_that_ci_holds():
    contracts = tomllib.loads((TREE / "pyproject.toml").read_text())["tool"]["importlinter"]
    layers = "\n".join(contracts["contracts"][0]["layers"])
    page = (TREE / "docs" / "explanation" / "architecture.md").read_text(encoding="utf-8")
    assert f"```text\n{layers}\n```" in page
