"""`geoms`: properties of contact reach every geom of the MJCF; what the URDF loses is reported."""

from collections.abc import Sequence
from pathlib import Path
from types import SimpleNamespace

import mujoco
import numpy as np
import pytest

from linkwright.pipeline.config.compose import compose_plan
from linkwright.stages.formats.meshes.surface import Surface
from linkwright.stages.mesh import make_geometry
from linkwright.stages.mesh.collide.collision import Collision
from linkwright.stages.mesh.colliders import hull
from linkwright.stages.mesh.configuration.collider_settings import HullSettings
from linkwright.stages.mesh.makers import MAKERS
from linkwright.stages.mesh.part_choices import part_choices, with_properties
from linkwright.stages.robot import codec
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.errors import ConfigError, MeshError
from linkwright.stages.robot.model.geom_form import ContactProperties
from linkwright.stages.robot.model.geometry import Geometry, Shape
from linkwright.stages.robot.model.robot import Primitive, Robot, frozen
from tests.support.building import bundle_of, plan_of, robot_of, write
from tests.support.kit import SIDE, TOP, Kit
from tests.support.robots import joint, robot_with

RUBBER = {"friction": [1.2, 0.005, 0.0001], "priority": 1, "condim": 4, "margin": 0.001}
SOFT = {"solref": [0.01, 1], "solimp": [0.9, 0.95, 0.001, 0.5, 2]}


def built(kit: Kit, geoms: object) -> tuple[Robot, Geometry]:
    base, arm = kit.place("Base", fixed=True), kit.place("Arm")
    kit.root.revolute("Elbow", (arm, TOP), (base, SIDE), value=0.3, limits=(-1, 1))
    robot, plan = robot_of(kit.document), plan_of(geoms=geoms)
    return robot, make_geometry(robot, bundle_of(kit.document), plan, lambda kind, key, make: make())


def ball_and_hull(surfaces: Sequence[Surface], settings: HullSettings) -> Collision:
    ball = Primitive("sphere", (0.02,), frozen(np.eye(4)))
    return Collision((*hull.make(surfaces, settings).pieces, ball))


def test_every_collider_of_a_link_has_its_properties(
    kit: Kit, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(MAKERS, "hull", SimpleNamespace(make=ball_and_hull))
    robot, geometry = built(kit, {"*": {"collision": SOFT}, "ar*": {"collision": RUBBER}})
    exported = write(robot, tmp_path, geometry=geometry)
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "robot.xml"))
    for name in ("arm_collision_0", "arm_collision_1"):
        geom = model.geom(name)
        assert geom.friction.tolist() == [1.2, 0.005, 0.0001]
        assert (geom.priority[0], geom.condim[0], geom.margin[0]) == (1, 4, 0.001)
    for name in ("arm_collision_0", "arm_collision_1", "base_collision_0", "base_collision_1"):
        assert model.geom(name).solref.tolist() == [0.01, 1]
        assert model.geom(name).solimp.tolist() == [0.9, 0.95, 0.001, 0.5, 2]
    default = mujoco.MjModel.from_xml_string("<mujoco><worldbody><geom size='1'/></worldbody></mujoco>")
    assert model.geom("base_collision_0").friction.tolist() == default.geom_friction[0].tolist()
    visual = [index for index in range(model.ngeom) if model.geom_group[index] == 2]
    assert {tuple(model.geom_friction[index]) for index in visual} == {tuple(default.geom_friction[0])}
    (lost,) = [one for one in exported.diagnostics if one.code == "I-URDF-CONTACT"]
    assert "arm: friction, condim, solref, solimp, margin, priority" in lost.message
    assert "base: solref, solimp" in lost.message


def test_later_entries_win_property_by_property(kit: Kit) -> None:
    _, geometry = built(
        kit,
        {
            "*": {"collision": {"condim": 6, "priority": 2}},
            "arm": {"collision": {"condim": 1}, "visual": SOFT},
        },
    )
    (arm,), (base,) = geometry.of("arm", "collision"), geometry.of("base", "collision")
    assert arm.contact == ContactProperties(condim=1, priority=2)
    assert base.contact == ContactProperties(condim=6, priority=2)
    assert geometry.of("arm", "visual")[0].contact == ContactProperties(
        solref=(0.01, 1), solimp=(0.9, 0.95, 0.001, 0.5, 2)
    )
    assert geometry.of("base", "visual")[0].contact is None
    assert codec.decode_geometry(codec.encode_geometry(geometry)).shapes == geometry.shapes


def test_without_the_key_nothing_is_written(kit: Kit, tmp_path: Path) -> None:
    robot, geometry = built(kit, {})
    write(robot, tmp_path, geometry=geometry)
    assert not {"friction", "condim", "priority"} & set((tmp_path / "robot.xml").read_text().split('"'))
    assert all(shape.contact is None for shape in geometry.shapes)


def test_a_glob_without_a_link_is_an_error_that_lists_them(kit: Kit) -> None:
    with pytest.raises(MeshError) as caught:
        built(kit, {"*": {}, "foot*": {"collision": RUBBER}})
    (problem,) = caught.value.problems
    assert (problem.code, problem.where) == ("E-GLOB", "geoms")
    assert "'foot*'" in problem.message
    assert "arm, base" in problem.hint


@pytest.mark.parametrize(
    "wrong",
    [
        {"friction": [1, 2]},
        {"friction": [-1, 0, 0]},
        {"condim": 2},
        {"condim": "3"},
        {"solref": [0.01, -1]},
        {"solimp": [0.9, 0.8, 0.001, 0.5, 2]},
        {"solimp": [0.9, 0.95, 0.001, 0.5, 0.5]},
        {"margin": -1},
        {"priority": 1.5},
        {"frictoin": [1, 1, 1]},
    ],
)
def test_impossible_values_are_refused(wrong: object) -> None:
    with pytest.raises(ConfigError, match="geoms"):
        plan_of(geoms={"*": {"collision": wrong}})


def test_a_base_for_legged_robots_needs_no_feet_and_gives_them_contact_of_their_own(tmp_path):
    (tmp_path / "robot").mkdir()
    text = "# @package _global_\ndefaults: [/robot/legged, override /source: sample]\n"
    (tmp_path / "robot" / "dog.yaml").write_text(text)
    plan = compose_plan(["robot=dog"], cwd=tmp_path).plan
    assert (plan.scene.option.cone, plan.scene.option.impratio, plan.root.base) == ("elliptic", 100, "free")
    (glob,) = plan.geoms
    links = robot_with([joint("revolute", "body", "left_foot")], root="body").links
    places = (("body", "collision"), ("left_foot", "collision"), ("left_foot", "visual"))
    shapes = tuple(Shape(link, role, None, None, 0, 0, 0.0, 0.0) for link, role in places)
    log = Diagnostics(optional=plan.optional)
    found = [one.contact for one in with_properties(shapes, {}, plan.geoms)]
    assert [one and one.priority for one in found] == [None, 1, None]
    part_choices(links[:1], plan, False, log)
    assert with_properties(shapes[:1], {}, plan.geoms) == shapes[:1]
    part_choices(links, plan_of(geoms={"*hoof*": plan.geoms[glob].model_dump()}), False, log)
    assert [(one.code, one.where) for one in (*log.found, *log.problems)] == [
        ("I-GLOB", "geoms"),
        ("E-GLOB", "geoms"),
    ]


def test_a_part_that_is_named_has_a_collider_with_properties_of_its_own(kit: Kit, tmp_path: Path) -> None:
    """A foot that is fastened to its shank, in one link, by each maker; and by a link's name both."""
    base, shank, foot = kit.place("Base", fixed=True), kit.place("Shank"), kit.place("Foot")
    kit.root.revolute("Knee", (shank, TOP), (base, SIDE), value=0.3, limits=(-1, 1))
    kit.root.fasten("On", (foot, SIDE), (shank, SIDE))
    robot = robot_of(kit.document)
    for collider in ("hull", "ladder", "primitives"):
        plan = plan_of(geoms={"Foo*": {"collision": RUBBER}}, mesh={"collider": collider})
        shapes = make_geometry(robot, bundle_of(kit.document), plan, lambda kind, key, make: make())
        properties = [one.contact for one in shapes.of("shank", "collision")]
        assert len(properties) == 2
        assert sorted(one.priority if one else 0 for one in properties) == [0, 1]
        assert all(
            one.contact is None for one in (*shapes.of("base", "collision"), *shapes.of("shank", "visual"))
        )
    plan = plan_of(geoms={"shank": {"collision": RUBBER}}, mesh={"collider": "hull"})
    shapes = make_geometry(robot, bundle_of(kit.document), plan, lambda kind, key, make: make())
    assert [one.contact.priority for one in shapes.of("shank", "collision")] == [1]
