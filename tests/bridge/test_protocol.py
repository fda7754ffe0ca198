import json

import msgspec
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from glasshelm.bridge.server import protocol as m
from glasshelm.core.errors import InputError


@pytest.mark.parametrize(
    ("text", "wanted"),
    [
        ('{"type":"open","source":"imazu:5","pilot":"straight"}', m.Open("imazu:5", "straight")),
        ('{"type":"replay","log":"a.jsonl"}', m.Replay("a.jsonl")),
        ('{"type":"pilot","name":"straight"}', m.SetPilot("straight")),
        ('{"type":"compare","name":null}', m.Compare(None)),
        ('{"type":"play"}', m.Play()),
        ('{"type":"pause"}', m.Pause()),
        ('{"type":"rate","rate":60}', m.SetRate(60)),
        ('{"type":"seek","time_s":12.5}', m.Seek(12.5)),
        ('{"type":"acknowledge","id":"cpa-1"}', m.Acknowledge("cpa-1")),
        ('{"type":"limits","dcpa_m":926,"tcpa_s":600}', m.SetLimits(926, 600)),
        ('{"type":"whatif","change":"delete","ship":"1"}', m.AskWhatIf("delete", "1")),
        ('{"type":"whatif","change":"rudder","rudder_deg":-5}', m.AskWhatIf("rudder", None, -5)),
        ('{"type":"ping"}', m.Ping()),
    ],
)
def test_every_request_is_read(text, wanted):
    assert m.decode_request(text) == wanted
    assert m.decode_request(text.encode()) == wanted


@pytest.mark.parametrize(
    "text",
    [
        "", "null", "[]", "7", '"open"', "{}", '{"type":null}', '{"type":"fly"}', '{"type":"open"}',
        '{"type":"open","source":5}', '{"type":"rate","rate":0.5}', '{"type":"rate","rate":61}',
        '{"type":"rate","rate":"fast"}', '{"type":"rate","rate":NaN}', '{"type":"rate","rate":1e9}',
        '{"type":"seek","time_s":-1}', '{"type":"seek","time_s":Infinity}', '{"type":"seek"}',
        '{"type":"limits","dcpa_m":-1,"tcpa_s":60}', '{"type":"acknowledge","id":["cpa-1"]}',
        '{"type":"open","source":"' + "x" * 201 + '"}', '{"type":"play"', b"\xff\xfe", b"\x00",
        '{"type":"whatif"}', '{"type":"whatif","change":"sunk","ship":"1"}',
        '{"type":"whatif","change":"rudder","rudder_deg":91}',
        "[" * 5000, '{"type":' * 5000, '{"type":"ping","x":' + "[" * 30_000 + "]" * 30_000 + "}",
        '{"x":' * 10_000, '{"type":"ping","x":' + '{"y":' * 5000 + "1" + "}" * 5001,
        '{"type":"seek","time_s":1e999}', '{"type":"seek","time_s":' + "9" * 400 + "}",
        '{"type":"acknowledge","id":"\\ud800"}', "\ud800", '{"type":"replay","log":"\ud800"}',
        '{"type":"ping","x":"' + "ü" * (m.MAX_REQUEST_BYTES // 2) + '"}',
        '{"type":"limits","dcpa_m":null}', '{"type":"limits","tcpa_s":3601}',
        '{"type":"whatif","change":"keep_course","ship":"' + "x" * 201 + '"}',
 '{"type":"ping","x":"' + "y" * m.MAX_REQUEST_BYTES + '"}',
    ],
)  # fmt: skip
def test_what_is_no_request_is_one_line(text):
    with pytest.raises(InputError) as caught:
        m.decode_request(text)
    assert "\n" not in str(caught.value)
    assert len(str(caught.value)) < 300


def test_unknown_fields_are_left_alone():
    assert m.decode_request('{"type":"ping","of":"a later page"}') == m.Ping()


@settings(max_examples=300, deadline=None)
@given(st.one_of(st.text(), st.binary(), st.recursive(
    st.none() | st.booleans() | st.floats() | st.text(),
    lambda inner: st.lists(inner) | st.dictionaries(st.sampled_from(["type", "rate", "source"])
                                                    | st.text(), inner),
).map(json.dumps)))  # fmt: skip
def test_nothing_else_than_a_request_or_one_line_comes_of_any_text(text):
    try:
        said = m.decode_request(text)
    except InputError as error:
        said = str(error).count("\n")
    assert said == 0 or isinstance(said, m.Request)


def test_what_is_said_carries_its_type():
    for said, kind in (
        (m.Pong(), "pong"),
        (m.ErrorMessage("no"), "error"),
        (m.Alarms([]), "alarms"),
    ):
        assert json.loads(m.encode(said).data)["type"] == kind


def test_every_field_of_every_request_is_bounded():
    """Strings in length, numbers on both sides."""

    def bounded(kind: msgspec.inspect.Type) -> bool:
        match kind:
            case msgspec.inspect.StrType():
                return kind.max_length is not None
            case msgspec.inspect.FloatType() | msgspec.inspect.IntType():
                return kind.ge is not None and kind.le is not None
            case msgspec.inspect.UnionType():
                return all(map(bounded, kind.types))
            case msgspec.inspect.LiteralType() | msgspec.inspect.NoneType():
                return True
        return False

    for request in m.Request.__args__:
        told = msgspec.inspect.type_info(request)
        assert all(bounded(field.type) for field in told.fields), request
