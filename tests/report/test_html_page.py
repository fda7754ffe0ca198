from html.parser import HTMLParser

import msgspec
import pytest
from tests.voyages import learned, plain, voyage

from glasshelm.core.errors import InputError
from glasshelm.figures.gallery import FIGURES
from glasshelm.frames.series import to_series
from glasshelm.report.html_page import html_page
from glasshelm.report.narrative import narrate
from glasshelm.report.write_report import write_report

SVG = b"<svg xmlns='http://www.w3.org/2000/svg'/>"
VOID = {"meta", "img", "br"}


class Reader(HTMLParser):
    """Collects elements; fails on one that is closed out of order."""

    def __init__(self):
        super().__init__()
        self.open, self.elements, self.text = [], [], []

    def handle_starttag(self, tag, attrs):
        self.elements.append((tag, dict(attrs)))
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        if self.open[-1:] != ["style"]:
            self.text.append(data)


def read(frames, missing=(), notes=(), title="A voyage"):
    v = to_series(frames)
    text = html_page(v, title, narrate(v), [(p, SVG, 1.0) for p in FIGURES[:2]], missing, notes)
    reader = Reader()
    reader.feed(text)
    assert reader.open == []
    return reader, text


def test_nothing_is_fetched():
    reader, text = read(learned())
    for tag, attrs in reader.elements:
        assert tag not in ("script", "link", "iframe")
        for name in ("src", "href"):
            assert attrs.get(name, "data:").startswith("data:")
    assert "url(" not in text
    assert "@import" not in text


def test_every_picture_has_words_and_every_column_a_heading():
    reader, _ = read(learned())
    pictures = [attrs for tag, attrs in reader.elements if tag == "img"]
    assert len(pictures) == 2
    assert all(len(attrs["alt"]) > 40 for attrs in pictures)
    headings = [attrs for tag, attrs in reader.elements if tag == "th"]
    assert all(attrs["scope"] in ("col", "row") for attrs in headings)


def test_headings_skip_no_level():
    reader, _ = read(learned())
    levels = [int(tag[1]) for tag, _ in reader.elements if tag in ("h1", "h2", "h3", "h4")]
    assert levels[0] == 1
    assert levels.count(1) == 1


def test_it_says_who_what_where_and_for_what_not():
    reader, _ = read(learned())
    text = " ".join(reader.text)
    for words in ("made", "by hand", "0123456789abcdef", "Not for navigation", "340 m", "Aurora"):
        assert words in text


def test_names_cannot_carry_markup():
    frames = [
        msgspec.structs.replace(
            f, targets=[msgspec.structs.replace(t, name="<b>x</b>&\"'") for t in f.targets]
        )
        for f in learned()
    ]
    reader, text = read(frames, title="<script>alert(1)</script>", notes=["<i>note</i>"])
    assert "<b>" not in text
    assert "<script" not in text
    assert "<i>" not in text
    assert "<b>x</b>" in " ".join(reader.text)


def test_a_plain_pilot_has_fewer_columns_and_says_why():
    full, _ = read(learned())
    bare, _ = read(plain(), missing=["Attention: not drawn, this pilot has no attention."])
    heads = [tag for tag, _ in full.elements].count("th") - 2  # two ships, two row headings
    assert [tag for tag, _ in bare.elements].count("th") - 1 < heads
    assert "this pilot has no attention" in " ".join(bare.text)
    assert "Largest priority" not in " ".join(bare.text)


def test_advice_is_announced():
    frames = voyage([0.0] * 20, applied=False)
    assert "Advice only" in " ".join(read(frames)[0].text)
    assert "Advice only" not in " ".join(read(plain())[0].text)


@pytest.mark.slow
def test_report_of_a_plain_pilot_as_files(tmp_path):
    steps = []
    path = write_report(plain(), tmp_path / "out", progress=lambda name, at: steps.append(at))
    assert path == tmp_path / "out" / "report.html"
    names = {p.name for p in (tmp_path / "out" / "figures").iterdir()}
    assert names == {
        f"{s}.{x}" for s in ("07_tracks", "08_relative", "motion") for x in ("pdf", "png")
    }
    text = path.read_text(encoding="utf-8")
    assert text.count("data:image/svg+xml") == 3
    assert "Priorities over time: not drawn" in text
    assert steps == sorted(steps)
    assert steps[-1] == 1.0


def test_a_place_that_cannot_be_written_is_one_line(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="cannot write the report"):
        write_report(plain(), tmp_path / "file")
