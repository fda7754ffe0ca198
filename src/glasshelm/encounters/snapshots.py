"""Traffic of the whole globe at an instant, in space: no plane, no date line, no pole."""

import dataclasses
from collections.abc import Iterator

import numpy as np
import pyproj
from jaxtyping import Float64, Int64
from scipy.spatial import KDTree

from glasshelm.ais.limits import LOST_AFTER_S
from glasshelm.ais.table import ReportTable
from glasshelm.ship.nomoto import KNOT_M_S

Space = Float64[np.ndarray, "n 3"]

_TO_ECEF = pyproj.Transformer.from_pipeline(
    "+proj=pipeline +step +proj=unitconvert +xy_in=deg +xy_out=rad +step +proj=cart +ellps=WGS84"
)


def ecef(latitude_deg: np.ndarray, longitude_deg: np.ndarray) -> Space:
    """Positions on the ellipsoid in space [m], from the centre of the earth."""
    height = np.zeros(len(latitude_deg))
    return np.stack(_TO_ECEF.transform(longitude_deg, latitude_deg, height), axis=-1)


def ecef_velocities(reports: ReportTable) -> Space:
    """Velocities over ground in space [m/s], each along the surface where the ship is."""
    latitude, longitude = np.radians(reports.latitude_deg), np.radians(reports.longitude_deg)
    speed, course = reports.sog_kn * KNOT_M_S, np.radians(reports.cog_deg)
    east, north = speed * np.sin(course), speed * np.cos(course)
    return np.stack(
        [
            -np.sin(longitude) * east - np.sin(latitude) * np.cos(longitude) * north,
            np.cos(longitude) * east - np.sin(latitude) * np.sin(longitude) * north,
            np.cos(latitude) * north,
        ],
        axis=-1,
    )


@dataclasses.dataclass(frozen=True)
class TrafficSnapshot:
    """Where all ships are at one instant, each dead-reckoned from its latest report."""

    time_s: float
    mmsi: Int64[np.ndarray, " n"]
    position_m: Space
    velocity_m_s: Space

    def take(self, which: np.ndarray) -> "TrafficSnapshot":
        """The ships of a mask."""
        return TrafficSnapshot(
            self.time_s, self.mmsi[which], self.position_m[which], self.velocity_m_s[which]
        )

    def pairs(self, within_m: float) -> Int64[np.ndarray, "pairs 2"]:
        """The pairs of ships nearer than so much, as indices, the lower first."""
        tree = KDTree(self.position_m)
        return tree.query_pairs(within_m, output_type="ndarray").astype(np.int64)


def snapshots(
    reports: ReportTable, every_s: float, lost_after_s: float = LOST_AFTER_S
) -> Iterator[TrafficSnapshot]:
    """The traffic at every whole ``every_s`` since 1970 at which there is any.

    A ship is there until ``lost_after_s`` after its latest report. Times without traffic
    are skipped: a recording with a gap of years takes no longer than one without.
    """
    if not len(reports):
        return
    reports = reports.take(np.argsort(reports.time_s, kind="stable"))
    time_s, velocity = reports.time_s, ecef_velocities(reports)
    position = ecef(reports.latitude_deg, reports.longitude_deg)
    now = float(np.ceil(time_s[0] / every_s) * every_s)
    while now - lost_after_s < time_s[-1]:
        first = int(np.searchsorted(time_s, now - lost_after_s, side="right"))
        end = int(np.searchsorted(time_s, now, side="right"))
        if first < end:
            backwards = reports.mmsi[first:end][::-1]
            mmsi, latest = np.unique(backwards, return_index=True)
            row = end - 1 - latest
            age = (now - time_s[row])[:, None]
            yield TrafficSnapshot(now, mmsi, position[row] + velocity[row] * age, velocity[row])
            now += every_s
        elif end < len(time_s):
            now = max(now + every_s, float(np.ceil(time_s[end] / every_s) * every_s))
        else:
            return


def closest_approaches(
    ships: TrafficSnapshot, pairs: Int64[np.ndarray, "pairs 2"]
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Range now [m], TCPA [s] and DCPA [m] of pairs of ships on straight courses.

    Each pair is projected to the plane that touches the earth halfway between the two.
    """
    one, other = pairs[:, 0], pairs[:, 1]
    up = ships.position_m[one] + ships.position_m[other]
    up = up / np.linalg.norm(up, axis=-1, keepdims=True)

    def level(vectors: Space) -> Space:
        return vectors - np.sum(vectors * up, -1, keepdims=True) * up

    away = level(ships.position_m[other] - ships.position_m[one])
    relative = level(ships.velocity_m_s[other] - ships.velocity_m_s[one])
    square = np.maximum(np.sum(relative**2, -1), 1e-6)
    tcpa = -np.sum(away * relative, -1) / square
    dcpa = np.linalg.norm(away + relative * tcpa[:, None], axis=-1)
    return np.linalg.norm(away, axis=-1), tcpa, dcpa
