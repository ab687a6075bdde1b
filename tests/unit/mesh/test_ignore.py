"""`ignore`: what is not drawn and what touches nothing, while all that it weighs stays."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest

from linkwright.stages.mesh import make_geometry
from linkwright.stages.mesh.collide import make as collide
from linkwright.stages.mesh.collide.collision import Collision
from linkwright.stages.mesh.section import MeshSections
from linkwright.stages.robot.errors import MeshError
from linkwright.stages.robot.model.geometry import Geometry
from linkwright.stages.robot.model.robot import Primitive, Robot, frozen
from tests.support.building import plan_of, write
from tests.support.robots import joint, robot_with
from tests.unit.mesh.test_collide import at, bundle, part, robot, rungs

BALL = Primitive("sphere", (0.01,), frozen(np.eye(4)))
BOTH = robot(part("Block <1>"), part("Arm <1>/Bracket <1>", at(0.2)), shapes=(BALL,))


def made(value: Robot, **keys: Any) -> Geometry:
    given = {"mesh": {"collider": "hull", "visual": {"merge": "part"}}, **keys}
    return make_geometry(value, bundle(), MeshSections.model_validate(given), lambda kind, key, make: make())


def drawn(geometry: Geometry) -> set[str]:
    return {shape.file or "primitive" for shape in geometry.shapes if shape.role == "visual"}


@pytest.mark.parametrize(
    ("ignore", "seen", "solid"),
    [
        ({}, {"base_block.stl", "base_bracket.stl", "primitive"}, [("Arm <1>/Bracket <1>", "Block <1>")]),
        ({"visual": ["Bl*"]}, {"base_bracket.stl", "primitive"}, [("Arm <1>/Bracket <1>", "Block <1>")]),
        ({"collision": ["Arm <1>/*"]}, {"base_block.stl", "base_bracket.stl", "primitive"}, [("Block <1>",)]),
        ({"visual": ["Br*"], "collision": ["Br*"]}, {"base_block.stl", "primitive"}, [("Block <1>",)]),
        ({"visual": ["base"], "collision": ["Block"]}, set(), [("Arm <1>/Bracket <1>",)]),
        ({"visual": ["*"], "collision": ["*"]}, set(), []),
    ],
)  # fmt: skip
def test_globs_on_links_and_parts(ignore: Any, seen: set[str], solid: list[Any]) -> None:
    geometry = made(BOTH, ignore=ignore)
    assert drawn(geometry) == seen
    assert [tuple(sorted(names)) for names in rungs(geometry)] == solid
    balls = [shape for shape in geometry.of("base", "collision") if shape.primitive is not None]
    assert len(balls) == ("*" not in ignore.get("collision", ()))


def test_an_ignored_part_costs_no_collider(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[str] = []

    def noted(self: Any, job: Any, how: str) -> Collision:
        asked.append(job.name)
        return Collision()

    monkeypatch.setattr(collide._Made, "_make", noted)
    keys = {"mesh": {"collider": "coacd", "colliders": {"Bracket": "coacd"}}}
    made(BOTH, **keys, ignore={"collision": ["Bracket"]})
    assert set(asked) == {"Block <1>"}


def test_the_model_weighs_as_much_and_has_no_such_geom(tmp_path: Path) -> None:
    arm = robot_with([joint("revolute", "base", "arm", name="elbow")])
    links = tuple(replace(link, parts=(part("Block <1>"),)) for link in arm.links)
    value = replace(arm, links=links)
    models = {}
    for name, ignore in (("all", {}), ("less", {"visual": ["base"], "collision": ["arm"]})):
        geometry = made(value, ignore=ignore)
        write(value, tmp_path / name, plan_of(), geometry)
        models[name] = mujoco.MjModel.from_xml_path(str(tmp_path / name / "robot.xml"))

    def geoms(name: str) -> list[tuple[str, int]]:
        geoms = [models[name].geom(number) for number in range(models[name].ngeom)]
        return [(models[name].body(int(one.bodyid[0])).name, int(one.group[0])) for one in geoms]

    assert sorted(geoms("all")) == [("arm", 2), ("arm", 3), ("base", 2), ("base", 3)]
    assert sorted(geoms("less")) == [("arm", 2), ("base", 3)]
    np.testing.assert_array_equal(models["all"].body_mass, models["less"].body_mass)
    np.testing.assert_array_equal(models["all"].body_inertia, models["less"].body_inertia)


def test_a_glob_without_a_match_says_what_there_is() -> None:
    with pytest.raises(MeshError) as caught:
        made(BOTH, ignore={"visual": ["Screw*", "*"], "collision": ["bse"]})
    one, other = caught.value.problems
    assert (one.code, one.where, other.where) == ("E-GLOB", "ignore.visual", "ignore.collision")
    assert "Screw*" in one.message
    assert "bse" in other.message
    assert "links are: base; parts are: Block, Bracket" in one.hint
