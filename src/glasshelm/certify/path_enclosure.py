"""Where own ship can be under each manoeuvre while its own measurements err.

A manoeuvre is simulated from the measured position and heading, so errors of both move the
simulated way. In the frame of own ship's measured position and heading, with φ ∈ [−1, 1] for the
errors east, north and of the heading, every state of the way is

    x_k(φ) = x_k + X_k·φ, within a slack.

X_k is the exact derivative of the autopilot's law and Eq. 6-7 along the nominal way; the slack
takes all else: the second-order terms, the limit of the rudder where it may or may not be
reached, and float32. Two enclosures of the slack of heading and rate of turn are carried: a box in
(ψ + T·r, r), which a saturated rudder leaves as it is, and an ellipse that the closed loop
contracts. Where the short way round to a course is in doubt, or the waypoint is passed too
near, own ship is *lost*: any heading is possible, and its place spreads with twice its speed.
"""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float

from glasshelm.core.geometry import Vector, wrap_angle
from glasshelm.planning.manoeuvres import Manoeuvres, PredictedOwn, predict_step
from glasshelm.planning.simulated_critic import ManoeuvreCosts
from glasshelm.planning.situation import Situation
from glasshelm.ship.autopilot import autopilot_for
from glasshelm.ship.nomoto import ShipParams

#: Own ship's errors that move its way: east, north, heading.
N_PATH_ERRORS = 3
#: What float32 may lose of a heading or a rudder [rad], of a rate of turn that is the difference of
#: two bearings [rad/s], and of a distance sailed.
HEADING_ROUNDING, RATE_ROUNDING, PLACE_ROUNDING = 6e-7, 3e-7, 1e-6
#: A waypoint nearer than so many times what is not known of its place gives no bearing.
_NEAREST = 3.0

Slopes = Float[Array, "3 *c"]


class PathErrors(eqx.Module):
    """The errors that move own ship's way, in the frame of its measured position and heading.

    Attributes:
        place: What an error east and an error north add to own ship's place [m]: starboard and
            ahead, one a column.
        heading_rad: The largest error of the heading.
        rate_rad_s: The largest error of the rate of turn.
    """

    place: Float[Array, "2 2"]
    heading_rad: Float[Array, ""]
    rate_rad_s: Float[Array, ""]

    @property
    def place_m(self) -> Float[Array, ""]:
        """The farthest that the place may be off."""
        return jnp.sqrt((self.place**2).sum(0)).sum()


class PathEnclosure(eqx.Module):
    """Own ship on each manoeuvre, ``ahead``, and how far all of it may be off.

    Attributes:
        ahead: The nominal way.
        x: Slopes of its place to starboard in the three errors [m].
        y: The same ahead [m].
        heading: Slopes of the heading [rad].
        place_slack: A radius [m].
        heading_slack: π where nothing is known of the heading [rad].
        lost: Where that is so.
    """

    ahead: PredictedOwn
    x: Slopes
    y: Slopes
    heading: Slopes
    place_slack: Float[Array, "*c"]
    heading_slack: Float[Array, "*c"]
    lost: Bool[Array, "*c"]

    @staticmethod
    def here(at: Situation, errors: PathErrors, manoeuvres: int) -> "PathEnclosure":
        """All of them where own ship is."""
        ahead = PredictedOwn.here(at.rate_of_turn_rad_s, manoeuvres)
        zero, none = jnp.zeros(manoeuvres), jnp.zeros((N_PATH_ERRORS, manoeuvres))
        heading = none.at[2].set(errors.heading_rad)
        return PathEnclosure(ahead, none, none, heading, zero, zero + HEADING_ROUNDING, zero > 1.0)

    @property
    def heading_radius(self) -> Float[Array, "*c"]:
        return jnp.abs(self.heading).sum(0) + self.heading_slack

    @property
    def place_radius(self) -> Float[Array, "*c"]:
        return jnp.sqrt(self.x**2 + self.y**2).sum(0) + self.place_slack

    def bearing_of(
        self, place: Vector, errors: PathErrors
    ) -> tuple[Float[Array, "*c"], Slopes, Float[Array, "*c"], Bool[Array, "*c"]]:
        """The bearing of the waypoint: nominal, slopes, slack, and whether it is in doubt.

        An own ship shown too far east sees the waypoint too far west.
        """
        x, y = place.x - self.ahead.x, place.y - self.ahead.y
        wide = jnp.pad(errors.place, ((0, 0), (0, 1)))
        off_x, off_y = (-wide[axis][:, None] - own for axis, own in ((0, self.x), (1, self.y)))
        radius = jnp.sqrt(off_x**2 + off_y**2).sum(0) + self.place_slack
        square = jnp.maximum(x * x + y * y, 1.0)
        range_m = jnp.sqrt(square)
        slopes = (y * off_x - x * off_y) / square
        near = range_m < _NEAREST * radius
        rest = jnp.maximum(range_m - radius, 1.0)
        slack = self.place_slack / range_m + 0.5 * radius**2 / rest**2 + HEADING_ROUNDING
        return self.ahead.bearing_of(place), slopes, jnp.where(near, jnp.pi, slack), near


class _Loop:
    """Own ship's steering over one step, and how it treats what is not known.

    The state is z = (ψ + T·r, r). Without rudder it keeps its first number, and the second decays.
    ``matrices`` are of a rudder at its limit, and of one that follows z.
    """

    def __init__(self, ship: ShipParams, tau_s: float):
        with jax.ensure_compile_time_eval():
            pilot = autopilot_for(ship)
            self.proportional = float(pilot.proportional)
            self.derivative_s = float(pilot.derivative_s)
        self.lag, self.gain = float(ship.time_constant_s), float(ship.gain_1_s)
        self.limit_rad = float(ship.rudder_limit_rad)
        decay = np.exp(-tau_s / self.lag)
        self.into = np.array([self.gain * tau_s, self.gain * (1 - decay)])
        law = np.array([-self.proportional, self.proportional * self.lag - self.derivative_s])
        still = np.diag([1.0, decay])
        self.matrices = (still, still + np.outer(self.into, law))
        self.shape = _contracting(self.matrices[1], np.diag([1.0, self.lag**2]))
        #: Columns: what a unit of heading, of rate and of rudder is in the ellipse.
        self.inverse = np.linalg.inv(self.shape)
        self.of_rudder = float(np.linalg.norm(self.inverse @ self.into))
        self.of_box = np.linalg.norm(self.inverse, axis=0)
        self.norms = [
            float(np.linalg.norm(self.inverse @ a @ self.shape, 2)) for a in self.matrices
        ]
        heading = np.array([1.0, -self.lag])
        self.heading_row, self.heading_size = heading, float(np.linalg.norm(heading @ self.shape))
        self.sizes = [np.linalg.norm(a @ self.shape, axis=1) for a in self.matrices]

    def slack(
        self, box: tuple[Array, Array], ball: Array, free: Array, off_rad: Array
    ) -> tuple[tuple[Array, Array], Array]:
        """Both enclosures one step later; ``free``: the rudder follows, ``off_rad``: how badly."""
        grown = []
        for row in range(2):
            at_limit, following = (
                jnp.minimum(
                    abs(a[row, 0]) * box[0] + abs(a[row, 1]) * box[1], size[row] * ball
                )
                for a, size in zip(self.matrices, self.sizes, strict=True)
            )  # fmt: skip
            grown.append(jnp.where(free, following, at_limit) + self.into[row] * off_rad)
        after = jnp.where(free, self.norms[1], self.norms[0]) * ball + self.of_rudder * off_rad
        ball = jnp.minimum(after, self.of_box[0] * grown[0] + self.of_box[1] * grown[1])
        return (grown[0], grown[1]), ball

    def heading(self, box: tuple[Array, Array], ball: Array) -> Array:
        """The slack of the heading."""
        return jnp.minimum(box[0] + self.lag * box[1], self.heading_size * ball)


def _contracting(a: np.ndarray, weight: np.ndarray) -> np.ndarray:
    """M such that ‖M⁻¹·A·M‖ is little more than A's spectral radius (Lyapunov's equation)."""
    radius = max(abs(np.linalg.eigvals(a)))
    scaled, total, power = a / (1.02 * radius + 1e-9), np.zeros_like(a), np.eye(len(a))
    for _ in range(400):
        total += power.T @ weight @ power
        power = scaled @ power
    return np.linalg.inv(np.linalg.cholesky(total)).T


def enclose_paths(
    manoeuvres: Manoeuvres,
    at: Situation,
    keep: Bool[np.ndarray, " c"],
    errors: PathErrors,
    ship: ShipParams,
    costs: ManoeuvreCosts,
) -> PathEnclosure:
    """Own ship at every step [k, c] of every manoeuvre.

    Args:
        manoeuvres: The manoeuvres [c], as they are without errors.
        at: What is measured.
        keep: Which of them keep the measured heading.
        errors: The errors that move own ship's way.
        ship: Own ship.
        costs: How far ahead to look, in which steps.
    """
    tau, loop = costs.step_s, _Loop(ship, costs.step_s)
    zero = jnp.zeros_like(manoeuvres.offset_rad)
    start = PathEnclosure.here(at, errors, zero.size)
    nothing, own_heading = start.x, start.heading
    first, first_slopes, first_slack, first_lost = start.bearing_of(at.waypoint, errors)
    box = (zero + HEADING_ROUNDING + loop.lag * errors.rate_rad_s, zero + errors.rate_rad_s)
    ball = loop.of_box[0] * box[0] + loop.of_box[1] * box[1]
    run_m = ship.speed_m_s * tau

    def step(carry: tuple, time: Float[Array, ""]) -> tuple[tuple, PathEnclosure]:
        here, rate, box, ball, bearing, bearing_slopes, bearing_slack, in_doubt = carry
        m, ahead = manoeuvres, here.ahead
        second = jnp.where(time < m.duration_s + m.then_duration_s, m.then_offset_rad, 0.0)
        altered = jnp.where(time < m.duration_s, m.offset_rad, second)
        keeping = jnp.asarray(keep) & (time < m.duration_s)
        to_waypoint = (altered == 0.0) & ~keeping
        course = jnp.where(to_waypoint, bearing, first + altered)
        slopes = jnp.where(to_waypoint, bearing_slopes, first_slopes)
        slopes = jnp.where(keeping, own_heading, slopes)
        slack = jnp.where(to_waypoint, bearing_slack, first_slack)
        slack = jnp.where(keeping, HEADING_ROUNDING, slack)
        error = wrap_angle(course - ahead.heading)
        radius = jnp.abs(slopes - here.heading).sum(0) + slack + here.heading_slack
        lost = here.lost | (to_waypoint & in_doubt) | (jnp.abs(error) + radius >= jnp.pi)

        p, d, lag = loop.proportional, loop.derivative_s, loop.lag
        wanted = p * error - d * ahead.rate
        wanted_slopes = p * (slopes - here.heading) - d * rate
        reach = jnp.abs(wanted_slopes).sum(0)
        reach = reach + p * (slack + here.heading_slack) + d * box[1]
        free = jnp.abs(wanted) <= loop.limit_rad
        beyond = jnp.abs(jnp.abs(wanted) - loop.limit_rad)
        off = jnp.clip(reach - beyond, 0.0, 2 * loop.limit_rad) + jnp.where(free, p * slack, 0.0)
        rudder_slopes = jnp.where(free, wanted_slopes, 0.0)

        after = predict_step(ahead, course, autopilot_for(ship), ship, tau)
        decay = np.exp(-tau / lag)
        after_rate = loop.into[1] * rudder_slopes + decay * rate
        drift = lag * (1.0 - decay)
        heading = here.heading + loop.gain * (tau - drift) * rudder_slopes + drift * rate
        box, ball = loop.slack(box, ball, free, off + HEADING_ROUNDING)
        heading_slack = loop.heading(box, ball) + HEADING_ROUNDING
        before_radius = here.heading_radius
        after_radius = jnp.abs(heading).sum(0) + heading_slack

        # The chord is half the sum of both ways, lengthened by turned²/12.
        turned = after.heading - ahead.heading
        turned_off = jnp.abs(heading - here.heading).sum(0) + heading_slack + here.heading_slack
        half = 0.5 * run_m * (1.0 + turned * turned * (1.0 / 12.0))
        x = here.x + half * (ahead.way.y * here.heading + after.way.y * heading)
        y = here.y - half * (ahead.way.x * here.heading + after.way.x * heading)
        spread = half * (here.heading_slack + heading_slack)
        spread += half * 0.5 * (before_radius**2 + after_radius**2)
        spread += run_m * (1.0 / 12.0) * turned_off * (2.0 * jnp.abs(turned) + turned_off)
        rounding = PLACE_ROUNDING * run_m
        now = PathEnclosure(
            after,
            jnp.where(lost, here.x, x),
            jnp.where(lost, here.y, y),
            jnp.where(lost, 0.0, heading),
            here.place_slack + rounding + jnp.where(lost, 2.5 * run_m, spread),
            jnp.where(lost, jnp.pi, heading_slack),
            lost,
        )
        return (now, after_rate, box, ball, *now.bearing_of(at.waypoint, errors)), now

    carry = (start, nothing, box, ball, first, first_slopes, first_slack, first_lost)
    times = jnp.arange(round(costs.horizon_s / tau), dtype=jnp.float32) * tau
    return jax.lax.scan(step, carry, times)[1]
