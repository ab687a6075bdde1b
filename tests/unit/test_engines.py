"""The reference that engines are held against, and the rows of drivers, with MuJoCo itself as the engine."""

import json
import shutil
import subprocess
import sys
from pathlib import Path

import mujoco
import numpy as np
import pytest

from tests.engines import told
from tests.engines.__main__ import driven
from tests.engines.reference import reference
from tests.engines.table import ENGINES, Engine
from tests.support.building import plan_of, write
from tests.support.places import PROJECT
from tests.support.robots import at, joint, robot_with

ITSELF = Engine("mujoco", "mujoco", ("mujoco",))


@pytest.fixture(scope="module")
def built(tmp_path_factory):
    """A pendulum on a slide, with servos and without meshes."""
    folder = tmp_path_factory.mktemp("built")
    rows = [joint("prismatic", "base", "cart"), joint("revolute", "cart", "arm", place=at(0.1, 0, 0))]
    write(robot_with(rows), folder, plan_of(actuators={"*": "position"}, export={"urdf": {}, "mjcf": {}}))
    (folder / "reference.json").write_text(json.dumps(reference(folder)))
    return folder


def test_mujoco_is_held_against_itself_and_holds(built):
    rows = driven(ITSELF, Path(sys.executable), "pendulum", built)
    assert {row.format for row in rows} == {"mjcf", "urdf", "scene"}
    assert {"loads", "masses", "kinematics", "mass matrix", "bias", "motion"} <= {row.thing for row in rows}
    assert [row for row in rows if not row.holds] == []
    assert {row.version for row in rows} == {mujoco.__version__}


def test_heavier_arm_is_told_by_its_masses_but_not_by_its_poses(built, tmp_path):
    other = tmp_path / "other"
    shutil.copytree(built, other)
    spec = mujoco.MjSpec.from_file(str(other / "robot.xml"))
    spec.body("arm").mass *= 2
    (other / "robot.xml").write_text(spec.to_xml())
    rows = driven(ITSELF, Path(sys.executable), "pendulum", other)
    holds = {(row.format, row.thing): row.holds for row in rows}
    assert not holds["mjcf", "masses"]
    assert not holds["mjcf", "mass matrix"]
    assert holds["mjcf", "kinematics"]
    assert holds["urdf", "masses"]


def test_driver_that_fails_is_a_row(built):
    (row,) = driven(Engine("none", "pybullet", ()), Path(sys.executable), "pendulum", built)
    assert row.wrong
    assert "pybullet" in row.said


def test_what_lacks_is_infinitely_far():
    assert told.apart([1.0], [1.0, 2.0]) == np.inf
    assert told.apart([np.nan], [1.0]) == np.inf
    assert told.links_apart({}, {"arm": np.eye(4)}) == np.inf
    assert told.masses_apart({}, {"arm": 1.0}) == np.inf
    assert told.masses_apart({"arm": 1.5, "more": 1.0}, {"arm": 1.0, "base": 0.0}) == 0.5


def test_every_engine_has_its_driver_and_a_name_of_its_own():
    folder = Path(told.__file__).parent
    assert all((folder / f"drive_{engine.driver}.py").exists() for engine in ENGINES)
    assert len({engine.name for engine in ENGINES}) == len(ENGINES)


def test_command_names_the_engines_and_refuses_others():
    command = [sys.executable, "-m", "tests.engines", "no_engine"]
    done = subprocess.run(command, capture_output=True, text=True, check=False, cwd=PROJECT)
    assert done.returncode == 2
    assert "there is no no_engine" in done.stderr
