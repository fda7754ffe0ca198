"""Chunks are sailed once, kept, and put together the same in whatever order they come."""

import dataclasses

import numpy as np
import pytest
from tests.evaluation.cases import ABEAM, HEAD_ON, SHIP, encounter, suite

from glasshelm.core.errors import InputError
from glasshelm.evaluation import result_cache as jobs_module
from glasshelm.evaluation.contenders import Contender
from glasshelm.evaluation.measure_columns import assemble
from glasshelm.evaluation.result_cache import (
    ResultCache,
    run_job,
    run_jobs,
    run_locally,
    split_into_jobs,
)
from glasshelm.pilots.straight import StraightPilot

STRAIGHT = Contender("straight", "paper", SHIP, (StraightPilot(),))
PLACES = [HEAD_ON, ABEAM, (3000.0, 4000.0, 250.0, 6.0), (-2500.0, 3000.0, 80.0, 5.0), HEAD_ON]
SUITE = suite(*(encounter(place) for place in PLACES), steps=24)


def jobs(chunk=2, of=SUITE):
    return list(split_into_jobs(of, 0, STRAIGHT, chunk))


def test_every_case_is_in_one_job_and_all_jobs_are_of_one_size():
    found = jobs()
    assert sorted(np.concatenate([job.indices for job in found]).tolist()) == [0, 1, 2, 3, 4]
    assert [job.cases.steps.shape for job in found] == [(2,)] * 3


def test_long_voyages_are_put_together():
    steps = np.array([24, 48, 24, 48, 24], np.int32)
    mixed = dataclasses.replace(SUITE, cases=dataclasses.replace(SUITE.cases, steps=steps))
    assert [job.steps for job in jobs(of=mixed)] == [24, 48, 48]


def test_a_key_tells_pilots_cases_and_steps_apart_and_nothing_else():
    first, second, third = jobs()
    assert len({first.key, second.key, third.key}) == 3
    assert jobs()[0].key == first.key
    other = dataclasses.replace(STRAIGHT, name="renamed")
    assert next(iter(split_into_jobs(SUITE, 3, other, 2))).key == first.key
    moved = suite(*(encounter(place) for place in PLACES[::-1]), steps=24)
    assert jobs(of=moved)[1].key != second.key


@pytest.mark.slow
def test_finished_chunks_are_not_sailed_again_and_results_are_the_same_to_the_bit(
    tmp_path, monkeypatch
):
    kept = ResultCache(tmp_path)
    begun = iter(run_jobs(jobs(), kept, run_locally))
    next(begun), next(begun)
    del begun  # interrupted in the middle of the third
    assert len(list(tmp_path.glob("*.npz"))) == 2
    sailed = []
    monkeypatch.setattr(jobs_module, "run_job", lambda job: sailed.append(job) or run_job(job))
    resumed = assemble(SUITE, STRAIGHT, 0, list(run_jobs(jobs(), kept, run_locally)))
    assert len(sailed) == 1
    afresh = assemble(SUITE, STRAIGHT, 0, [(job, run_job(job)) for job in reversed(jobs())])
    for name, values in resumed.columns.items():
        np.testing.assert_array_equal(values, afresh.columns[name], err_msg=name)
    for name, values in resumed.meetings.items():
        np.testing.assert_array_equal(values, afresh.meetings[name], err_msg=name)


def test_a_damaged_file_is_sailed_again(tmp_path):
    kept, job = ResultCache(tmp_path), jobs()[0]
    found = run_job(job)
    kept.write(job.key, found)
    assert kept.read(job.key) is not None
    kept.path(job.key).write_bytes(kept.path(job.key).read_bytes()[:300])
    assert kept.read(job.key) is None


def test_results_are_in_the_order_of_the_suite():
    found = assemble(SUITE, STRAIGHT, 0, [(job, run_job(job)) for job in jobs()])
    north = np.array([place[1] for place in PLACES])
    assert np.argmin(found.columns["nearest_m"]) == np.argmin(north)
    assert found.columns["nearest_m"][0] == found.columns["nearest_m"][4]


def test_a_pilot_that_gives_no_number_is_named():
    parts = [(job, run_job(job)) for job in jobs()]
    parts[1][1]["finite"] = np.zeros(2, bool)
    with pytest.raises(InputError, match="'straight' gave a rudder that is no number"):
        assemble(SUITE, STRAIGHT, 0, parts)
