"""What the documentation site is given while it is built: pages made from code, and notebooks.

mkdocs calls the ``on_...`` functions (``hooks`` in mkdocs.yml). With ``RUN_NOTEBOOKS=1`` the
tutorials are executed and shown with their output; a cell that fails ends the build.
"""

import importlib
import inspect
import json
import os
import re
import sys
import tempfile
import typing
from pathlib import Path

import docstring_parser
import jupytext
from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files
from nbconvert import MarkdownExporter
from nbformat import NotebookNode

TREE = Path(__file__).resolve().parents[1]

#: Files of the repository's root that are pages of the site.
PROJECT = {"CONTRIBUTING.md": "contributing.md", "CHANGELOG.md": "changelog.md",
           "SECURITY.md": "security.md"}  # fmt: skip


def on_files(files: Files, config: MkDocsConfig) -> Files:
    pages = {page: _project_page(TREE / name) for name, page in PROJECT.items()}
    pages["reference/cli.md"] = command_page()
    for notebook in sorted((TREE / "docs" / "tutorials").glob("*.py")):
        pages |= notebook_page(notebook, execute=bool(os.environ.get("RUN_NOTEBOOKS")))
    for path, content in pages.items():
        files.append(File.generated(config, path, content=content))
    return files


def on_page_markdown(markdown: str, **_: object) -> str:
    markdown = markdown.replace("<!-- frame schema -->", schema_tables())
    return markdown.replace("<!-- public api -->", public_names())


def on_page_content(html: str, **_: object) -> str:
    """Docstrings' cross-references (:func:`…`) as plain code; intervals on one line."""
    html = re.sub(r"(\[[-\d.,]+), ([-\d.,]+\])", r"\1,&nbsp;\2", html)
    return re.sub(r":(?:mod|func|class|meth|data):(?=<code>)", "", html)


def public_names() -> str:
    """A heading for everything that ``glasshelm`` exports."""
    import glasshelm

    names = sorted(name for name in glasshelm.__all__ if not name.startswith("_"))
    return "\n".join(f"::: glasshelm.{name}\n" for name in names)


def _project_page(path: Path) -> str:
    """A page of the repository's root, its links as they are within docs/."""
    return path.read_text(encoding="utf-8").replace("](docs/", "](")


# The command line


def command_page() -> str:
    """Every command of ``glasshelm`` with its options, from signatures and docstrings."""
    from glasshelm.cli import COMMANDS

    parts = ["# Command line", "`glasshelm COMMAND --help` prints the same."]
    for name in COMMANDS:
        run = importlib.import_module(f"glasshelm.cli.{name}").run
        doc = docstring_parser.parse(run.__doc__, docstring_parser.DocstringStyle.GOOGLE)
        parts += [f"## glasshelm {name}", doc.short_description or "", doc.long_description or ""]
        help_of = {
            param.arg_name: " ".join((param.description or "").split()) for param in doc.params
        }
        parts.append("\n".join(["| Option | Default | Meaning |", "|---|---|---|", *(
            f"| {option} | {default} | {_cell(help_of.get(parameter, ''))} |"
            for parameter, option, default in _options(run)
        )]))  # fmt: skip
    return "\n\n".join(part for part in parts if part) + "\n"


def _options(run: typing.Callable[..., None]) -> typing.Iterator[tuple[str, str, str]]:
    hints = typing.get_type_hints(run, include_extras=True)
    for name, parameter in inspect.signature(run).parameters.items():
        markers = getattr(hints[name], "__metadata__", ())
        renamed = next((m.name for m in markers if getattr(m, "name", None)), name)
        if any("Positional" in repr(m) or getattr(m, "positional", False) for m in markers):
            option = f"`{name.upper()}`"
        elif isinstance(parameter.default, bool):
            option = f"`--{renamed.replace('_', '-')}`, `--no-{renamed.replace('_', '-')}`"
        else:
            option = f"`--{renamed.replace('_', '-')}`"
        default = parameter.default
        if default is inspect.Parameter.empty:
            shown = "required"
        elif default is None or default in ((), []):
            shown = "–"
        elif isinstance(default, bool):
            shown = "yes" if default else "no"
        else:
            shown = f"`{' '.join(map(str, default)) if isinstance(default, tuple) else default}`"
        yield name, option, shown


def _cell(text: str) -> str:
    return text.replace("|", "\\|").replace("<", "&lt;")


# The schema of a frame


def schema_tables() -> str:
    """A table for each part of a frame, from docs/frame.schema.json."""
    parts = json.loads((TREE / "docs" / "frame.schema.json").read_text(encoding="utf-8"))["$defs"]
    lines: list[str] = []
    for name, part in parts.items():
        text = re.sub(r"``([^`]+)``", r"`\1`", part.get("description", ""))
        lines += [f"## {name}", "", text, "", "| Field | Type | Present |", "|---|---|---|"]
        required = part.get("required", ())
        for field, type_ in part["properties"].items():
            default = type_.get("default")
            known = "if known" if default is None else f"if not `{json.dumps(default)}`"
            present = "always" if field in required else known
            lines.append(f"| `{field}` | {_type(type_)} | {present} |")
        lines.append("")
    return "\n".join(lines)


def _type(schema: dict[str, typing.Any]) -> str:
    if "$ref" in schema:
        name = schema["$ref"].rsplit("/", 1)[1]
        return f"[{name}](#{name.lower()})"
    if "anyOf" in schema:
        return " or ".join(_type(one) for one in schema["anyOf"] if one.get("type") != "null")
    if schema.get("type") == "array":
        return f"list of {_type(schema['items'])}"
    return schema.get("type", "any")


# Notebooks


def notebook_page(path: Path, execute: bool) -> dict[str, str | bytes]:
    """The notebook as a Markdown page, and the pictures that its cells drew."""
    notebook = jupytext.read(path)
    notebook.metadata["language_info"] = {"name": "python"}  # colours, even if it is not run
    if execute:
        _run(notebook)
    exporter = MarkdownExporter()
    text, resources = exporter.from_notebook_node(
        notebook, {"output_files_dir": f"{path.stem}_files", "unique_key": path.stem}
    )
    pages: dict[str, str | bytes] = {f"tutorials/{path.stem}.md": text}
    for name, data in resources.get("outputs", {}).items():
        pages[f"tutorials/{name}"] = data
    return pages


def _run(notebook: NotebookNode) -> None:
    """Execute the cells in this environment, with this tree's package."""
    from jupyter_client.manager import AsyncKernelManager
    from nbclient import NotebookClient

    os.environ["PATH"] = f"{Path(sys.executable).parent}:{os.environ['PATH']}"
    os.environ["PYTHONPATH"] = str(TREE / "src")
    with tempfile.TemporaryDirectory() as folder:
        # Sockets of the file system: others on this machine cannot connect.
        kernel = AsyncKernelManager(kernel_name="python3", transport="ipc", ip=f"{folder}/kernel")
        place = {"metadata": {"path": folder}}
        NotebookClient(notebook, km=kernel, timeout=600, resources=place).execute()
