"""Ships of a whole globe in space: no plane, no date line, no pole; which are near each other."""

import dataclasses
from collections.abc import Iterator

import numpy as np
from jaxtyping import Float64, Int64
from scipy.spatial import KDTree

from glasshelm.ais.table import Reports
from glasshelm.ship.nomoto import KNOT_M_S

#: A ship not heard for so long is lost: two missed reports of a class A ship at anchor (3 min).
LOST_AFTER_S = 360.0
#: WGS84: half the equator's diameter [m], and the square of the eccentricity.
_EQUATOR_M, _E2 = 6_378_137.0, 0.00669437999014

Space = Float64[np.ndarray, "n 3"]


def places(latitude_deg: np.ndarray, longitude_deg: np.ndarray) -> Space:
    """Positions on the ellipsoid in space [m], from the centre of the earth."""
    latitude, longitude = np.radians(latitude_deg), np.radians(longitude_deg)
    across = _EQUATOR_M / np.sqrt(1 - _E2 * np.sin(latitude) ** 2)
    around = across * np.cos(latitude)
    return np.stack(
        [
            around * np.cos(longitude),
            around * np.sin(longitude),
            across * (1 - _E2) * np.sin(latitude),
        ],
        axis=-1,
    )


def velocities(reports: Reports) -> Space:
    """Velocities over ground in space [m/s], each along the surface where the ship is."""
    latitude, longitude = np.radians(reports.latitude_deg), np.radians(reports.longitude_deg)
    zero = np.zeros(len(reports))
    east = np.stack([-np.sin(longitude), np.cos(longitude), zero], -1)
    north = np.stack(
        [
            -np.sin(latitude) * np.cos(longitude),
            -np.sin(latitude) * np.sin(longitude),
            np.cos(latitude),
        ],
        -1,
    )
    speed, course = reports.sog_kn * KNOT_M_S, np.radians(reports.cog_deg)
    return (speed * np.sin(course))[:, None] * east + (speed * np.cos(course))[:, None] * north


@dataclasses.dataclass(frozen=True)
class Instant:
    """Who is where at one instant, each reckoned from the latest report."""

    time_s: float
    mmsi: Int64[np.ndarray, " n"]
    place_m: Space
    velocity_m_s: Space

    def take(self, which: np.ndarray) -> "Instant":
        """The ships of a mask."""
        return Instant(self.time_s, self.mmsi[which], self.place_m[which], self.velocity_m_s[which])

    def pairs(self, within_m: float) -> Int64[np.ndarray, "pairs 2"]:
        """The pairs of ships nearer than so much, as indices, the lower first."""
        tree = KDTree(self.place_m)
        return tree.query_pairs(within_m, output_type="ndarray").astype(np.int64)


def instants(
    reports: Reports, every_s: float, lost_after_s: float = LOST_AFTER_S
) -> Iterator[Instant]:
    """The traffic at every whole ``every_s`` since 1970 at which anybody is heard.

    A ship is there until ``lost_after_s`` after her latest report. Times at which nobody is
    there are leapt over: a recording with a hole of years takes no longer than one without.
    """
    if not len(reports):
        return
    order = np.argsort(reports.time_s, kind="stable")
    reports = reports.take(order)
    time_s, place, velocity = (
        reports.time_s,
        places(reports.latitude_deg, reports.longitude_deg),
        velocities(reports),
    )
    now = float(np.ceil(time_s[0] / every_s) * every_s)
    while now - lost_after_s < time_s[-1]:
        first = int(np.searchsorted(time_s, now - lost_after_s, side="right"))
        end = int(np.searchsorted(time_s, now, side="right"))
        if first < end:
            backwards = reports.mmsi[first:end][::-1]
            mmsi, latest = np.unique(backwards, return_index=True)
            row = end - 1 - latest
            age = (now - time_s[row])[:, None]
            yield Instant(now, mmsi, place[row] + velocity[row] * age, velocity[row])
            now += every_s
        elif end < len(time_s):
            now = max(now + every_s, float(np.ceil(time_s[end] / every_s) * every_s))
        else:
            return


def closest(
    ships: Instant, pairs: Int64[np.ndarray, "pairs 2"]
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Of pairs of ships on straight courses the range now [m], TCPA [s] and DCPA [m].

    Each pair is looked at on the plane that touches the earth halfway between them.
    """
    one, other = pairs[:, 0], pairs[:, 1]
    up = ships.place_m[one] + ships.place_m[other]
    up = up / np.linalg.norm(up, axis=-1, keepdims=True)

    def level(vectors: Space) -> Space:
        return vectors - np.sum(vectors * up, -1, keepdims=True) * up

    away = level(ships.place_m[other] - ships.place_m[one])
    relative = level(ships.velocity_m_s[other] - ships.velocity_m_s[one])
    square = np.maximum(np.sum(relative**2, -1), 1e-6)
    tcpa = -np.sum(away * relative, -1) / square
    dcpa = np.linalg.norm(away + relative * tcpa[:, None], axis=-1)
    return np.linalg.norm(away, axis=-1), tcpa, dcpa
