import pytest
from scripts import schemas


@pytest.mark.parametrize("path", schemas.schema_files(), ids=lambda path: path.name)
def test_the_published_schema_is_that_of_the_code(path):
    assert path.read_text(encoding="utf-8") == schemas.schema_files()[path], "run: make types"


def test_every_message_of_the_protocol_is_in_its_schema():
    parts = schemas.protocol_schema()["$defs"]
    sent = parts["ServerMessage"]["discriminator"]["mapping"]
    asked = parts["Request"]["discriminator"]["mapping"]
    assert {"hello", "session", "frame", "alarms", "whatif", "band"} <= set(sent)
    assert {"open", "seek", "acknowledge", "whatif"} <= set(asked)
    assert parts["History"]["properties"]["frames"]["items"] == {"$ref": "#/$defs/Frame"}
