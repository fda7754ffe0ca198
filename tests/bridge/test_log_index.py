import pytest
from tests.bridge.frames import frame

from glasshelm.bridge.sessions.log_index import (
    MAX_LISTED,
    LogIndex,
    default_log_dir,
    find_log,
    new_log_path,
)
from glasshelm.core.errors import InputError
from glasshelm.frames import frame_log


def test_a_new_log_never_replaces_one(tmp_path):
    paths = set()
    for _ in range(5):
        path = new_log_path(tmp_path, "random:7 / ../x", "paper-sum")
        assert path.parent == tmp_path
        assert not path.exists()
        path.touch()
        paths.add(path)
    assert len(paths) == 5


@pytest.mark.parametrize(
    "name",
    ["", ".", "..", "../secret.jsonl", "/etc/passwd", "a/../../secret.jsonl", "link.jsonl",
     "notes.txt", "secret.jsonl\0", "folder.jsonl", "..\\secret.jsonl"],
)  # fmt: skip
def test_only_plain_logs_of_the_folder_can_be_named(tmp_path, name):
    folder = tmp_path / "logs"
    folder.mkdir()
    (tmp_path / "secret.jsonl").write_text("{}")
    (folder / "link.jsonl").symlink_to(tmp_path / "secret.jsonl")
    (folder / "notes.txt").touch()
    (folder / "folder.jsonl").mkdir()
    (folder / "mine.jsonl").touch()
    assert find_log(folder, "mine.jsonl") == folder / "mine.jsonl"
    with pytest.raises(InputError, match="choose one of the catalogue"):
        find_log(folder, name)


def test_the_shelf_lists_whole_frames_the_newest_first(tmp_path):
    shelf = LogIndex(tmp_path)
    assert shelf.entries() == []
    assert LogIndex(tmp_path / "none").entries() == []
    start = "2014-08-15T17:00:00Z"
    for name, count in (("20260101T000000Z-a.jsonl", 3), ("20260102T000000Z-b.jsonl", 2)):
        frames = [frame(5 * k, time_utc=start) for k in range(count)]
        frame_log.write_log(tmp_path / name, frames)
    with open(tmp_path / "20260101T000000Z-a.jsonl", "ab") as torn:
        torn.write(b'{"time_s": 1')
    (tmp_path / "empty.jsonl").touch()
    (tmp_path / "other.jsonl").write_text("not a frame\n")
    assert [c.frames for c in shelf.entries()] == [2, 3]
    assert {c.time_utc for c in shelf.entries()} == {start}
    with open(tmp_path / "20260101T000000Z-a.jsonl", "ab") as more:
        more.write(b"}\n")
    assert [c.frames for c in shelf.entries()] == [2, 4]


def test_no_more_than_so_many_are_listed(tmp_path):
    for k in range(MAX_LISTED + 5):
        frame_log.write_log(tmp_path / f"{k:03d}.jsonl", [frame(0)])
    names = [card.name for card in LogIndex(tmp_path).entries()]
    assert len(names) == MAX_LISTED
    assert names[0] == f"{MAX_LISTED + 4:03d}.jsonl"


def test_the_default_folder_is_the_users(monkeypatch, tmp_path):
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path))
    assert default_log_dir() == tmp_path / "glasshelm" / "logs"
