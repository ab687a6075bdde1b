"""What other readers drop: the rows that a robot has are told, with the names of its things."""

import json
from dataclasses import replace

import pytest

from linkwright.pipeline.page.readers import MAX_NAMES, readers
from linkwright.stages.export.writers import WRITERS
from linkwright.stages.robot.model.geometry import Geometry, Shape
from linkwright.stages.robot.model.robot import Dynamics, Frame, Limits, Relation, frozen
from linkwright.stages.targets.readers import READERS
from linkwright.stages.targets.things import THINGS_OF_ROBOTS, dropped_things
from linkwright.stages.validate.targets.model_things import MODEL
from linkwright.stages.validate.targets.text_things import TEXT
from tests.support import drake
from tests.support.exports import exported
from tests.support.robots import at, joint, loop, robot_with

HULL = Shape("arm", "collision", "arm_1.stl", None, 8, 12, 1.0, 1.0)
WHOLE = Shape("arm", "visual", "arm.glb", None, 8, 12, 1.0, 1.0)
SKIN = Shape("arm", "visual", "arm.obj", None, 8, 12, 1.0, 1.0)


def everything():
    dynamics = Dynamics(0.1, 0.2, None, 3.0, 4.0)
    rows = [
        joint("revolute", "base", "arm", dynamics=dynamics),
        joint("ball", "arm", "hand", limits={"hand_joint": Limits(None, 1.0)}),
        joint("revolute", "base", "gear", dynamics=dynamics),
        joint("revolute", "base", "lid", limits={"lid_joint": Limits(0.5, 1.0)}),
    ]
    relation = Relation("Gear", "gear_joint", "arm_joint", 2.0, 0.0)
    shut = loop("ball", "hand", "base", at(0, 0, 0), at(0, 0, 0), [(1.0, 0.0, 0.0, 0.0)])
    tip = Frame("tip", "hand", frozen(at(0, 0, 1)), "Tip")
    return robot_with(rows, relations=[relation], frames=[tip], loops=[shut])


def rows_of(robot, geometry, *formats):
    return {
        (row["reader"], row["format"], row["thing"]): row["of"]
        for row in dropped_things(robot, geometry, formats)
    }


def test_a_robot_with_everything_has_every_row():
    rows = rows_of(everything(), Geometry((HULL, SKIN), {}, whole_visuals=(WHOLE,)), *WRITERS)
    expected = {(row.reader, row.format, row.thing) for row in READERS if row.thing in THINGS_OF_ROBOTS}
    of_files = [row for row in READERS if row.thing not in THINGS_OF_ROBOTS]
    assert all(row.thing in MODEL or (row.format, row.thing) in TEXT for row in of_files)
    assert (set(rows), rows["Drake", "sdf", "loops"]) == (expected, ["loop"])
    assert rows["Isaac Sim", "urdf", "friction"] == ["arm_joint", "gear_joint"]
    assert rows["PyBullet", "sdf", "balls"] == ["hand_joint"]
    assert rows["PyBullet", "urdf", "frames"] == ["tip"]
    assert rows["Pinocchio", "urdf", "relations"] == ["gear_joint"]
    assert rows["Drake", "urdf", "colliders in STL"] == ["arm_1.stl"]
    assert rows["Drake", "urdf", "fixed base"] == ["base"]
    assert rows["Newton", "mjcf", "starts of joints"] == ["lid_joint"]
    assert rows["PyBullet", "urdf", "visuals in GLB"] == ["arm.glb"]


def test_rows_are_of_the_robots_things_in_written_formats():
    robot = robot_with([joint("revolute", "base", "arm")], fixed=False)
    geometry = Geometry((replace(HULL, file="arm_1.obj"), SKIN), {})
    assert set(rows_of(robot, geometry, "urdf")) == {("PyBullet", "urdf", "inertia")}
    lost = ("PyBullet", "sdf", "everything")
    assert set(rows_of(robot, geometry, "sdf")) == {lost}
    assert set(rows_of(robot, Geometry((HULL,), {}), "sdf")) == {lost, ("Drake", "sdf", "colliders in STL")}


@pytest.mark.parametrize("row", READERS, ids=lambda row: f"{row.reader} {row.format} {row.thing}")
def test_a_row_is_measured_or_has_its_source(row):
    assert row.format in WRITERS
    assert row.version
    assert row.does
    assert not row.source or row.source.startswith("https://")


def test_the_version_of_drake_is_that_of_the_tests():
    assert {row.version for row in READERS if row.reader == "Drake"} == {drake.VERSION}


def test_no_reader_has_two_rows_of_one_thing():
    keys = [(row.reader, row.version, row.format, row.thing) for row in READERS]
    assert len(set(keys)) == len(keys)


def test_a_build_tells_them_in_its_report():
    made = exported(everything(), export={"sdf": {}})
    rows = json.loads(json.dumps(made.details))["readers"]
    assert {row["format"] for row in rows} == {"sdf"}
    page = readers(rows).replace("<wbr>", "")
    for text in ("What other readers drop", "bullet-featherstone", "gz-physics/issues/25", "measured"):
        assert text in page


def test_the_page_shows_some_names_and_counts_the_rest():
    names = [f"joint_{index}" for index in range(MAX_NAMES + 3)]
    row = {
        "reader": "R", "version": "1", "format": "urdf", "thing": "friction", "does": "x", "of": names,
        "source": "s",
    }  # fmt: skip
    page = readers([row])
    assert f"joint_{MAX_NAMES - 1} and 3 more" in page
    assert f"joint_{MAX_NAMES}," not in page
    assert readers([]) == ""
