"""The same jobs over a Ray cluster: other machines, the same numbers to the bit."""

import importlib
import importlib.util
from collections.abc import Iterator, Sequence
from typing import Any, Literal

from glasshelm.core.errors import InputError
from glasshelm.evaluation.result_cache import Columns, Executor, Job, run_job, run_locally

ExecutorName = Literal["here", "ray"]
#: Jobs handed out for each processor: enough that none waits, few enough to stop soon.
_AHEAD = 2


def executor_named(name: ExecutorName, address: str | None = None) -> Executor:
    """``here``: this process. ``ray``: a Ray cluster, by default one of this machine's processors.

    InputError if Ray is not installed or the cluster cannot be reached.
    """
    if name == "here":
        return run_locally
    if importlib.util.find_spec("ray") is None:
        raise InputError(
            "--workers ray needs Ray, which is not installed: pip install 'glasshelm[ray]'"
        )
    return lambda jobs: _over_ray(jobs, address)


def _over_ray(jobs: Sequence[Job], address: str | None) -> Iterator[tuple[int, Columns]]:
    ray: Any = importlib.import_module("ray")
    if not jobs:
        return
    ours = not ray.is_initialized()
    if ours:
        try:
            ray.init(address=address, log_to_driver=False, include_dashboard=False)
        except (ConnectionError, ValueError, OSError) as error:
            raise InputError(f"no Ray cluster at {address} ({error})") from None
    try:
        remote = ray.remote(num_cpus=1)(run_job)
        ahead = max(_AHEAD * int(ray.cluster_resources().get("CPU", 1)), 1)
        waiting: dict[object, int] = {}
        places = iter(range(len(jobs)))
        for place in places:
            waiting[remote.remote(jobs[place])] = place
            if len(waiting) == ahead:
                break
        while waiting:
            (ready,), _ = ray.wait(list(waiting), num_returns=1)
            place = waiting.pop(ready)
            following = next(places, None)
            if following is not None:
                waiting[remote.remote(jobs[following])] = following
            yield place, ray.get(ready)
    finally:
        if ours:
            ray.shutdown()
