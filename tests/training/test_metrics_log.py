import pytest
from tests.missing import needed

from glasshelm.core.errors import InputError
from glasshelm.training.metrics_log import LOG_FILE, MetricsLog, read_metrics


def line(number):
    return {"stage": "actor", "number": number, "seconds": 1.0, "return": 0.5 * number}


def test_lines_come_back(tmp_path):
    log = MetricsLog(tmp_path, None, tensorboard=False)
    log.add(line(1))
    log.add(line(2))
    assert read_metrics(tmp_path) == [line(1), line(2)]


def test_resuming_drops_what_came_after_the_snapshot_and_a_torn_line(tmp_path):
    log = MetricsLog(tmp_path, None, tensorboard=False)
    for number in (1, 2, 3):
        log.add(line(number))
    with (tmp_path / LOG_FILE).open("a") as file:
        file.write('{"stage": "actor", "numb')
    MetricsLog(tmp_path, 2, tensorboard=False).add(line(3))
    assert [entry["number"] for entry in read_metrics(tmp_path)] == [1, 2, 3]


def test_tensorboard_gets_the_numbers(tmp_path):
    needed("tensorboardX")
    log = MetricsLog(tmp_path, None)
    log.add(line(1))
    log.close()
    (events,) = (tmp_path / "tensorboard").iterdir()
    assert b"actor/return" in events.read_bytes()


def test_a_folder_that_cannot_be_written_is_told_in_one_line(tmp_path):
    (tmp_path / "file").touch()
    with pytest.raises(InputError, match="file: cannot write there") as error:
        MetricsLog(tmp_path / "file", None, tensorboard=False)
    assert "\n" not in str(error.value)
