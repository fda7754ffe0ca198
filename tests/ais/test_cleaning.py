import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pyproj import Geod

from glasshelm.ais.cleaning import clean
from glasshelm.ais.table import ReportTable

GEOD = Geod(ellps="WGS84")
SHIP = 211_000_001


def voyage(count=20, every_s=10.0, sog_kn=12.0, cog_deg=40.0, mmsi=SHIP) -> ReportTable:
    """A ship on a straight course as she would report it."""
    time_s = 1e9 + every_s * np.arange(count)
    run = sog_kn * 1852 / 3600 * every_s * np.arange(count)
    lon, lat, _ = GEOD.fwd(np.full(count, 10.5), np.full(count, 59.0), np.full(count, cog_deg), run)
    full = np.full(count, 0.0)
    return ReportTable(
        time_s, np.full(count, mmsi), lat, lon, full + sog_kn, full + cog_deg, full + cog_deg
    )


def spoilt(reports: ReportTable, **columns) -> ReportTable:
    """The reports with some values replaced: ``column={row: value}``."""
    changed = {}
    for name, values in columns.items():
        column = getattr(reports, name).copy()
        for row, value in values.items():
            column[row] = value
        changed[name] = column
    return dataclasses.replace(reports, **changed)


def joined(*tables: ReportTable) -> ReportTable:
    names = [f.name for f in dataclasses.fields(ReportTable)]
    return ReportTable(*(np.concatenate([getattr(t, n) for t in tables]) for n in names))


def test_a_sound_voyage_is_left_alone():
    before = voyage()
    after, notes = clean(before)
    assert notes == ()
    for field in dataclasses.fields(ReportTable):
        np.testing.assert_array_equal(getattr(after, field.name), getattr(before, field.name))


@pytest.mark.parametrize(
    "columns",
    [
        {"latitude_deg": {3: 91.0}},
        {"longitude_deg": {3: 181.0}},
        {"latitude_deg": {3: -95.0}},
        {"latitude_deg": {3: np.nan}},
        {"latitude_deg": {3: 0.0}, "longitude_deg": {3: 0.0}},
    ],
)
def test_impossible_positions_go(columns):
    after, notes = clean(spoilt(voyage(), **columns))
    assert len(after) == 19
    assert notes == ("1 report dropped: impossible position",)


def test_stations_are_no_ships():
    after, notes = clean(joined(voyage(), voyage(mmsi=992_111_111), voyage(mmsi=2_111_111)))
    assert set(after.mmsi) == {SHIP}
    assert notes[0].startswith("40 reports dropped: from a coast station")


def test_negative_course_is_mended():
    # 350° sent as 350 − 409.6.
    before = voyage(cog_deg=350.0)
    after, notes = clean(spoilt(before, cog_deg={4: 350 - 409.6, 5: 350 - 409.6}))
    np.testing.assert_allclose(after.cog_deg, 350.0)
    assert notes == ("2 reports with a negative course: 409.6° added",)


@pytest.mark.parametrize("code", [360.0, 409.5, 511.0, np.nan])
@pytest.mark.parametrize("row", [0, 10])
def test_course_not_available_is_taken_from_positions(code, row):
    before = spoilt(voyage(cog_deg=40.0), cog_deg={row: code})
    after, notes = clean(before)
    np.testing.assert_allclose(after.cog_deg, 40.0, atol=0.5)
    assert notes == ("1 report without course: taken from positions or heading",)


def test_course_of_a_ship_at_rest_is_her_heading():
    still = spoilt(voyage(sog_kn=0.0), cog_deg=dict.fromkeys(range(20), 360.0))
    after, _ = clean(dataclasses.replace(still, heading_deg=np.full(20, 77.0)))
    np.testing.assert_array_equal(after.cog_deg, 77.0)
    nothing, _ = clean(dataclasses.replace(still, heading_deg=np.full(20, 511.0)))
    np.testing.assert_array_equal(nothing.cog_deg, 0.0)
    assert np.all(np.isnan(nothing.heading_deg))


@pytest.mark.parametrize("every_s", [1.0, 10.0, 180.0])
def test_position_only_reports_get_speed_and_course(every_s):
    bare = np.full(20, np.nan)
    before = voyage(every_s=every_s)
    after, notes = clean(dataclasses.replace(before, sog_kn=bare, cog_deg=bare, heading_deg=bare))
    np.testing.assert_allclose(after.sog_kn, 12.0, rtol=0.01)
    np.testing.assert_allclose(after.cog_deg, 40.0, atol=0.5)
    assert notes[0] == "20 reports without speed: taken from positions"


@pytest.mark.parametrize("code", [102.3, -1.0, 75.0])
def test_impossible_speed_is_taken_from_positions(code):
    after, notes = clean(spoilt(voyage(), sog_kn={7: code}))
    np.testing.assert_allclose(after.sog_kn, 12.0, rtol=0.01)
    assert notes == ("1 report without speed: taken from positions",)


def test_one_lonely_report_without_speed_tells_no_motion():
    lonely = spoilt(voyage(count=1, mmsi=SHIP + 1), sog_kn={0: 102.3})
    after, notes = clean(joined(voyage(), lonely))
    assert set(after.mmsi) == {SHIP}
    assert notes == ("1 report dropped: neither a speed nor a second position to tell it from",)


def test_duplicates_go():
    table = voyage()
    copy = table.take(np.array([4, 4, 9]))
    after, notes = clean(joined(table, copy))
    assert len(after) == 20
    assert "3 reports dropped: duplicate" in notes


def test_an_immediate_repeat_is_a_duplicate_a_later_one_is_not():
    table = voyage(sog_kn=0.0)
    again = dataclasses.replace(table, time_s=table.time_s + 0.5)
    after, _ = clean(joined(table, again))
    assert len(after) == 20
    later = dataclasses.replace(table, time_s=table.time_s + 5.0)
    after, notes = clean(joined(table, later))
    assert len(after) == 40
    assert not any("duplicate" in note for note in notes)


def test_times_out_of_order_are_sorted_and_counted():
    table = voyage()
    order = np.arange(20)
    order[[5, 6]] = [6, 5]
    after, notes = clean(table.take(order))
    np.testing.assert_array_equal(after.time_s, table.time_s)
    assert notes == ("1 report out of order in time: sorted",)


def test_a_jump_goes():
    far = {7: 59.5, 12: 58.0}
    after, notes = clean(spoilt(voyage(), latitude_deg=far))
    assert len(after) == 18
    assert notes == ("2 reports dropped: jump (faster than 60 kn)",)


def test_three_reports_that_agree_move_the_track():
    first, second = voyage(), voyage()
    second = dataclasses.replace(
        second, time_s=second.time_s + 300, latitude_deg=second.latitude_deg + 1.0
    )
    after, notes = clean(joined(first, second))
    assert len(after) == 40
    assert notes == ()


def test_two_reports_that_agree_do_not():
    after, notes = clean(spoilt(voyage(), latitude_deg={8: 60.0, 9: 60.0}))
    assert len(after) == 18
    assert notes == ("2 reports dropped: jump (faster than 60 kn)",)


def test_a_wrong_first_report_does_not_hold_the_track():
    after, notes = clean(spoilt(voyage(), latitude_deg={0: 10.0}))
    np.testing.assert_array_equal(after.time_s, voyage().time_s[1:])
    assert notes == ("1 report dropped: jump (faster than 60 kn)",)


def test_crossing_the_date_line_is_no_jump():
    table = voyage(cog_deg=90.0)
    crossing = np.where(table.longitude_deg < table.longitude_deg[10], 1, -1) * 180.0
    crossing = crossing + (table.longitude_deg - table.longitude_deg[10])
    after, notes = clean(dataclasses.replace(table, longitude_deg=crossing))
    assert (len(after), notes) == (20, ())


@settings(max_examples=15)
@given(st.integers(0, 10_000))
def test_order_of_rows_does_not_matter_and_all_is_finite(seed):
    rng = np.random.default_rng(seed)
    tables = [voyage(mmsi=SHIP + i, cog_deg=float(rng.uniform(0, 359))) for i in range(3)]
    whole = joined(*tables)
    bad = rng.choice(60, 6, replace=False)
    whole = spoilt(
        whole,
        latitude_deg={bad[0]: 91.0, bad[1]: 57.0},
        cog_deg={bad[2]: 409.5},
        sog_kn={bad[3]: 102.3},
        heading_deg={bad[4]: 511.0},
    )
    once, _ = clean(whole)
    again, _ = clean(whole.take(rng.permutation(60)))
    for field in dataclasses.fields(ReportTable):
        np.testing.assert_array_equal(getattr(once, field.name), getattr(again, field.name))
    for name in ("time_s", "latitude_deg", "longitude_deg", "sog_kn", "cog_deg"):
        assert np.all(np.isfinite(getattr(once, name)))
    assert np.all((once.cog_deg >= 0) & (once.cog_deg < 360))


def test_an_empty_table():
    after, notes = clean(voyage(count=0))
    assert (len(after), notes) == (0, ())
