"""One self-contained page: every equation, figure and table beside what the paper says of it."""

from collections.abc import Sequence

from glasshelm import __version__
from glasshelm.core.errors import InputError
from glasshelm.evaluation.measure_columns import SuiteResult
from glasshelm.evaluation.statistics import rate_interval
from glasshelm.paper.paper_figures import LEARNING, MadeFigure
from glasshelm.paper.paper_items import EQUATIONS, FIGURES, PaperFigure
from glasshelm.paper.parameter_tables import ParameterTable
from glasshelm.paper.reproduce import PaperResult
from glasshelm.report.html_page import escaped, image, whole_page

_TITLE = "Explainable AI for Ship Collision Avoidance, made again"
_STYLE = """
/* Light, also where the system is dark: it is meant to be printed. */
:root { color-scheme: light; --ink: #1b1f24; --soft: #56606b; --line: #d5dade; --ground: #fff;
  --card: #fff; --paper: #fff; --warn: #8a4b00; --warn-ground: #fff4e0; }
main > section { border-top: 1px solid var(--line); padding-top: .4rem; margin-top: 1.6rem; }
h3 { font-size: 1.08rem; margin: .9rem 0 .5rem; }
.says { display: grid; gap: .2rem 1.6rem; grid-template-columns: minmax(0, 1fr); }
@media (min-width: 44rem) { .says { grid-template-columns: repeat(2, minmax(0, 1fr)); } }
.says h4 { margin: 0; font-size: .85rem; color: var(--soft); font-weight: 600; }
.says p { margin: 0 0 .4rem; }
figure { border: 0; padding: 0; margin: .9rem 0 1.2rem; }
figure .by { font-weight: 600; color: var(--ink); }
.plate img { max-width: 56rem; }
.plate.narrow img { max-width: 34rem; margin: 0; }
.differs { background: var(--warn-ground); }
td, th { min-width: 0; vertical-align: top; }
td.why { color: var(--soft); }
nav a { margin-right: .7rem; white-space: nowrap; }
dd code { overflow-wrap: anywhere; }
td code { white-space: nowrap; font-size: .8rem; }
@media print { h3, h4 { break-after: avoid; } tr { break-inside: avoid; } nav { display: none; }
  body { font-size: .85rem; } main, header, footer { max-width: none; } }
"""
#: Diagrams that are drawn in a single panel.
_NARROW = ("3", "4")


def paper_page(result: PaperResult) -> str:
    """The page as HTML. It loads nothing from anywhere. InputError if a figure cannot be read."""
    parts = [
        f"<header><h1>{escaped(_TITLE)}</h1>{_about(result)}</header><main>",
        _safety(result.rates),
        f'<section id="equations"><h2>Equations</h2>{_equations(result.held)}</section>',
        '<section id="figures"><h2>Figures</h2>',
        *(_figure(figure, _made(result, number)) for number, figure in FIGURES.items()),
        _learning(_made(result, LEARNING)),
        "</section>",
        '<section id="tables"><h2>Tables</h2>',
        "<p>Marked: a value that differs from the paper's, and why.</p>",
        *map(_table, result.tables),
        "</section>",
        f"</main><footer>Written by Glasshelm {__version__} on {escaped(result.run_info.machine)}. "
        "Not for navigation.</footer>",
    ]
    return whole_page(_TITLE, "\n".join(parts), _STYLE)


def _made(result: PaperResult, number: str) -> list[MadeFigure]:
    return [figure for figure in result.figures if figure.number == number]


def _about(result: PaperResult) -> str:
    pilots = "".join(f"<li>{escaped(pilot.identity)}</li>" for pilot in result.pilots)
    links = "".join(f'<a href="#f{n}">Fig. {n}</a>' for n in FIGURES)
    tables = "".join(f'<a href="#t{t.number}">Table {t.number}</a>' for t in result.tables)
    encounters = ", ".join(result.encounters)
    return (
        "<p>Every figure and table of Yoshioka and Hashimoto (arXiv 2405.09081), computed anew, "
        "beside what the paper says of it in our words. None of its text or pictures is used. Its "
        "scenarios and weights are not published: encounters are of its kind (Eq. 8-9), and "
        "pilots were trained by us.</p>"
        f"<dl><dt>Command</dt><dd><code>{escaped(result.run_info.command)}</code></dd>"
        f"<dt>Encounters</dt><dd>{escaped(encounters)}</dd></dl>"
        f'<ul class="plain">{pilots}</ul><nav>{links} {tables}</nav>'
    )


def _equations(held: dict[str, str]) -> str:
    rows = []
    for equation in EQUATIONS:
        reading = escaped(equation.reading) or "As printed."
        check = held.get(equation.number, "")
        differs = ' class="differs"' if equation.reading else ""
        rows.append(
            f'<tr><th scope="row">{equation.number}</th><td>{escaped(equation.gives)}</td>'
            f"<td{differs}>{reading}</td><td><code>{escaped(equation.code)}</code></td>"
            f"<td>{escaped(check)}</td></tr>"
        )
    heads = ("Eq.", "What it gives", "How it is read here", "Code", "Recomputed from frames")
    return _rows_table(heads, rows)


def _figure(figure: PaperFigure, made: Sequence[MadeFigure]) -> str:
    shown = "".join(_drawing(figure.number, figure.title, one) for one in made)
    if not made:
        shown = '<p class="soft">Not drawn: none of these pilots gives what it shows.</p>'
    return (
        f'<article id="f{figure.number}"><h3>Figure {figure.number}: {escaped(figure.title)} '
        f'<span class="soft">Eq. {figure.equations}</span></h3><div class="says">'
        f"<div><h4>The paper</h4><p>{escaped(figure.says)}</p></div>"
        f"<div><h4>Here</h4><p>{escaped(figure.made)}</p></div></div>{shown}</article>"
    )


def _learning(made: Sequence[MadeFigure]) -> str:
    return (
        '<article id="learning"><h3>Learning</h3><div class="says">'
        "<div><h4>The paper</h4><p>Shows no learning curves.</p></div>"
        "<div><h4>Here</h4><p>From the records beside the weights: 256 fixed encounters, validated "
        "while training.</p></div></div>"
        f"{''.join(_drawing(LEARNING, 'Learning', one) for one in made)}</article>"
    )


def _drawing(number: str, title: str, made: MadeFigure) -> str:
    by = "" if made.pilot is None else f'<span class="by">{escaped(made.pilot.identity)}.</span> '
    text = escaped(made.text)
    if made.path is None:
        return f'<p class="soft">{by}Not drawn: {text}</p>'
    try:
        svg = made.path.read_bytes()
    except OSError as error:
        raise InputError(f"{made.path}: cannot read it ({error.strerror})") from None
    alt = f"Figure {number}, {title}. {made.text}"
    drawn = image(svg, alt, wide=True)
    if number in _NARROW:
        drawn = drawn.replace("plate wide", "plate narrow")
    caption = f"<figcaption>{by}{text}</figcaption>" if by or text else ""
    return f"<figure>{drawn}{caption}</figure>"


def _table(table: ParameterTable) -> str:
    rows = []
    for row in table.rows:
        cells = []
        for value, reason in zip(row.values, row.reasons, strict=True):
            mark = ' class="differs"' if reason and row.paper != "not given" else ""
            cells.append(f"<td{mark}>{escaped(value)}</td>")
        why = "; ".join(dict.fromkeys(reason for reason in row.reasons if reason))
        rows.append(
            f'<tr><th scope="row">{escaped(row.name)}</th><td>{escaped(row.paper)}</td>'
            f'{"".join(cells)}<td class="why">{escaped(why)}</td></tr>'
        )
    heads = ("", "paper", *table.columns, "why it differs")
    return (
        f'<article id="t{table.number}"><h3>Table {table.number}: {escaped(table.title)}</h3>'
        f"{_rows_table(heads, rows)}</article>"
    )


def _rows_table(heads: Sequence[str], rows: Sequence[str]) -> str:
    head = "".join(f'<th scope="col">{escaped(h)}</th>' for h in heads)
    return (
        f'<div class="scroll"><table><thead><tr>{head}</tr></thead>'
        f"<tbody>{''.join(rows)}</tbody></table></div>"
    )


def _safety(rates: Sequence[SuiteResult]) -> str:
    if not rates:
        return ""
    rows = []
    for one in rates:
        cells = [_rate(one, column) for column in ("intruded_1200s", "intruded", "collided")]
        cells.append(f"{one.columns['return_total'].mean():.1f}")
        cells.append(f"{one.columns['reversals'].mean():.1f}")
        name = f"{one.contender.name} ({one.weights})" if one.weights else one.contender.name
        rows.append(
            f'<tr><th scope="row">{escaped(name)}</th>'
            + "".join(f"<td>{cell}</td>" for cell in cells) + "</tr>"
        )  # fmt: skip
    heads = ("pilot", "intrusions in 1200 s", "intrusions in all", "collisions",
             "return over 1200 s", "reversals a voyage")  # fmt: skip
    return (
        '<section id="safety"><h2>How safe the pilots are</h2>'
        "<p>The paper shows encounters in which nothing enters the domain, and gives no rates. "
        f"{rates[0].suite.size} random encounters of 0 to 6 ships, the same for all, 40 minutes or "
        "longer; in brackets 95 % intervals.</p>" + _rows_table(heads, rows) + "</section>"
    )


def _rate(one: SuiteResult, column: str) -> str:
    rate = rate_interval(one.columns[column][None].astype(bool))
    return f"{100 * rate.value:.1f} % [{100 * rate.low:.1f}, {100 * rate.high:.1f}]"
