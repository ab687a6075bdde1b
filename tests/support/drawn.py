"""Robots of documents that are drawn by chance, with any link as root, fixed or free."""

from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tests.fake_onshape.random_document import documents
from tests.support.building import plan_of, robot_of

PLACES = st.integers(0, 1000)
"""For the root, and for the seed of all else."""

_BORED = [HealthCheck.too_slow, HealthCheck.data_too_large, HealthCheck.filter_too_much]
SLOWLY = {"suppress_health_check": _BORED}

DYNAMICS = {"*": {"effort": 5, "velocity": 2, "damping": 0.25, "friction": 0.125}}


def each(check, count, *strategies):
    """Runs a check on so many drawn examples."""
    settings(max_examples=count, deadline=None, **SLOWLY)(given(*strategies)(check))()


def any_document(everything=True, loops=None):
    """Documents; None for a property that is drawn."""
    both = (st.just(value) if value is not None else st.booleans() for value in (everything, loops))
    return st.tuples(*both).flatmap(lambda pair: documents(everything=pair[0], loops=pair[1]))


def drawn(document, root, seed, **keys):
    """The robot of a document with the link of this number as its root, and its plan."""
    first = robot_of(document)
    links = ["world"] if first.root.name == "world" else sorted(link.name for link in first.links)
    base = "fixed" if links == ["world"] else ["fixed", "free"][seed % 2]
    plan = plan_of(root={"select": links[root % len(links)], "base": base}, **keys)
    return robot_of(document, plan), plan
