import dataclasses

import pytest
from tests.untrained import ACTOR, CRITIC, untrained

from glasshelm.paper import parameter_tables as tables
from glasshelm.training.config import preset_named

PAPER = preset_named("paper")


def test_the_preset_of_the_paper_differs_nowhere_from_the_paper():
    made = tables.parameter_tables([])
    assert [table.number for table in made] == ["A.1", "A.2", "A.3", "A.4", "A.5", "A.6"]
    for table in made:
        for row in table.rows:
            if row.paper != "not given":
                assert row.values == (row.paper,), (table.number, row.name)
                assert row.reasons == ("",)


def test_what_a_pilot_was_trained_with_is_marked_where_it_differs():
    config = dataclasses.replace(
        PAPER, actor_sizes=ACTOR, critic_sizes=CRITIC, ddpg=dataclasses.replace(PAPER.ddpg, tau=0.5)
    )
    made = {t.number: t for t in tables.parameter_tables([(untrained("sum"), config)])}
    rate = next(row for row in made["A.6"].rows if row.name == "target update rate")
    assert (rate.paper, rate.values[1]) == ("0.001", "0.5")
    assert rate.reasons[0] == ""
    assert rate.reasons[1]
    encoder = made["A.4"].rows
    assert [row.values[1] for row in encoder] == ["16", "leaky ReLU", "16", "none", "none"]
    assert [bool(row.reasons[1]) for row in encoder] == [True, False, True, True, True]


@pytest.mark.parametrize("number", ["A.1", "A.2"])
def test_a_pilot_without_critic_has_none(number):
    made = tables.parameter_tables([(untrained("sum", critic=False), PAPER)])
    rows = next(t for t in made if t.number == number).rows
    assert {row.values[1] for row in rows} == {"none"}
