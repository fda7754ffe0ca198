"""What the numbers of a reason add up to, as a reader adds them."""

import re

#: A rudder and its five parts at most, each rounded to a tenth of a degree, or left out below half
#: of one [deg].
ROUNDED_DEG = 6 * 0.05 + 1e-3


def told_sum(why: str) -> float:
    """The degrees for somebody, less those that hold back, or that turn the other way alone."""
    text = re.sub(r"\([^)]*\)", "", why)
    gains = re.findall(r"([\d.]+)°(?: of rudder)? (?:for|also)", text)
    losses = re.findall(r" by ([\d.]+)°|it would be ([\d.]+)°", text)
    assert len(gains) + len(losses) == text.count("°"), text
    return sum(map(float, gains)) - sum(float(a or b) for a, b in losses)
