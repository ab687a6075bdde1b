"""What other readers drop: a report names it."""

import json
from dataclasses import replace

from linkwright.pipeline.page.readers import MAX_NAMES, readers
from linkwright.stages.export.writers import WRITERS
from linkwright.stages.robot.model.geometry import Geometry, Shape
from linkwright.stages.robot.model.robot import Dynamics, Frame, Limits, Relation, frozen
from linkwright.stages.targets.readers import READERS
from linkwright.stages.targets.things import THINGS_OF_ROBOTS, dropped_things
from linkwright.stages.validate.targets.model_things import MODEL
from linkwright.stages.validate.targets.text_things import TEXT
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
    rows = dropped_things(robot, geometry, formats)
    return {(row["reader"], row["format"], row["thing"]): row["of"] for row in rows}


THINGS = {
    ("Drake", "sdf", "loops"): "loop", ("Isaac Sim", "urdf", "friction"): "arm_joint gear_joint",
    ("PyBullet", "sdf", "balls"): "hand_joint", ("PyBullet", "urdf", "frames"): "tip",
    ("Pinocchio", "urdf", "relations"): "gear_joint", ("Drake", "urdf", "colliders in STL"): "arm_1.stl",
    ("Drake", "urdf", "fixed base"): "base", ("Newton", "mjcf", "starts of joints"): "lid_joint",
    ("PyBullet", "urdf", "visuals in GLB"): "arm.glb",
}  # fmt: skip


def test_robot_with_everything_has_every_row():
    rows = rows_of(everything(), Geometry((HULL, SKIN), {}, whole_visuals=(WHOLE,)), *WRITERS)
    assert set(rows) == {
        (row.reader, row.format, row.thing) for row in READERS if row.thing in THINGS_OF_ROBOTS
    }
    of_files = [row for row in READERS if row.thing not in THINGS_OF_ROBOTS]
    assert all(row.thing in MODEL or (row.format, row.thing) in TEXT for row in of_files)
    assert {row: " ".join(rows[row]) for row in THINGS} == THINGS


def test_rows_are_of_the_robots_things_in_written_formats():
    robot = robot_with([joint("revolute", "base", "arm")], fixed=False)
    geometry = Geometry((replace(HULL, file="arm_1.obj"), SKIN), {})
    assert set(rows_of(robot, geometry, "urdf")) == {("PyBullet", "urdf", "inertia")}
    lost = ("PyBullet", "sdf", "everything")
    assert set(rows_of(robot, geometry, "sdf")) == {lost}
    assert set(rows_of(robot, Geometry((HULL,), {}), "sdf")) == {lost, ("Drake", "sdf", "colliders in STL")}


def test_report_has_the_dropped_things():
    made = exported(everything(), export={"sdf": {}})
    rows = json.loads(json.dumps(made.details))["readers"]
    assert {row["format"] for row in rows} == {"sdf"}
    page = readers(rows).replace("<wbr>", "")
    for text in ("What other readers drop", "bullet-featherstone", "gz-physics/issues/25", "measured"):
        assert text in page


def test_page_shows_some_names_and_counts_the_rest():
    names = [f"joint_{index}" for index in range(MAX_NAMES + 3)]
    row = {
        "reader": "R", "version": "1", "format": "urdf", "thing": "friction", "does": "x", "of": names,
        "source": "s",
    }  # fmt: skip
    page = readers([row])
    assert f"joint_{MAX_NAMES - 1} and 3 more" in page
    assert f"joint_{MAX_NAMES}," not in page
    assert readers([]) == ""
