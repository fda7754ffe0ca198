"""A line a suite, a column a pilot: the rates are those of the columns."""

import dataclasses
import functools

import numpy as np

from glasshelm.evaluation.contenders import parse_contenders
from glasshelm.evaluation.evaluation_run import EvaluationResult, RunInfo
from glasshelm.evaluation.measure_columns import SuiteResult
from glasshelm.evaluation.result_report import overview
from glasshelm.evaluation.suites.random_suite import random_suite
from glasshelm.ship.nomoto import SHIPS

PILOTS = parse_contenders(("straight", "paper-cpa", "large-ship-cpa"), ("paper",))


@functools.cache
def suite():
    return random_suite(SHIPS["paper"], 8)


def sailed(name: str, pilot: int, hits: int) -> SuiteResult:
    rows = np.arange(8) < hits
    columns = {"collided": rows, "intruded": rows, "within_half_nm": rows, "ships": np.ones(8)}
    return SuiteResult(dataclasses.replace(suite(), name=name), PILOTS[pilot], 0, columns, {})


def of(*voyages: SuiteResult) -> str:
    return overview(EvaluationResult(voyages, (), RunInfo("command", "machine")))


def test_every_suite_has_a_line_and_every_pilot_a_column():
    text = of(sailed("easy", 0, 0), sailed("hard", 0, 4), sailed("hard", 1, 2))
    lines = text.split("\n")
    assert "| suite | encounters | straight | paper-cpa |" in lines
    assert "| easy | 8 | 0.00 % [0.00, 36.94] | – |" in lines
    hard = next(line for line in lines if line.startswith("| hard"))
    assert "50.00 % [15.70, 84.30] | 25.00 % [3.19, 65.09]" in hard
    assert text.count("| suite |") == 3  # collisions, intrusions, half a mile


def test_each_ship_has_tables_of_its_own():
    text = of(sailed("easy", 0, 0), sailed("hard", 2, 1), sailed("easy", 2, 1))
    assert text.count("| suite |") == 6
    large = text[text.index("`large_ship`") :]
    assert "straight" not in large


def test_one_suite_needs_no_overview():
    assert of(sailed("easy", 0, 0), sailed("easy", 1, 1)) == ""
