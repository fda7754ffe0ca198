import dataclasses

import msgspec
import pytest
from tests.bridge.frames import Other, frame

from glasshelm.bridge.annotate.alarms import AlarmList
from glasshelm.bridge.server.protocol import SetLimits

LIMITS = SetLimits(dcpa_m=1000.0, tcpa_s=300.0)
END_ON = Other()  # 6 km ahead, closing at 10 m/s: CPA 0 in 600 s


def told(alarms: AlarmList, time_s: float, *others: Other):
    return alarms.update(frame(time_s, *others))


def test_an_alarm_begins_when_both_are_below_the_limits_and_goes_with_its_cause():
    alarms = AlarmList(LIMITS)
    begun = [t for t in range(0, 700, 5) if told(alarms, t, END_ON)]
    assert begun[0] == 305  # TCPA 295 s: the first frame below 300
    assert begun == list(range(305, 615, 5))  # until the closest approach is 15 s past


def test_far_or_opening_ships_raise_none():
    alarms = AlarmList(LIMITS)
    aside = Other(east_m=1500.0)
    opening = Other(north_m=-500.0, course_deg=180.0)
    for t in range(0, 700, 5):
        assert told(alarms, t, aside, dataclasses.replace(opening, id="2")) == []


def test_a_value_that_trembles_about_its_limit_rings_once():
    alarms = AlarmList(LIMITS)
    ids = set()
    for k, east in enumerate([990.0, 1010.0] * 20):
        for alarm in alarms.update(frame(400.0, Other(east_m=east))):
            ids.add((alarm.id, alarm.since_s))
        assert len(ids) == 1, k
    assert alarms.update(frame(400.0, Other(east_m=1101.0))) == []
    assert alarms.update(frame(405.0, Other(east_m=1010.0))) == []
    again = alarms.update(frame(410.0, Other(east_m=990.0)))
    assert {(again[0].id, again[0].since_s)}.isdisjoint(ids)


def test_acknowledged_stays_acknowledged_until_the_cause_is_gone():
    alarms = AlarmList(LIMITS)
    (alarm,) = told(alarms, 400.0, END_ON)
    assert alarm.state == "unacknowledged"
    assert alarms.acknowledge(alarm.id)
    assert not alarms.acknowledge("cpa-99")
    assert [a.state for a in told(alarms, 500.0, END_ON)] == ["acknowledged"]
    assert told(alarms, 700.0, END_ON) == []
    assert not alarms.acknowledge(alarm.id)


def test_one_alarm_a_ship_the_soonest_first():
    alarms = AlarmList(LIMITS)
    other = Other(id="2", north_m=5500.0)
    assert [a.target for a in told(alarms, 320.0, END_ON, other)] == ["2", "1"]
    assert [a.target for a in told(alarms, 325.0, END_ON, other)] == ["2", "1"]


def test_a_lost_ship_raises_none_but_keeps_hers_while_she_is_shown():
    alarms = AlarmList(LIMITS)
    lost = dataclasses.replace(END_ON, lost=True)
    assert told(alarms, 400.0, lost) == []
    (alarm,) = told(alarms, 405.0, END_ON)
    (kept,) = told(alarms, 410.0, lost)
    assert kept.id == alarm.id
    assert "lost" in kept.cause
    assert told(alarms, 415.0) == []


def test_new_limits_hold_at_once():
    alarms = AlarmList(LIMITS)
    seen = frame(400.0, Other(east_m=1500.0))
    assert alarms.update(seen) == []
    alarms.limits = SetLimits(dcpa_m=2000.0, tcpa_s=300.0)
    assert len(alarms.update(seen)) == 1
    alarms.limits = SetLimits(dcpa_m=500.0, tcpa_s=300.0)
    assert alarms.update(seen) == []


def test_what_the_pilot_thinks_changes_no_alarm():
    plain = frame(400.0, END_ON)
    calm = {"q": 0.0, "q_far": 0.0, "priority": 0.0, "attention": 0.0, "danger": 0.0}
    afraid = {"q": -9.0, "q_far": 0.0, "priority": 5.0, "attention": 1.0, "danger": 1.0}
    lists = []
    for opinion in (calm, afraid):
        targets = [msgspec.structs.replace(t, **opinion) for t in plain.targets]
        lists.append(AlarmList(LIMITS).update(msgspec.structs.replace(plain, targets=targets)))
    assert lists[0] == lists[1]
    assert len(lists[0]) == 1


@pytest.mark.parametrize("field", ["dcpa_m", "tcpa_s"])
def test_the_cause_says_the_value_and_the_limit(field):
    (alarm,) = AlarmList(LIMITS).update(frame(400.0, Other(east_m=500.0)))
    assert alarm.cause == "CPA 0.27 NM in 3.3 min; limits 0.54 NM and 5 min"
    assert getattr(alarm, field) == pytest.approx({"dcpa_m": 500.0, "tcpa_s": 200.0}[field])
