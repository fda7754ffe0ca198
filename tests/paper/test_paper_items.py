import re
from pathlib import Path

import glasshelm
from glasshelm.paper.paper_items import EQUATIONS, FIGURES


def test_every_equation_and_figure_of_the_paper_is_there():
    numbers = [n for e in EQUATIONS for n in _whole(e.number)]
    assert numbers == list(range(1, 25))
    assert list(FIGURES) == [str(n) for n in range(1, 16)]


def test_figures_cite_equations_that_there_are():
    for figure in FIGURES.values():
        assert set(_whole(figure.equations)) <= set(range(1, 25))


def test_the_code_that_is_named_is_there():
    root = Path(glasshelm.__file__).parent
    assert all((root / equation.code).is_file() for equation in EQUATIONS)


def _whole(text):
    first, last = re.fullmatch(r"(\d+)(?:-(\d+))?", text).groups()
    return range(int(first), int(last or first) + 1)
