"""The report: Markdown tables of an evaluation, each saying where its numbers come from."""

from collections.abc import Sequence

import numpy as np

from glasshelm.colregs.compliance import CRITERIA, of_type
from glasshelm.core.text import markdown_code, markdown_text
from glasshelm.evaluation.evaluation_run import (
    EvaluationResult,
    results_by_contender,
    stack_seeds,
    suites_of,
)
from glasshelm.evaluation.measure_columns import SuiteResult
from glasshelm.evaluation.statistics import (
    ConfidenceInterval,
    bootstrap,
    clopper_pearson,
    interquartile_mean,
    mean,
    rate_interval,
    risk_ratio,
)
from glasshelm.evaluation.tables import markdown_table, percent
from glasshelm.evaluation.types import Suite

Seeds = Sequence[SuiteResult]


def markdown_report(evaluation: EvaluationResult, against: Sequence[str]) -> str:
    """All tables of an evaluation; ``against`` names the pilots that others are compared with."""
    parts = ["# Evaluation", _methods(), overview(evaluation)]
    for suite in suites_of(evaluation):
        contenders = results_by_contender(evaluation, suite.name)
        parts.append(f"## {markdown_text(suite.name)}\n\n{markdown_text(suite.note)}.")
        parts.append(_table("Safety", _SAFETY, contenders, evaluation))
        if suite.size <= 100:
            parts.append(_cases_table(suite, contenders, evaluation))
        counts = np.unique(contenders[0][0].columns["ships"])
        if suite.size > 100 and len(counts) > 1:
            parts.append(_by_ships(counts, contenders, evaluation))
        parts.append(_ratios(contenders, against, evaluation))
        parts.append(_table("Way and rudder", _WAY, contenders, evaluation))
        parts.append(_rules(contenders, evaluation))
    parts.append(_timings(evaluation))
    return "\n\n".join(part for part in parts if part) + "\n"


#: The rates of the overview, and their columns.
SUMMARY_RATES = {
    "Collisions": "collided",
    "Domain intrusions": "intruded",
    "Within 0.5 NM": "within_half_nm",
}


def overview(evaluation: EvaluationResult) -> str:
    """Tables of the rates over all suites, for each ship; empty where there is one suite."""
    suites = suites_of(evaluation)
    if len(suites) < 2:
        return ""
    seeds_of_all = [
        seeds for suite in suites for seeds in results_by_contender(evaluation, suite.name)
    ]
    ships = dict.fromkeys(seeds[0].contender.ship_name for seeds in seeds_of_all)
    parts = ["## Overview"]
    for ship in ships:
        sailed = [seeds for seeds in seeds_of_all if seeds[0].contender.ship_name == ship]
        for what, column in SUMMARY_RATES.items():
            parts.append(f"**{what}, `{ship}`.**\n\n{_overview_table(column, sailed)}")
    return "\n\n".join(parts)


def _overview_table(column: str, sailed: Sequence[Sequence[SuiteResult]]) -> str:
    pilots = list(dict.fromkeys(seeds[0].contender.name for seeds in sailed))
    cells = {
        (seeds[0].suite.name, seeds[0].contender.name): percent(
            rate_interval(stack_seeds(seeds, column))
        )
        for seeds in sailed
    }
    sizes = {seeds[0].suite.name: seeds[0].suite.size for seeds in sailed}
    rows = [
        [suite, f"{size:,}", *(cells.get((suite, pilot), "–") for pilot in pilots)]
        for suite, size in sizes.items()
    ]
    return markdown_table(["suite", "encounters", *pilots], rows)


def _methods() -> str:
    return (
        "Definitions: docs/reference/suites.md. In brackets 95 % intervals: Clopper-Pearson for "
        "rates of one training seed, Nam-Blackwelder score for paired ratios, percentile bootstrap "
        "for returns (encounters within their number of ships) and for everything over several "
        "seeds (seeds as wholes; rates of fewer than five events a seed at least as wide as the "
        "exact interval of one). All pilots on one ship met the same encounters. Meetings are "
        "taken as independent trials, though a voyage may have several."
    )


def caption(what: str, contenders: Sequence[Seeds], evaluation: EvaluationResult) -> str:
    """What a table shows, of how much, by which weights, on which machine, by which command."""
    sizes = {f"{seeds[0].suite.size:,} encounters × {_seeds(seeds)}" for seeds in contenders}
    source = evaluation.run_info
    return (
        f"**{what}.** {'; '.join(sorted(sizes))}. Weights (SHA-256): {_weights(contenders)}. "
        f"{source.machine}; glasshelm {source.version}. {markdown_code(source.command)}"
    )


def _seeds(seeds: Seeds) -> str:
    return f"{len(seeds)} seed{'s' if len(seeds) > 1 else ''}"


def _weights(contenders: Sequence[Seeds]) -> str:
    text = []
    for seeds in contenders:
        hashes = [f"`{one.weights}`" for one in seeds if one.weights]
        if hashes:
            text.append(f"{markdown_text(seeds[0].contender.name)} {', '.join(hashes)}")
    return "; ".join(text) or "none has any"


PILOT = "pilot", "ship"


def label(seeds: Seeds) -> tuple[str, str]:
    contender = seeds[0].contender
    return contender.name, contender.ship_name


def _rate(column: str):
    def cell(seeds: Seeds) -> str:
        events = stack_seeds(seeds, column)
        text = percent(rate_interval(events))
        if len(seeds) > 1:
            worst = max(int(row.sum()) for row in events)
            text += f", worst seed {percent(clopper_pearson(worst, events.shape[1]))}"
        return text

    return cell


def _number(column: str, how, form: str, met: bool = False):
    def cell(seeds: Seeds) -> str:
        values = stack_seeds(seeds, column)
        if met:
            values = values[:, np.isfinite(values).all(0)]
        return form.format(how(values.astype(np.float64))) if values.size else "–"

    return cell


def _iqm(column: str):
    def cell(seeds: Seeds) -> str:
        values = stack_seeds(seeds, column).astype(np.float64)
        interval = bootstrap(values, seeds[0].columns["ships"], interquartile_mean)
        return f"{interval.value:.2f} [{interval.low:.2f}, {interval.high:.2f}]"

    return cell


def _progress_share(seeds: Seeds) -> str:
    progress, sailed = (stack_seeds(seeds, name).sum() for name in ("progress_m", "sailed_m"))
    return f"{100 * progress / sailed:.1f} %"


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
    "made good of the way sailed": _progress_share,
    "detour, mean [m]": _number("detour_m", mean, "{:.0f}"),
    "turned, mean [°]": _number("turned_deg", mean, "{:.0f}"),
    "rudder, mean of limit": _number("rudder", mean, "{:.2f}"),
    "rudder moved [°/min]": _number("rudder_moved_deg_min", mean, "{:.2f}"),
    "reversals": _number("reversals", mean, "{:.2f}"),
    "weaving": _rate("weaving"),
}


def _table(
    what: str, columns: dict, contenders: Sequence[Seeds], evaluation: EvaluationResult
) -> str:
    header = [*PILOT, *columns]
    rows = [[*label(seeds), *(cell(seeds) for cell in columns.values())] for seeds in contenders]
    return f"{caption(what, contenders, evaluation)}\n\n{markdown_table(header, rows)}"


def _by_ships(counts: np.ndarray, contenders: Sequence[Seeds], evaluation: EvaluationResult) -> str:
    parts = []
    for what, column in (("Collisions", "collided"), ("Intrusions", "intruded")):
        header = [*PILOT, *(f"{n} ship{'' if n == 1 else 's'}" for n in counts)]
        rows = [
            [
                *label(seeds),
                *(
                    percent(
                        rate_interval(stack_seeds(seeds, column)[:, seeds[0].columns["ships"] == n])
                    )
                    for n in counts
                ),
            ]
            for seeds in contenders
        ]
        text = caption(f"{what} by number of ships", contenders, evaluation)
        parts.append(f"{text}\n\n{markdown_table(header, rows)}")
    return "\n\n".join(parts)


def _cases_table(suite: Suite, contenders: Sequence[Seeds], evaluation: EvaluationResult) -> str:
    """Which of a few named cases went wrong."""

    def named(seeds: Seeds, column: str, depth: bool) -> str:
        text = []
        for one in seeds:
            bad = np.flatnonzero(one.columns[column])
            deep = one.columns["depth"]
            names = [
                f"{suite.labels[i]} ({deep[i]:.2f})" if depth else suite.labels[i] for i in bad
            ]
            some = f": {', '.join(names)}" if 0 < len(bad) < suite.size else ""
            text.append(f"{len(bad)} of {suite.size}{some}")
        return "; ".join(text)

    rows = [
        [*label(seeds), named(seeds, "collided", False), named(seeds, "intruded", True)]
        for seeds in contenders
    ]
    text = caption("Cases (depth of Eq. 13); seeds apart by semicolons", contenders, evaluation)
    table = markdown_table([*PILOT, "collided", "intruded"], rows)
    return f"{text}\n\n{table}"


def _ratios(
    contenders: Sequence[Seeds], against: Sequence[str], evaluation: EvaluationResult
) -> str:
    """Risk ratios against the reference pilots that were evaluated on the same ship."""
    parts = []
    for name in against:
        theirs = {s[0].contender.ship_name: s for s in contenders if s[0].contender.name == name}
        rows = []
        for seeds in contenders:
            reference = theirs.get(seeds[0].contender.ship_name)
            if reference is None or reference is seeds:
                continue
            cells = [*label(seeds)]
            for column in ("collided", "intruded", "within_half_nm"):
                interval = risk_ratio(stack_seeds(seeds, column), stack_seeds(reference, column))
                cells.append(_ratio(interval))
            rows.append(cells)
        if rows:
            header = [*PILOT, "collisions", "domain intrusions", "within 0.5 NM"]
            text = caption(
                f"Risk ratio against {markdown_text(name)}, paired", contenders, evaluation
            )
            parts.append(f"{text}\n\n{markdown_table(header, rows)}")
    return "\n\n".join(parts)


def _ratio(interval: ConfidenceInterval | None) -> str:
    if interval is None:
        return "– (never)"
    return f"{interval.value:.4f} [{interval.low:.4f}, {interval.high:.4f}]"


def _rules(contenders: Sequence[Seeds], evaluation: EvaluationResult) -> str:
    """One table a kind of meeting: the share of meetings in which each thing was done."""
    parts = []
    for kind, judgements in CRITERIA.items():
        rows = []
        for seeds in contenders:
            cells = [*label(seeds)]
            for alone in (False, True):
                # The first seed's only: meetings differ from seed to seed.
                facts = of_type(seeds[0].meetings, kind, alone)
                count = len(facts["kind"])
                cells.append(str(count))
                for judge in judgements.values() if count else ():
                    cells.append(percent(clopper_pearson(int(judge(facts).sum()), count)))
                cells += ["–"] * (0 if count else len(judgements))
            rows.append(cells)
        if all(row[2] == "0" for row in rows):
            continue
        text = caption(f"COLREGs, {kind.name.lower().replace('_', ' ')}", contenders, evaluation)
        both = ["meetings", *judgements, "alone: meetings", *judgements]
        parts.append(f"{text} {_UNTAUGHT}\n\n{markdown_table(['pilot | ship', *both], rows)}")
    return "\n\n".join(parts)


_UNTAUGHT = (
    "The paper's pilot was never taught the Rules: this says how far it happens to keep them. "
    "Targets never give way, so a stand-on ship that holds on to the end collides. "
    "Rule numbers in brackets; `alone`: voyages with no other meeting; first seed."
)


def _timings(evaluation: EvaluationResult) -> str:
    rows = [
        [t.pilot, t.ship_name, f"{t.p50_ms:.2f}", f"{t.p99_ms:.2f}"] for t in evaluation.timings
    ]
    source = evaluation.run_info
    return (
        "## Time to decide\n\n**From an observation of six ships to a rudder, without "
        f"explanation.** {source.machine}; glasshelm {source.version}. "
        f"{markdown_code(source.command)}\n\n"
        + markdown_table(["pilot", "ship", "p50 [ms]", "p99 [ms]"], rows)
    )
