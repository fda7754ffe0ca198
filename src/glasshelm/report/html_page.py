"""One self-contained HTML page: verdict, picture, story, ships, figures. No network, no script."""

import base64
import html
from collections.abc import Sequence
from importlib.resources import files

from glasshelm import __version__
from glasshelm.figures.gallery import FigureSpec
from glasshelm.figures.style import ship_styles
from glasshelm.frames.phrases import degrees, duration
from glasshelm.frames.series import Series
from glasshelm.report.narrative import Sentence
from glasshelm.report.passages import passages, verdict
from glasshelm.report.ship_table import ship_table
from glasshelm.ship.nomoto import KNOT_M_S

#: A figure wider than this [inches] takes a row of its own, and scrolls on a phone.
_WIDE_IN = 6.0
#: The table holds at most so many ships, beside those that the figures name.
MOST_ROWS = 12


def html_page(
    voyage: Series,
    title: str,
    sentences: Sequence[Sentence],
    drawn: Sequence[tuple[FigureSpec, bytes, float]],
    missing: Sequence[str],
    notes: Sequence[str] = (),
) -> str:
    """The report as HTML. ``drawn``: figures with their SVG and width in inches.

    The first figure is at the top, if there is any. ``missing`` tells in words which
    figures were not drawn, ``notes`` what was repaired while reading the source.
    """
    picture = "".join(
        _figure(spec, svg, width, f"{spec.caption} {verdict(voyage)}")
        for spec, svg, width in drawn[:1]
    )
    mode = "" if voyage.applied else _ADVISED
    parts = [
        f"<header><h1>{escaped(title)}</h1>",
        f'<p class="verdict">{escaped(verdict(voyage))}</p>',
        f'<p class="caution">Not for navigation. A simulation or replay for study.</p>{mode}'
        "</header>",
        "<main>",
        f'<div class="first">{picture}{_facts(voyage)}</div>',
        f"<h2>What happened</h2>{_story(sentences)}",
        _ships(voyage),
        "<h2>Figures</h2>",
        '<div class="plates">',
        *(_figure(spec, svg, width, _alt(spec, voyage)) for spec, svg, width in drawn[1:]),
        "</div>",
        _list("Not drawn", missing),
        _list("Notes on the source", notes),
        _READING,
        f"</main><footer>Written by Glasshelm {__version__}. Not for navigation.</footer>",
    ]
    return whole_page(title, "\n".join(parts))


def whole_page(title: str, body: str, more_style: str = "") -> str:
    """A page in our style that loads nothing from anywhere.

    Args:
        title: As text.
        body: As HTML.
        more_style: CSS that comes after our own.
    """
    style = files("glasshelm.report").joinpath("page.css").read_text(encoding="utf-8")
    return _SHELL.format(title=escaped(title), style=style + more_style, body=body)


_SHELL = """<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta http-equiv="Content-Security-Policy" content="default-src 'none'; img-src data:; style-src 'unsafe-inline'">
<title>{title}</title>
<style>
{style}</style>
</head>
<body>
{body}
</body>
</html>
"""  # noqa: E501

_ADVISED = (
    '<p class="caution">Advice only: the recorded ship kept her own track. Each advice is for '
    "where she really was; none was followed.</p>"
)

_READING = """<h2>How to read it</h2>
<p class="soft">The <em>domain</em> is the region around own ship of Eq. 14-15; danger is 0 on its
edge and 1 at own ship (Eq. 13). <em>Q</em> is the critic's estimate of the discounted reward to
come, in units of reward; a <em>priority</em> (Eq. 22) is Q of the chosen rudder minus Q of rudder
0, split into waypoint and ships: positive means that the rudder is better for it. <em>Course
value</em> is the waypoint's share. <em>Attention</em> (Eq. 23) is how the actor weighs the ships;
<em>intention</em> (Eq. 24) is a ship's priority times her attention. Reasons in the story are means
over the frames in which the rudder was on the side of the turn. CPA is at constant course and
speed from the instant named.</p>"""


def escaped(words: str) -> str:
    """Text as HTML."""
    return html.escape(words, quote=True)


def _figure(spec: FigureSpec, svg: bytes, width_in: float, alt: str) -> str:
    broad = ' class="broad"' if width_in > _WIDE_IN else ""
    return (
        f"<figure{broad}><h3>{escaped(spec.title)}</h3>{image(svg, alt, width_in > _WIDE_IN)}"
        f"<figcaption>{escaped(spec.caption)}</figcaption></figure>"
    )


def image(svg: bytes, alt: str, wide: bool) -> str:
    """A drawing inside the page; one that is ``wide`` scrolls on a phone."""
    data = base64.b64encode(svg).decode("ascii")
    return (
        f'<div class="plate{" wide" if wide else ""}">'
        f'<img alt="{escaped(alt)}" src="data:image/svg+xml;base64,{data}"></div>'
    )


def _alt(spec: FigureSpec, voyage: Series) -> str:
    ships = ", ".join(look.label for look in ship_styles(voyage).values())
    return f"{spec.caption} Ships: {ships or 'none'}."


def _facts(voyage: Series) -> str:
    frame = voyage.frames[0]
    ship, own = frame.ship, float(voyage.speed_m_s[0]) / KNOT_M_S
    rate = "at once" if ship.rudder_rate_rad_s is None else f"{degrees(ship.rudder_rate_rad_s)}/s"
    span = float(voyage.time_s[-1] - voyage.time_s[0])
    start = voyage.start_utc
    rows = [
        ("Source", frame.source),
        ("Pilot", frame.pilot + ("" if voyage.applied else " (advice only)")),
        ("Weights", f"SHA-256 {frame.weights_sha256[:16]}…" if frame.weights_sha256 else "none"),
        ("Own ship", f"{ship.loa_m:.0f} m long, {ship.beam_m:.0f} m wide, {own:.1f} kn"),
        ("Steering", f"K {ship.K_1_s:g} 1/s, T {ship.T_s:g} s (Nomoto)"),
        ("Rudder", f"up to {degrees(ship.rudder_limit_rad)}, {rate}"),
        ("Begins", f"{start:%Y-%m-%d %H:%M:%S} UTC" if start else "at minute 0"),
        ("Lasts", f"{duration(span)}, {len(voyage.frames)} frames"),
        ("Other ships", str(len(voyage.ships))),
    ]
    cells = "".join(f"<dt>{escaped(k)}</dt><dd>{escaped(v)}</dd>" for k, v in rows)
    return f"<dl>{cells}</dl>"


def _story(sentences: Sequence[Sentence]) -> str:
    items = "".join(
        f'<li class="{s.kind}"><time>{escaped(s.when)}</time><p>{escaped(s.text)}</p></li>'
        for s in sentences
    )
    return f'<ol class="story">{items}</ol>'


def _ships(voyage: Series) -> str:
    everyone = passages(voyage)
    if not everyone:
        return ""
    by_id = ship_styles(voyage)
    found = [p for i, p in enumerate(everyone) if i < MOST_ROWS or p.ship.id in by_id]
    columns, rows = ship_table(voyage, found)
    left = len(everyone) - len(found)
    more = f'<p class="soft">{left} more ships, farther off, are in the frames.</p>' if left else ""
    head = "".join(f'<th scope="col"{_side(c.number)}>{escaped(c.heading)}</th>' for c in columns)
    body = []
    for passage, row in zip(found, rows, strict=True):
        look = by_id.get(passage.ship.id)
        colour = look.colour if look else "#b8bfc6"
        name = f'<span class="chip" style="background:{colour}"></span>{escaped(row[0])}'
        cells = "".join(
            f"<td{_side(c.number)}>{escaped(cell)}</td>"
            for c, cell in zip(columns[1:], row[1:], strict=True)
        )
        body.append(f'<tr><th scope="row">{name}</th>{cells}</tr>')
    return (
        '<h2>Ships, the nearest first</h2><div class="scroll" tabindex="0" role="region" '
        f'aria-label="Table of ships"><table><thead><tr>{head}</tr></thead>'
        f"<tbody>{''.join(body)}</tbody></table></div>{more}"
    )


def _side(number: bool) -> str:
    return ' class="number"' if number else ""


def _list(heading: str, lines: Sequence[str]) -> str:
    if not lines:
        return ""
    items = "".join(f"<li>{escaped(line)}</li>" for line in lines)
    return f'<h2>{escaped(heading)}</h2><ul class="plain soft">{items}</ul>'
