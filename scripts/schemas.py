"""Write the JSON schemas of docs/ from the code: a frame, and all messages of the bridge.

`make types` runs it, and generates the page's types from the second one.
"""

import inspect
import json
from pathlib import Path
from typing import Any, Union

import msgspec

from glasshelm.bridge.server import protocol
from glasshelm.frames.schema import Frame

DOCS = Path(__file__).parents[1] / "docs"


def frame_schema() -> dict[str, Any]:
    """A line of a log."""
    return msgspec.json.schema(Frame)


def protocol_schema() -> dict[str, Any]:
    """What travels over the bridge's WebSocket: ``Request`` and ``ServerMessage``."""
    server_message = Union[tuple(protocol.ServerMessage.__subclasses__())]  # noqa: UP007
    (_, client, server), parts = msgspec.json.schema_components(
        [Frame, protocol.Request, server_message], ref_template="#/$defs/{name}"
    )
    unions = {"Request": client, "ServerMessage": server}
    anything = {"anyOf": [{"$ref": f"#/$defs/{name}"} for name in unions]}
    return {"title": "Message", **anything, "$defs": {**unions, **parts}}


def schema_files() -> dict[Path, str]:
    """The text of each schema file, with the indentation of docstrings removed."""
    schemas = {"frame": frame_schema(), "protocol": protocol_schema()}
    return {
        DOCS / f"{name}.schema.json": json.dumps(_clean(schema), indent=2, ensure_ascii=False)
        + "\n"
        for name, schema in schemas.items()
    }


def _clean(part: Any) -> Any:
    if isinstance(part, dict):
        return {
            name: inspect.cleandoc(value)
            if name == "description" and isinstance(value, str)
            else _clean(value)
            for name, value in part.items()
        }
    return [_clean(value) for value in part] if isinstance(part, list) else part


if __name__ == "__main__":
    for path, text in schema_files().items():
        path.write_text(text, encoding="utf-8")
