"""Feeds that run while a test looks on."""

import asyncio
import contextlib
import time

from glasshelm.live.traffic_picture import TrafficPicture
from glasshelm.ship.nomoto import SHIPS

SHIP = SHIPS["paper"]


async def until(done, within_s=300.0):
    """Wait for something to become true; it takes as long as the machine is busy."""
    end = time.monotonic() + within_s
    while not done():
        assert time.monotonic() < end, "it did not happen"
        await asyncio.sleep(0.02)


@contextlib.asynccontextmanager
async def pictured(feed):
    """A picture that takes what a feed reports, until the end of the block."""
    picture = TrafficPicture(feed.title)

    async def take():
        async with contextlib.aclosing(feed.reports()) as reports:
            async for report in reports:
                picture.update(report)

    async with running(take()):
        yield picture


@contextlib.asynccontextmanager
async def running(work):
    """A task for as long as the block lasts; what it raises is raised here."""
    task = asyncio.create_task(work)
    try:
        yield task
    finally:
        task.cancel()
        with contextlib.suppress(asyncio.CancelledError):
            await task


def shown(picture, now=None):
    """The targets of the scenario of now, by id."""
    now = now or picture.now()
    scenario = None if now is None else picture.scenario(now, SHIP)
    if scenario is None:
        return {}
    here = scenario.encounter.present.tolist()
    return {info.id: info for info, there in zip(scenario.targets, here, strict=True) if there}
