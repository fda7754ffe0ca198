import pytest
from tests.missing import needed

from glasshelm.core.errors import InputError
from glasshelm.training.metrics_log import LOG, Records, read_records


def line(number):
    return {"stage": "actor", "number": number, "seconds": 1.0, "return": 0.5 * number}


def test_lines_come_back(tmp_path):
    records = Records(tmp_path, None, tensorboard=False)
    records.add(line(1))
    records.add(line(2))
    assert read_records(tmp_path) == [line(1), line(2)]


def test_resuming_drops_what_came_after_the_snapshot_and_a_torn_line(tmp_path):
    records = Records(tmp_path, None, tensorboard=False)
    for number in (1, 2, 3):
        records.add(line(number))
    with (tmp_path / LOG).open("a") as file:
        file.write('{"stage": "actor", "numb')
    Records(tmp_path, 2, tensorboard=False).add(line(3))
    assert [entry["number"] for entry in read_records(tmp_path)] == [1, 2, 3]


def test_tensorboard_gets_the_numbers(tmp_path):
    needed("tensorboardX")
    records = Records(tmp_path, None)
    records.add(line(1))
    records.close()
    (events,) = (tmp_path / "tensorboard").iterdir()
    assert b"actor/return" in events.read_bytes()


def test_a_folder_that_cannot_be_written_is_told_in_one_line(tmp_path):
    (tmp_path / "file").touch()
    with pytest.raises(InputError, match="file: cannot write there") as error:
        Records(tmp_path / "file", None, tensorboard=False)
    assert "\n" not in str(error.value)
