"""The report: Markdown tables of an examination, each saying where its numbers come from."""

from collections.abc import Sequence

import numpy as np

from glasshelm.colregs.compliance import GRADES, of_kind
from glasshelm.core.text import markdown_code, markdown_text
from glasshelm.evaluation.examination import Examined, of_suite, stacked, suites_of
from glasshelm.evaluation.markdown import markdown, percent
from glasshelm.evaluation.measure_columns import Sailed
from glasshelm.evaluation.overview import overview
from glasshelm.evaluation.statistics import (
    Interval,
    bootstrap,
    clopper_pearson,
    interquartile_mean,
    mean,
    rate,
    risk_ratio,
)
from glasshelm.evaluation.types import Suite

Seeds = Sequence[Sailed]


def report(examined: Examined, against: Sequence[str]) -> str:
    """All tables of an examination; ``against`` names the pilots that others are compared with."""
    parts = ["# Examination", _methods(), overview(examined)]
    for suite in suites_of(examined):
        entrants = of_suite(examined, suite.name)
        parts.append(f"## {markdown_text(suite.name)}\n\n{markdown_text(suite.note)}.")
        parts.append(_table("Safety", _SAFETY, entrants, examined))
        if suite.size <= 100:
            parts.append(_cases_table(suite, entrants, examined))
        counts = np.unique(entrants[0][0].columns["ships"])
        if suite.size > 100 and len(counts) > 1:
            parts.append(_by_ships(counts, entrants, examined))
        parts.append(_ratios(entrants, against, examined))
        parts.append(_table("Way and helm", _WAY, entrants, examined))
        parts.append(_rules(entrants, examined))
    parts.append(_timings(examined))
    return "\n\n".join(part for part in parts if part) + "\n"


def _methods() -> str:
    return (
        "Definitions: docs/reference/suites.md. In brackets 95 % intervals: Clopper-Pearson for "
        "rates of one training seed, Nam-Blackwelder score for paired ratios, percentile bootstrap "
        "for returns (encounters within their number of ships) and for everything over several "
        "seeds (seeds as wholes; rates of fewer than five events a seed at least as wide as the "
        "exact interval of one). All pilots on one ship met the same encounters. Meetings are "
        "taken as independent trials, though a voyage may have several."
    )


def caption(what: str, entrants: Sequence[Seeds], examined: Examined) -> str:
    """What a table shows, of how much, by which weights, on which machine, by which command."""
    sizes = {f"{seeds[0].suite.size:,} encounters × {_seeds(seeds)}" for seeds in entrants}
    source = examined.provenance
    return (
        f"**{what}.** {'; '.join(sorted(sizes))}. Weights (SHA-256): {_weights(entrants)}. "
        f"{source.machine}; glasshelm {source.version}. {markdown_code(source.command)}"
    )


def _seeds(seeds: Seeds) -> str:
    return f"{len(seeds)} seed{'s' if len(seeds) > 1 else ''}"


def _weights(entrants: Sequence[Seeds]) -> str:
    told = []
    for seeds in entrants:
        hashes = [f"`{one.weights}`" for one in seeds if one.weights]
        if hashes:
            told.append(f"{markdown_text(seeds[0].entrant.name)} {', '.join(hashes)}")
    return "; ".join(told) or "none has any"


PILOT = "pilot", "ship"


def label(seeds: Seeds) -> tuple[str, str]:
    entrant = seeds[0].entrant
    return entrant.name, entrant.ship_name


def _rate(column: str):
    def cell(seeds: Seeds) -> str:
        events = stacked(seeds, column)
        told = percent(rate(events))
        if len(seeds) > 1:
            worst = max(int(row.sum()) for row in events)
            told += f", worst seed {percent(clopper_pearson(worst, events.shape[1]))}"
        return told

    return cell


def _number(column: str, how, form: str, met: bool = False):
    def cell(seeds: Seeds) -> str:
        values = stacked(seeds, column)
        if met:
            values = values[:, np.isfinite(values).all(0)]
        return form.format(how(values.astype(np.float64))) if values.size else "–"

    return cell


def _iqm(column: str):
    def cell(seeds: Seeds) -> str:
        values = stacked(seeds, column).astype(np.float64)
        found = bootstrap(values, seeds[0].columns["ships"], interquartile_mean)
        return f"{found.value:.2f} [{found.low:.2f}, {found.high:.2f}]"

    return cell


def _percentile(q: float):
    return lambda values: float(np.percentile(values, q))


_SAFETY = {
    "collisions": _rate("collided"),
    "hulls touched": _rate("hulls_touched"),
    "domain intrusions": _rate("intruded"),
    "in 1200 s: collisions": _rate("collided_1200s"),
    "intrusions": _rate("intruded_1200s"),
    "depth, 99th percentile": _number("depth", _percentile(99.0), "{:.2f}"),
    "nearest, 5th percentile [m]": _number("nearest_m", _percentile(5.0), "{:.0f}", met=True),
    "DCPA within 6 min, 5th percentile [m]": _number(
        "dcpa_m", _percentile(5.0), "{:.0f}", met=True
    ),
    "within 0.5 NM": _rate("within_half_nm"),
    "within 1 NM": _rate("within_1nm"),
}
_WAY = {
    "return, IQM": _iqm("return_total"),
    "waypoint": _iqm("return_waypoint"),
    "collision, mean": _number("return_collision", mean, "{:.2f}"),
    "made good of the way sailed": lambda seeds: (
        f"{100 * stacked(seeds, 'progress_m').sum() / stacked(seeds, 'sailed_m').sum():.1f} %"
    ),
    "detour, mean [m]": _number("detour_m", mean, "{:.0f}"),
    "turned, mean [°]": _number("turned_deg", mean, "{:.0f}"),
    "rudder, mean of limit": _number("rudder", mean, "{:.2f}"),
    "rudder moved [°/min]": _number("rudder_moved_deg_min", mean, "{:.2f}"),
    "reversals": _number("reversals", mean, "{:.2f}"),
    "weaving": _rate("weaving"),
}


def _table(what: str, columns: dict, entrants: Sequence[Seeds], examined: Examined) -> str:
    header = [*PILOT, *columns]
    rows = [[*label(seeds), *(cell(seeds) for cell in columns.values())] for seeds in entrants]
    return f"{caption(what, entrants, examined)}\n\n{markdown(header, rows)}"


def _by_ships(counts: np.ndarray, entrants: Sequence[Seeds], examined: Examined) -> str:
    parts = []
    for what, column in (("Collisions", "collided"), ("Intrusions", "intruded")):
        header = [*PILOT, *(f"{n} ship{'' if n == 1 else 's'}" for n in counts)]
        rows = [
            [
                *label(seeds),
                *(
                    percent(rate(stacked(seeds, column)[:, seeds[0].columns["ships"] == n]))
                    for n in counts
                ),
            ]
            for seeds in entrants
        ]
        told = caption(f"{what} by number of ships", entrants, examined)
        parts.append(f"{told}\n\n{markdown(header, rows)}")
    return "\n\n".join(parts)


def _cases_table(suite: Suite, entrants: Sequence[Seeds], examined: Examined) -> str:
    """Which of a few named cases went wrong."""

    def named(seeds: Seeds, column: str, depth: bool) -> str:
        told = []
        for one in seeds:
            bad = np.flatnonzero(one.columns[column])
            deep = one.columns["depth"]
            names = [
                f"{suite.labels[i]} ({deep[i]:.2f})" if depth else suite.labels[i] for i in bad
            ]
            some = f": {', '.join(names)}" if 0 < len(bad) < suite.size else ""
            told.append(f"{len(bad)} of {suite.size}{some}")
        return "; ".join(told)

    rows = [
        [*label(seeds), named(seeds, "collided", False), named(seeds, "intruded", True)]
        for seeds in entrants
    ]
    told = caption("Cases (depth of Eq. 13); seeds apart by semicolons", entrants, examined)
    table = markdown([*PILOT, "collided", "intruded"], rows)
    return f"{told}\n\n{table}"


def _ratios(entrants: Sequence[Seeds], against: Sequence[str], examined: Examined) -> str:
    """Risk ratios against the reference pilots that were examined on the same ship."""
    parts = []
    for name in against:
        theirs = {s[0].entrant.ship_name: s for s in entrants if s[0].entrant.name == name}
        rows = []
        for seeds in entrants:
            reference = theirs.get(seeds[0].entrant.ship_name)
            if reference is None or reference is seeds:
                continue
            cells = [*label(seeds)]
            for column in ("collided", "intruded", "within_half_nm"):
                found = risk_ratio(stacked(seeds, column), stacked(reference, column))
                cells.append(_ratio(found))
            rows.append(cells)
        if rows:
            header = [*PILOT, "collisions", "domain intrusions", "within 0.5 NM"]
            told = caption(f"Risk ratio against {markdown_text(name)}, paired", entrants, examined)
            parts.append(f"{told}\n\n{markdown(header, rows)}")
    return "\n\n".join(parts)


def _ratio(found: Interval | None) -> str:
    if found is None:
        return "– (never)"
    return f"{found.value:.4f} [{found.low:.4f}, {found.high:.4f}]"


def _rules(entrants: Sequence[Seeds], examined: Examined) -> str:
    """One table a kind of meeting: the share of meetings in which each thing was done."""
    parts = []
    for kind, judgements in GRADES.items():
        rows = []
        for seeds in entrants:
            cells = [*label(seeds)]
            for alone in (False, True):
                # The first seed's only: meetings differ from seed to seed.
                facts = of_kind(seeds[0].meetings, kind, alone)
                count = len(facts["kind"])
                cells.append(str(count))
                for judge in judgements.values() if count else ():
                    cells.append(percent(clopper_pearson(int(judge(facts).sum()), count)))
                cells += ["–"] * (0 if count else len(judgements))
            rows.append(cells)
        if all(row[2] == "0" for row in rows):
            continue
        told = caption(f"COLREGs, {kind.name.lower().replace('_', ' ')}", entrants, examined)
        both = ["meetings", *judgements, "alone: meetings", *judgements]
        parts.append(f"{told} {_UNTAUGHT}\n\n{markdown(['pilot | ship', *both], rows)}")
    return "\n\n".join(parts)


_UNTAUGHT = (
    "The paper's pilot was never taught the Rules: this says how far it happens to keep them. "
    "Targets never give way, so a stand-on ship that holds on to the end collides. "
    "Rule numbers in brackets; `alone`: voyages with no other meeting; first seed."
)


def _timings(examined: Examined) -> str:
    rows = [[t.pilot, t.ship_name, f"{t.p50_ms:.2f}", f"{t.p99_ms:.2f}"] for t in examined.timings]
    source = examined.provenance
    return (
        "## Time to decide\n\n**From an observation of six ships to a rudder, without "
        f"explanation.** {source.machine}; glasshelm {source.version}. "
        f"{markdown_code(source.command)}\n\n"
        + markdown(["pilot", "ship", "p50 [ms]", "p99 [ms]"], rows)
    )
