"""Far more ships than are kept, as fast as they come: how fast is a picture, and how long a look?

    python benchmarks/feeds_flood.py [--ships 100000] [--reports 300000]

Own ship, 50 ships within 10 km of her and the others all over the sea report in turn. Prints
the reports taken in a second of processor time, that of a look (the median of 20) with the
picture full, and how many of the 50 near ships it shows.
"""

import argparse
import math
import os
import platform
import random
import statistics
import time
from collections.abc import Iterator
from datetime import UTC, datetime, timedelta

os.environ.setdefault("JAX_PLATFORMS", "cpu")

from glasshelm.ais.reports import Report
from glasshelm.live.traffic_picture import TrafficPicture
from glasshelm.ship.nomoto import SHIPS

NEAR = 50
BEGIN = datetime(2026, 6, 1, tzinfo=UTC)
#: Reports that share a second, own ship's one among them.
A_SECOND = 5000


def flood(ships: int, reports: int, seed: int = 0) -> Iterator[Report]:
    """Reports of own ship, of ``NEAR`` ships near her, and of all others anywhere."""
    chance = random.Random(seed)
    places = [
        (58.0 + (reach := 0.09 if k < NEAR else 20.0) * chance.uniform(-1, 1),
         10.0 + reach * chance.uniform(-1, 1))
        for k in range(ships)
    ]  # fmt: skip
    for i in range(reports):
        time_s = i // A_SECOND
        if i % A_SECOND == 0:
            number, (latitude, longitude), own = "own", (58.0, 10.0), True
        else:
            near = i % (A_SECOND // NEAR) == 1
            k = i // (A_SECOND // NEAR) % NEAR if near else i % ships
            number, (latitude, longitude), own = str(257_000_000 + k), places[k], False
        yield Report(
            id=number,
            time=BEGIN + timedelta(seconds=time_s),
            latitude_deg=latitude,
            longitude_deg=longitude,
            course_rad=math.pi / 2,
            speed_m_s=0.1,
            is_own=own,
        )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--ships", type=int, default=100_000)
    parser.add_argument("--reports", type=int, default=300_000)
    options = parser.parse_args()
    given = list(flood(options.ships, options.reports))
    picture = TrafficPicture("flood")
    start = time.process_time()
    for report in given:
        picture.update(report)
    rate = len(given) / (time.process_time() - start)
    now, looks, scenario = picture.latest_time, [], None
    assert now is not None
    for _ in range(21):
        start = time.process_time()
        scenario = picture.scenario(now, SHIPS["paper"])
        looks.append(time.process_time() - start)
    assert scenario is not None
    near = {str(257_000_000 + k) for k in range(NEAR)}
    shown = near & {target.id for target in scenario.targets}
    print(f"{platform.machine()}, {os.cpu_count()} cores, Python {platform.python_version()}")
    print(f"{rate:,.0f} reports a second of {options.ships:,} ships; {len(picture):,} are kept")
    print(f"a look takes {1000 * statistics.median(looks[1:]):.0f} ms")
    print(f"{len(shown)} of the {NEAR} near ships are shown")


if __name__ == "__main__":
    main()
