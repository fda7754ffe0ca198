"""What waits between two looks: bounded, in its order, and of too much the right part."""

import itertools

from tests.live.reports import own, ship, targets

from glasshelm.live import report_queue
from glasshelm.live.report_queue import MAX_OTHERS, MAX_OWN, MIN_DRAINED, ReportQueue
from glasshelm.live.traffic_picture import TrafficPicture


class Noted(TrafficPicture):
    """Notes what it takes."""

    def __init__(self):
        super().__init__()
        self.taken = []

    def update(self, report):
        self.taken.append((report.id, report.time))
        return super().update(report)


def test_all_that_waits_is_taken_in_its_order():
    waiting, picture = ReportQueue(), Noted()
    given = [own(k) if k % 3 == 0 else ship(k, k, 1000.0 * k) for k in range(50)]
    for report in given:
        waiting.put(report)
    assert len(waiting) == 50
    waiting.drain_into(picture)
    assert picture.taken == [(report.id, report.time) for report in given]
    assert (len(waiting), waiting.n_dropped) == (0, 0)


def test_of_too_much_the_picture_is_of_now(monkeypatch):
    """A look that can afford 500: own ship, the latest, and the last of those nearest to her."""
    waiting, picture = ReportQueue(), Noted()
    for report in (own(), ship(1), ship(2, 0, 3000.0)):
        waiting.put(report)
    waiting.drain_into(picture)
    assert set(targets(picture)) == {"1", "2"}
    clock = itertools.count()
    monkeypatch.setattr(report_queue.time, "monotonic", lambda: next(clock) / 1e4)
    waiting._affordable = MIN_DRAINED
    given = [own(k / 100, k / 20) for k in range(100)]
    given += [ship(n, 1 + k / 1000, 2000.0 + 1000 * (n - 1)) for k in range(300) for n in (1, 2)]
    given += [ship(k, 2, 5000.0 + k) for k in range(1000, 6000)]
    for report in given:
        waiting.put(report)
    picture.taken = []
    waiting.drain_into(picture)
    near, late = MIN_DRAINED // 2 - 2, MIN_DRAINED // 2
    expected = [*given[:100], *given[698 : 700 + near], *given[-late:]]
    assert picture.taken == [(report.id, report.time) for report in expected]
    assert waiting.n_dropped == len(given) - len(expected)


def test_a_look_that_takes_too_long_ends_and_the_next_takes_less(monkeypatch):
    waiting, picture = ReportQueue(), Noted()
    clock = itertools.count()
    monkeypatch.setattr(report_queue.time, "monotonic", lambda: next(clock) / 1e3)
    for k in range(5000):
        waiting.put(ship(k, 0, 10.0 * k))
    waiting.drain_into(picture)
    assert 0 < len(picture.taken) <= 1001
    assert waiting.n_dropped == 5000 - len(picture.taken)
    assert waiting._affordable == MIN_DRAINED


def test_what_waits_is_bounded_and_own_ship_s_is_not_washed_away():
    waiting = ReportQueue()
    waiting.put(own())
    for k in range(2 * MAX_OTHERS):
        waiting.put(ship(k % 10, k / 100))
    assert len(waiting) == MAX_OTHERS + 1
    for k in range(2 * MAX_OWN):
        waiting.put(own(k / 100))
    assert len(waiting) == MAX_OTHERS + MAX_OWN
