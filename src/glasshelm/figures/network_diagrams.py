"""Figures 5, 6 and 12: how critic and actor compute, from the networks themselves.

Every width is that of a weight matrix; nothing is written by hand.
"""

import dataclasses

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import FancyBboxPatch

from glasshelm.env.observe import FRAMES
from glasshelm.figures.style import INK, SOFT, WAYPOINT_INK, new_figure, styled
from glasshelm.networks.actors import Actor, AttentionActor
from glasshelm.networks.critics import SubTaskCritic
from glasshelm.networks.mlp import Mlp

_SHIP = "#0072B2"
_HEAD = "#8f1d14"
_ATTENTION = "#6b4aa0"
_HEIGHT = 0.62


def describe(mlp: Mlp) -> str:
    """The layers of a network in a line: ``15 → 256 → 256 → 128, leaky relu``."""
    widths = [mlp.weights[0].shape[0], *(weight.shape[1] for weight in mlp.weights)]
    norm = ", LayerNorm" if mlp.norm else ""
    return f"{' → '.join(map(str, widths))}\n{activation_name(mlp)}{norm}"


def activation_name(mlp: Mlp) -> str:
    """The activation between the layers: ``ReLU``, ``leaky ReLU``."""
    return mlp.activation.__name__.replace("_", " ").replace("relu", "ReLU")  # type: ignore[attr-defined]


@styled
def critic_flow(critic: SubTaskCritic) -> Figure:
    """Figure 5: one network for the waypoint, one for every ship, and their sum (Eq. 19)."""
    figure, ax = _canvas(4.1)
    rows = [2.75, 1.65, 0.55]
    _input(ax, rows[0], f"waypoint, {FRAMES} frames\nand rudder a", WAYPOINT_INK)
    for y, name in zip(rows[1:], ("ship 1", "ship n"), strict=True):
        _input(ax, y, f"{name}, {FRAMES} frames\nand rudder a", _SHIP)
    _between(ax, rows[1], rows[2])
    boxes = [_box(ax, 2.2, rows[0], 2.5, f"Q_wp\n{describe(critic.of_waypoint)}", WAYPOINT_INK)]
    boxes += [
        _box(ax, 2.2, y, 2.5, f"Q_ca, the same for every ship\n{describe(critic.of_target)}", _SHIP)
        for y in rows[1:]
    ]
    total = _box(ax, 6.0, rows[1], 0.6, "+", INK)
    for y in rows:
        _arrow(ax, (1.75, y), (2.2, y))
    for box in boxes:
        _arrow(ax, box.right, total.left)
    _arrow(ax, total.right, (7.2, rows[1]))
    ax.text(7.3, rows[1], "Q(s, a)", va="center", fontsize=10, fontweight="bold")
    return figure


@styled
def actor_flow(actor: Actor) -> Figure:
    """Figures 6 and 12: encoders, their sum or weighted mean, and the head (Eq. 20-23)."""
    figure, ax = _canvas(4.6 if isinstance(actor, AttentionActor) else 4.1)
    rows = [2.75, 1.65, 0.55]
    _input(ax, rows[0], f"waypoint, {FRAMES} frames", WAYPOINT_INK)
    for y, name in zip(rows[1:], ("ship 1", "ship n"), strict=True):
        _input(ax, y, f"{name}, {FRAMES} frames", _SHIP)
    _between(ax, rows[1], rows[2])
    text = f"E_wp\n{describe(actor.encode_waypoint)}"
    own = _box(ax, 2.2, rows[0], 2.05, text, WAYPOINT_INK)
    text = f"E_oth, the same for every ship\n{describe(actor.encode_target)}"
    ships = [_box(ax, 2.2, y, 2.05, text, _SHIP) for y in rows[1:]]
    for y in rows:
        _arrow(ax, (1.75, y), (2.2, y))
    total = _box(ax, 5.55, rows[1], 0.85, "+\nsoftsign", INK)
    _arrow(ax, own.right, total.left)
    if isinstance(actor, AttentionActor):
        ax.set_ylim(-0.75, 3.3)
        mean = _box(ax, 4.75, 0.55, 1.35, "weighted mean\nΣ α_i E_oth(s_i)", _ATTENTION)
        text = (
            f"Attention of every pair of ships (s_i, s_j)\n{describe(actor.score)}\n"
            "summed over j, softmax over i: α_i"
        )
        weight = _box(ax, 2.2, -0.35, 3.6, text, _ATTENTION)
        ax.plot([1.97, 1.97], [rows[1], weight.y], color=SOFT, lw=1.0)
        _arrow(ax, (1.97, weight.y), weight.left)
        for box in ships:
            _arrow(ax, box.right, mean.left)
        _arrow(ax, (mean.bottom[0], weight.top[1]), mean.bottom)
        _arrow(ax, mean.top, (mean.top[0] + 0.1, total.bottom[1]))
    else:
        for box in ships:
            _arrow(ax, box.right, total.left)
    head = _box(ax, 6.8, total.y, 1.75, f"A\n{describe(actor.head)}\nsoftsign", _HEAD, height=0.8)
    _arrow(ax, total.right, head.left)
    ax.text(
        7.65, total.y - 0.6, "rudder in (−1, 1) of the limit", fontsize=8, ha="center", color=_HEAD
    )
    return figure


@dataclasses.dataclass(frozen=True)
class _Placed:
    """A box, by the middles of its sides."""

    x: float
    y: float
    width: float
    height: float

    @property
    def left(self) -> tuple[float, float]:
        return self.x, self.y

    @property
    def right(self) -> tuple[float, float]:
        return self.x + self.width, self.y

    @property
    def top(self) -> tuple[float, float]:
        return self.x + self.width / 2, self.y + self.height / 2

    @property
    def bottom(self) -> tuple[float, float]:
        return self.x + self.width / 2, self.y - self.height / 2


def _canvas(height_in: float) -> tuple[Figure, Axes]:
    figure = new_figure(8.6, height_in)
    ax = figure.add_subplot()
    ax.set_xlim(0, 8.6)
    ax.set_ylim(0, 3.3)
    ax.set_axis_off()
    return figure, ax


def _box(
    ax: Axes, x: float, y: float, width: float, text: str, colour: str, height: float = _HEIGHT
) -> _Placed:
    ax.add_patch(
        FancyBboxPatch(
            (x, y - height / 2), width, height, boxstyle="round,pad=0.02,rounding_size=0.06",
            fc="white", ec=colour, lw=1.3,
        )
    )  # fmt: skip
    ax.text(x + width / 2, y, text, ha="center", va="center", fontsize=8, color=INK)
    return _Placed(x, y, width, height)


def _input(ax: Axes, y: float, text: str, colour: str) -> None:
    ax.text(1.7, y, text, ha="right", va="center", fontsize=8.5, color=colour)


def _between(ax: Axes, high: float, low: float) -> None:
    ax.text(1.2, (high + low) / 2, "⋮", ha="center", va="center", fontsize=13, color=SOFT)


def _arrow(ax: Axes, start: tuple[float, float], end: tuple[float, float]) -> None:
    ax.annotate(
        "", end, start,
        arrowprops={"arrowstyle": "-|>", "color": SOFT, "lw": 1.0, "shrinkA": 2, "shrinkB": 2},
    )  # fmt: skip
