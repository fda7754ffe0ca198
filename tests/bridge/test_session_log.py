import pytest
from tests.bridge.frames import Other, frame

from glasshelm.bridge.sessions import session_log
from glasshelm.bridge.sessions.session_log import FileLog
from glasshelm.core.errors import InputError
from glasshelm.frames import frame_log

FRAMES = [frame(5.0 * k, Other()) for k in range(20)]


def written(path, frames=FRAMES) -> FileLog:
    record = FileLog(path, fresh=True)
    for one in frames:
        record.append(one)
    return record


def test_the_record_is_a_log_and_a_log_is_a_record(tmp_path):
    record = written(tmp_path / "a.jsonl")
    assert list(frame_log.read_log(record.path)) == FRAMES
    record.close()
    again = FileLog(record.path, fresh=False)
    for one in (record_of(again), [again.frame(k) for k in range(len(again))]):
        assert one == FRAMES
    assert list(again.times) == [f.time_s for f in FRAMES]


def record_of(record: FileLog) -> list:
    return [session_log._decoder.decode(line) for line in record.lines(0, len(record))]


@pytest.mark.parametrize(("time_s", "number"), [(-1, 0), (0, 0), (4.9, 0), (5, 1), (1e6, 19)])
def test_a_time_is_found(tmp_path, time_s, number):
    assert written(tmp_path / "a.jsonl").index_at(float(time_s)) == number


def test_history_is_bounded_in_frames_and_in_bytes(tmp_path, monkeypatch):
    record = written(tmp_path / "a.jsonl")
    assert len(record.history(20)) == 20
    monkeypatch.setattr(session_log, "HISTORY_FRAMES", 7)
    assert record.history(20) == record.lines(13, 20)
    monkeypatch.setattr(session_log, "HISTORY_BYTES", 3 * (len(record.line(19)) + 1))
    assert record.history(20) == record.lines(17, 20)
    monkeypatch.setattr(session_log, "HISTORY_BYTES", 1)
    assert record.history(20) == record.lines(19, 20)
    assert record.history(0) == []


def test_a_torn_last_line_is_left_out_and_blank_lines_do_no_harm(tmp_path):
    record = written(tmp_path / "a.jsonl")
    text = record.path.read_bytes()
    lines = text.splitlines(keepends=True)
    record.path.write_bytes(b"\n" + lines[0] + b"\n\n" + b"".join(lines[1:]) + lines[0][:50])
    again = FileLog(record.path, fresh=False)
    assert record_of(again) == FRAMES


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        (b"", "no frame in it"),
        (b"{}\n", "line 1 is not a frame"),
        (b"\xff\xfe\n", "line 1 is not a frame"),
        (b"not json\n", "line 1 is not a frame"),
    ],
)
def test_what_is_no_log_is_one_clear_line_without_its_folder(tmp_path, text, problem):
    (tmp_path / "bad.jsonl").write_bytes(text)
    with pytest.raises(InputError, match=problem) as caught:
        FileLog(tmp_path / "bad.jsonl", fresh=False)
    assert str(tmp_path) not in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_log_that_goes_back_in_time_is_refused(tmp_path):
    written(tmp_path / "a.jsonl", [FRAMES[1], FRAMES[0]]).close()
    with pytest.raises(InputError, match="line 2 goes back in time"):
        FileLog(tmp_path / "a.jsonl", fresh=False)


def test_no_such_log(tmp_path):
    with pytest.raises(InputError, match="cannot read the log"):
        FileLog(tmp_path / "none.jsonl", fresh=False)
