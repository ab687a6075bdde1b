"""What other readers drop: the rows that a robot has are told, with the names of its things."""

import json
from dataclasses import replace

import pytest

from linkwright.pipeline.page.readers import SHOWN, readers
from linkwright.stages.export import export
from linkwright.stages.export.readers import READERS, dropped
from linkwright.stages.export.writers import WRITERS
from linkwright.stages.robot.model.geometry import Geometry, Shape
from linkwright.stages.robot.model.robot import Dynamics, Frame, Limits, Relation, frozen
from tests.support import drake
from tests.support.building import NO_MESHES, plan_of
from tests.support.robots import at, joint, loop, robot_with

HULL = Shape("arm", "collision", "arm_1.stl", None, 8, 12, 1.0, 1.0)
SKIN = Shape("arm", "visual", "arm.obj", None, 8, 12, 1.0, 1.0)


def everything():
    dynamics = Dynamics(0.1, 0.2, None, 3.0, 4.0)
    rows = [
        joint("revolute", "base", "arm", dynamics=dynamics),
        joint("ball", "arm", "hand", limits={"hand_joint": Limits(None, 1.0)}),
        joint("revolute", "base", "gear", dynamics=dynamics),
    ]
    relation = Relation("Gear", "gear_joint", "arm_joint", 2.0, 0.0)
    shut = loop("ball", "hand", "base", at(0, 0, 0), at(0, 0, 0), [(1.0, 0.0, 0.0, 0.0)])
    tip = Frame("tip", "hand", frozen(at(0, 0, 1)), "Tip")
    return robot_with(rows, relations=[relation], frames=[tip], loops=[shut])


def rows_of(robot, geometry: Geometry, *formats: str) -> dict:
    return {
        (row["reader"], row["format"], row["thing"]): row["of"] for row in dropped(robot, geometry, formats)
    }


def test_a_robot_with_everything_has_every_row() -> None:
    found = rows_of(everything(), Geometry((HULL, SKIN), {}), *WRITERS)
    assert set(found) == {(row.reader, row.format, row.thing) for row in READERS}
    assert found["Drake", "sdf", "loops"] == ["loop"]
    assert found["Isaac Sim", "urdf", "friction"] == ["arm_joint", "gear_joint"]
    assert found["PyBullet", "sdf", "balls"] == ["hand_joint"]
    assert found["PyBullet", "urdf", "frames"] == ["tip"]
    assert found["Pinocchio", "urdf", "relations"] == ["gear_joint"]
    assert found["Drake", "urdf", "colliders in STL"] == ["arm_1.stl"]
    assert found["Drake", "urdf", "fixed base"] == ["base"]


def test_only_what_a_robot_has_in_the_formats_that_are_written_is_told() -> None:
    robot = robot_with([joint("revolute", "base", "arm")], fixed=False)
    geometry = Geometry((replace(HULL, file="arm_1.obj"), SKIN), {})
    assert set(rows_of(robot, geometry, "urdf")) == {("PyBullet", "urdf", "inertia")}
    assert rows_of(robot, geometry, "sdf") == {}
    assert set(rows_of(robot, Geometry((HULL,), {}), "sdf")) == {("Drake", "sdf", "colliders in STL")}


@pytest.mark.parametrize("row", READERS, ids=lambda row: f"{row.reader} {row.format} {row.thing}")
def test_a_row_is_measured_or_has_its_source(row) -> None:
    assert row.format in WRITERS
    assert row.version
    assert row.does
    assert not row.source or row.source.startswith("https://")


def test_the_version_of_drake_is_that_of_the_tests() -> None:
    assert {row.version for row in READERS if row.reader == "Drake"} == {drake.VERSION}


def test_no_reader_has_two_rows_of_one_thing() -> None:
    keys = [(row.reader, row.version, row.format, row.thing) for row in READERS]
    assert len(set(keys)) == len(keys)


def test_a_build_tells_them_in_its_report() -> None:
    made = export(everything(), NO_MESHES, plan_of(export={"sdf": {}}))
    rows = json.loads(json.dumps(made.details))["readers"]
    assert {row["format"] for row in rows} == {"sdf"}
    page = readers(rows).replace("<wbr>", "")
    for text in ("What other readers drop", "bullet-featherstone", "gz-physics/issues/25", "measured"):
        assert text in page


def test_the_page_shows_some_names_and_counts_the_rest() -> None:
    names = [f"joint_{index}" for index in range(SHOWN + 3)]
    row = {
        "reader": "R",
        "version": "1",
        "format": "urdf",
        "thing": "friction",
        "does": "x",
        "of": names,
        "source": "s",
    }
    page = readers([row])
    assert f"joint_{SHOWN - 1} and 3 more" in page
    assert f"joint_{SHOWN}," not in page
    assert readers([]) == ""
