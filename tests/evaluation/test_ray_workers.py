"""Over a Ray cluster the numbers are the same to the bit."""

import importlib.util
import sys

import numpy as np
import pytest
from tests.evaluation.test_result_cache import SUITE, jobs
from tests.missing import needed

from glasshelm.core.errors import InputError
from glasshelm.evaluation.ray_workers import executor_named
from glasshelm.evaluation.result_cache import run_job, run_locally

pytestmark = pytest.mark.slow

#: A crowded machine takes long to begin, and has little memory left: neither is for Ray to judge.
PATIENT = {
    "RAY_worker_register_timeout_seconds": "600",
    "RAY_health_check_timeout_ms": "60000",
    "RAY_health_check_failure_threshold": "20",
    "RAY_gcs_server_request_timeout_seconds": "300",
    "RAY_memory_monitor_refresh_ms": "0",
    "RAY_USAGE_STATS_ENABLED": "0",
}


@pytest.fixture
def two_workers(monkeypatch):
    """A Ray cluster of two processors; begun again if its parts do not find each other in time."""
    for name, value in PATIENT.items():
        monkeypatch.setenv(name, value)
    ray = needed("ray")
    for attempt in range(3):
        try:
            ray.init("local", num_cpus=2, include_dashboard=False, log_to_driver=False)
            break
        except Exception:
            ray.shutdown()
            if attempt == 2:
                raise
    yield
    ray.shutdown()


@pytest.mark.skipif(sys.version_info >= (3, 14), reason="Ray has no wheels for this Python")
def test_two_ray_workers_give_the_bits_of_this_process(two_workers):
    over_ray = dict(executor_named("ray")(jobs()))
    same_process = dict(run_locally(jobs()))
    assert sorted(over_ray) == sorted(same_process) == [0, 1, 2]
    for place, found in same_process.items():
        for name, values in found.items():
            np.testing.assert_array_equal(values, over_ray[place][name], err_msg=name)


def test_without_ray_one_line_says_what_to_install(monkeypatch):
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    with pytest.raises(InputError, match=r"glasshelm\[ray\]"):
        executor_named("ray")


def test_jobs_do_not_depend_on_who_does_them_in_which_order():
    """What Ray's workers rely on: a job is a pure function of itself."""
    given = jobs()
    backwards = {place: run_job(given[place]) for place in reversed(range(len(given)))}
    for place, found in run_locally(given):
        for name, values in found.items():
            np.testing.assert_array_equal(values, backwards[place][name])
    assert sum(len(job.indices) for job in given) == SUITE.size
