"""A bad agent never stops a crowd, whatever is wrong with it."""

import logging

import pytest

from tests.engine.plans import way
from usdfoot.engine.animate import animate_apart
from usdfoot.errors import PlanError
from usdfoot.model.agent import Agent


@pytest.fixture
def agents():
    return [
        Agent(name=name, source=f"/Scene/{name}", library=0, character=0, plan=way()) for name in ("A", "Bad", "C", "D")
    ]


@pytest.mark.parametrize(
    ("error", "told", "logged"),
    [
        (PlanError("strike_times", "is out of order"), "/Scene/Bad: strike_times: is out of order", 0),
        (ZeroDivisionError("no time"), "ZeroDivisionError: no time", 1),
        (IndexError("row 7"), "IndexError: row 7", 1),
    ],
)
def test_the_others_are_animated_and_the_bad_one_is_named(agents, error, told, logged, caplog):
    def names(group):
        if any(agent.name == "Bad" for agent in group):
            raise error
        return [agent.name for agent in group]

    with caplog.at_level(logging.ERROR, logger="usdfoot"):
        results, problems = animate_apart(names, agents)
    assert results == ["A", "C", "D"]
    (problem,) = problems
    assert problem.severity == "error" and problem.where == "/Scene/Bad" and told in problem.message
    assert len(caplog.records) == logged and all(record.exc_info for record in caplog.records)


def test_being_interrupted_is_no_fault_of_an_agent(agents):
    def interrupted(group):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        animate_apart(interrupted, agents)
