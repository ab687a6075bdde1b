"""Random documents: the USD is the robot of the MJCF and of the URDF, by three readers."""

import tempfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from linkwright.pipeline.config.plan import Plan
from linkwright.stages.robot.model.robot import Robot
from linkwright.stages.validate import validate
from tests.fake_onshape.document import Document
from tests.fake_onshape.random_document import documents
from tests.fake_onshape.sample import sample_document
from tests.support.building import plan_of, robot_of, write
from tests.support.drawn import DYNAMICS, PLACES, SLOWLY, drawn
from tests.support.sdf_parity import Three
from tests.support.usd import pxr
from tests.support.usd_parity import UsdParity

KEYS = {
    "export": {"urdf": {}, "mjcf": {}, "sdf": {}, "usd": {}},
    "joints": DYNAMICS,
}


def agree(document: Document, root: int, seed: int) -> bool:
    """Compares; whether another pose closes the loops."""
    return compare(*drawn(document, root, seed, **KEYS), seed)


def compare(robot: Robot, plan: Plan, seed: int) -> bool:
    assert pxr.Usd
    rng = np.random.default_rng(seed)
    with tempfile.TemporaryDirectory() as folder:
        made = write(robot, Path(folder), plan)
        readers = UsdParity(robot, made.files, Path(folder))
        checks = validate(Path(folder), made.written, plan)
        assert [one for one in checks if one.name.startswith("robot.usda") and not one.passed] == []
        readers.agree(rng)
        if not robot.loops:
            return False
        q = Three(robot, made.files, Path(folder)).closed_pose(rng)
        if q is not None:
            readers.closed(q)
        return q is not None


@settings(max_examples=3, **SLOWLY)
@given(documents(everything=True), PLACES, PLACES)
def test_the_usd_is_the_document(document: Document, root: int, seed: int) -> None:
    agree(document, root, seed)


@pytest.mark.slow
@settings(max_examples=3, **SLOWLY)
@given(documents(everything=True, loops=True), PLACES, PLACES)
def test_the_usd_has_the_loops_of_the_document(document: Document, root: int, seed: int) -> None:
    agree(document, root, seed)


@pytest.mark.slow
@settings(max_examples=20, **SLOWLY)
@given(st.booleans().flatmap(lambda loops: documents(everything=True, loops=loops)), PLACES, PLACES)
def test_the_usd_is_the_document_many_times(document: Document, root: int, seed: int) -> None:
    agree(document, root, seed)


def test_the_sample_is_one_robot_in_three_files() -> None:
    plan = plan_of(**KEYS)
    assert compare(robot_of(sample_document(), plan), plan, 1)
