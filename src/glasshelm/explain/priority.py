"""Priorities of the sub-tasks: what the decided rudder gains over rudder 0 (Eq. 22)."""

from glasshelm.networks.critics import QValues


def priorities(decided: QValues, straight: QValues) -> QValues:
    """p_wp = Q_wp(s, a) − Q_wp(s, 0) and, a ship, p_i = Q_ca(s_i, a) − Q_ca(s_i, 0) (Eq. 22).

    Eq. 22 prints Q_wp in p_oth; Q_ca is meant (docs/explanation/paper.md). ``collision`` of
    the result is the sum over the ships. All are 0 where the decided rudder is 0.
    """
    return QValues(decided.waypoint - straight.waypoint, decided.by_ship - straight.by_ship)
