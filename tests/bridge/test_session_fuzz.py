"""A whole live session under mangled traffic: bytes in at a socket, frames and alarms out.

``make fuzz`` does the same with a million lines and messages.
"""

import pytest
from benchmarks.session_fuzz import trial

pytestmark = pytest.mark.slow


@pytest.mark.parametrize("of_nmea", [True, False], ids=["NMEA 0183", "Signal K"])
def test_mangled_traffic_ends_no_session_and_leaves_nothing_behind(of_nmea):
    outcome = trial(of_nmea, 5000, seed=3)
    assert outcome.faults == []
    assert outcome.healed
    assert outcome.uncounted == 0
    assert outcome.heard > 5000
    assert outcome.frames >= 5
