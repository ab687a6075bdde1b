"""Robots of documents that are drawn by chance, with any link as root, fixed or free."""

from typing import Any

from hypothesis import HealthCheck
from hypothesis import strategies as st

from linkwright.pipeline.config.plan import Plan
from linkwright.stages.robot.model.robot import Robot
from tests.fake_onshape.document import Document
from tests.support.building import plan_of, robot_of

PLACES = st.integers(0, 1000)
"""For the root, and for the seed of all else."""

SLOWLY: dict[str, Any] = {"suppress_health_check": [HealthCheck.too_slow, HealthCheck.data_too_large]}

DYNAMICS = {"*": {"effort": 5, "velocity": 2, "damping": 0.25, "friction": 0.125}}


def drawn(document: Document, root: int, seed: int, **keys: Any) -> tuple[Robot, Plan]:
    """The robot of a document with the link of this number as its root, and its plan."""
    first = robot_of(document)
    links = ["world"] if first.root.name == "world" else sorted(link.name for link in first.links)
    base = "fixed" if links == ["world"] else ["fixed", "free"][seed % 2]
    plan = plan_of(root={"select": links[root % len(links)], "base": base}, **keys)
    return robot_of(document, plan), plan
