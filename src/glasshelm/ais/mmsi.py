"""Stations named by their number, where they report no name (ITU-R M.585)."""

#: Senders of distress, by the first three of nine digits: survival craft, man overboard, beacons.
_DISTRESS = {"970": "SART", "972": "MOB", "974": "EPIRB"}


def is_number(identity: str) -> bool:
    """Whether an identity is a number: ASCII digits alone, not those of other scripts."""
    return identity.isascii() and identity.isdigit()


def station_label(mmsi: int | str) -> str:
    """``MMSI 230035780``; of a sender of distress ``SART 970012345``."""
    text = str(mmsi)
    kind = _DISTRESS.get(text[:3], "MMSI") if len(text) == 9 else "MMSI"
    return f"{kind} {text}"
