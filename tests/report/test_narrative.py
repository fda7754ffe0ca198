import numpy as np
from tests.voyages import Other, learned, plain, voyage

from glasshelm.report.narrative import narrate


def kinds(frames):
    return [s.kind for s in narrate(frames)]


def text_of(frames):
    return "\n".join(map(str, narrate(frames)))


def test_the_story_of_an_avoidance():
    text = text_of(learned())
    assert "Altering 30° to starboard to 030°" in text
    assert "2.9° of rudder for Aurora (CPA" in text
    assert "for the waypoint" in text
    assert "Returning to course, 30° to port to 000°" in text
    assert "Attention is mostly on Aurora too (90%)" in text
    assert text.index("Altering") < text.index("Returning")


def test_it_is_told_in_order_of_time():
    frames = [s.frame for s in narrate(learned())]
    assert frames == sorted(frames)


def test_passing_is_told_once_and_where():
    lines = [s for s in narrate(plain()) if s.kind == "passing"]
    assert len(lines) == 1
    assert "Aurora is at her nearest" in lines[0].text
    assert "clear of the domain" in lines[0].text


def test_far_ships_are_not_told_of():
    assert "passing" not in kinds(voyage([0.0] * 200, [Other("A", 9000, 3000, 270, 0.5)]))


def test_entering_the_domain_is_told_with_its_depth():
    frames = voyage([0.0] * 200, [Other("Aurora", 900, 0, 350, 5.0)])
    deepest = max(t.danger for f in frames for t in f.targets)
    (line,) = [s.text for s in narrate(frames) if s.kind == "domain"]
    assert deepest > 0.1
    assert line.startswith("Aurora")
    assert f"danger up to {deepest:.2f} of 1" in line


def test_a_ship_in_the_domain_from_the_beginning():
    text = text_of(voyage([0.0] * 50, [Other("Aurora", 300, 0, 0)]))
    assert "inside the domain from the beginning" in text
    assert "is there at the end" in text


def test_advice_says_what_would_have_been_and_what_was():
    frames = voyage(
        [0.0] * 60,
        [Other("Aurora", 0, 6000, 180, 4.0, share_deg=lambda k: 3.0)],
        alone_deg=lambda k: 1.0,
        rudder_deg=lambda k: 4.0 if 10 <= k < 40 else 0.0,
        applied=False,
    )
    text = text_of(frames)
    assert "The pilot would have put the rudder 4.0° to starboard for" in text
    assert ": 3.0° of rudder for Aurora (CPA" in text
    assert "The recorded ship kept her course" in text
    assert "Altering" not in text
    assert "ends on course 000°" in text


def test_advice_while_the_recorded_ship_turns():
    headings = [0.0] * 10 + list(np.linspace(0, -20, 30)) + [-20.0] * 10
    frames = voyage(headings, rudder_deg=lambda k: 3.0 if 8 <= k < 42 else 0.0, applied=False)
    assert "The recorded ship altered 20° to port" in text_of(frames)


def test_what_lies_outside_training_is_told():
    frames = voyage([0.0] * 40, outside_training=lambda k: ["own speed 20 kn, trained at 10 kn"])
    (first, *_) = narrate(frames)
    assert first.kind == "outside"
    assert "throughout" in first.text
    assert "own speed 20 kn" in first.text


def test_the_clock_of_the_source_is_used():
    frames = voyage([0.0] * 400, time_utc=lambda k: "2020-06-30T09:42:00+00:00")
    assert narrate(frames)[0].when == "09:42"


def test_one_frame_is_a_short_story():
    assert kinds(voyage([0.0])) == ["end"]
