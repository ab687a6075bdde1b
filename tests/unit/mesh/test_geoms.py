"""`geoms`: properties of contact reach every geom of the MJCF; what the URDF loses is reported."""

from types import SimpleNamespace

import mujoco
import numpy as np
import pytest

from linkwright.pipeline.config.compose import compose_plan
from linkwright.stages.mesh.collide.collision import Collision
from linkwright.stages.mesh.colliders import hull
from linkwright.stages.mesh.makers import MAKERS
from linkwright.stages.mesh.part_choices import part_choices, with_properties
from linkwright.stages.robot import codec
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.errors import ConfigError, MeshError
from linkwright.stages.robot.model.geom_form import ContactProperties
from linkwright.stages.robot.model.geometry import Shape
from linkwright.stages.robot.model.robot import Primitive, frozen
from tests.support.building import plan_of, shaped, write
from tests.support.kit import SIDE, TOP, hinged
from tests.support.robots import joint, robot_with

RUBBER = {"friction": [1.2, 0.005, 0.0001], "priority": 1, "condim": 4, "margin": 0.001}
SOFT = {"solref": [0.01, 1], "solimp": [0.9, 0.95, 0.001, 0.5, 2]}
BALL = Primitive("sphere", (0.02,), frozen(np.eye(4)))


def ball_and_hull(surfaces, settings):
    return Collision((*hull.make(surfaces, settings).pieces, BALL))


def test_every_collider_of_a_link_has_its_properties(kit, tmp_path, monkeypatch):
    monkeypatch.setitem(MAKERS, "hull", SimpleNamespace(make=ball_and_hull))
    hinged(kit)
    geoms = {"*": {"collision": SOFT}, "ar*": {"collision": RUBBER}}
    robot, geometry, _ = shaped(kit.document, geoms=geoms)
    exported = write(robot, tmp_path, geometry=geometry)
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "robot.xml"))
    default = mujoco.MjModel.from_xml_string("<mujoco><worldbody><geom size='1'/></worldbody></mujoco>")
    for link, number in (("arm", 0), ("arm", 1), ("base", 0), ("base", 1)):
        geom = model.geom(f"{link}_collision_{number}")
        assert {name: getattr(geom, name).tolist() for name in SOFT} == SOFT
        if link == "arm":
            assert geom.friction.tolist() == RUBBER["friction"]
            assert (geom.priority[0], geom.condim[0], geom.margin[0]) == (1, 4, 0.001)
        else:
            assert geom.friction.tolist() == default.geom_friction[0].tolist()
    visual = [index for index in range(model.ngeom) if model.geom_group[index] == 2]
    assert {tuple(model.geom_friction[index]) for index in visual} == {tuple(default.geom_friction[0])}
    (lost,) = [diagnostic for diagnostic in exported.diagnostics if diagnostic.code == "I-URDF-CONTACT"]
    assert "arm: friction, condim, solref, solimp, margin, priority" in lost.message
    assert "base: solref, solimp" in lost.message


def test_later_entries_win_property_by_property(kit):
    hinged(kit)
    both, arm = {"condim": 6, "priority": 2}, {"collision": {"condim": 1}, "visual": SOFT}
    _, geometry, _ = shaped(kit.document, geoms={"*": {"collision": both}, "arm": arm})
    soft = ContactProperties(solref=(0.01, 1), solimp=(0.9, 0.95, 0.001, 0.5, 2))
    assert {(shape.link, shape.role): shape.contact for shape in geometry.shapes} == {
        ("arm", "collision"): ContactProperties(condim=1, priority=2),
        ("arm", "visual"): soft,
        ("base", "collision"): ContactProperties(condim=6, priority=2),
        ("base", "visual"): None,
    }
    assert codec.decode_geometry(codec.encode_geometry(geometry)).shapes == geometry.shapes


def test_without_the_key_nothing_is_written(kit, tmp_path):
    hinged(kit)
    robot, geometry, _ = shaped(kit.document, geoms={})
    write(robot, tmp_path, geometry=geometry)
    assert not {"friction", "condim", "priority"} & set((tmp_path / "robot.xml").read_text().split('"'))
    assert all(shape.contact is None for shape in geometry.shapes)


def test_glob_without_a_link_is_an_error_that_lists_them(kit):
    hinged(kit)
    with pytest.raises(MeshError) as caught:
        shaped(kit.document, geoms={"*": {}, "foot*": {"collision": RUBBER}})
    (problem,) = caught.value.problems
    assert (problem.code, problem.where) == ("E-GLOB", "geoms")
    assert "'foot*'" in problem.message
    assert "arm, base" in problem.hint


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("friction", [1, 2]),
        ("friction", [-1, 0, 0]),
        ("condim", 2),
        ("condim", "3"),
        ("solref", [0.01, -1]),
        ("solimp", [0.9, 0.8, 0.001, 0.5, 2]),
        ("solimp", [0.9, 0.95, 0.001, 0.5, 0.5]),
        ("margin", -1),
        ("priority", 1.5),
        ("frictoin", [1, 1, 1]),
    ],
)
def test_impossible_values_are_refused(key, value):
    with pytest.raises(ConfigError, match="geoms"):
        plan_of(geoms={"*": {"collision": {key: value}}})


def test_base_for_legged_robots_needs_no_feet_and_gives_them_contact(tmp_path):
    (tmp_path / "robot").mkdir()
    text = "# @package _global_\ndefaults: [/robot/legged, override /source: sample]\n"
    (tmp_path / "robot" / "dog.yaml").write_text(text)
    plan = compose_plan(["robot=dog"], cwd=tmp_path).plan
    assert (plan.scene.option.cone, plan.scene.option.impratio, plan.root.base) == ("elliptic", 100, "free")
    (glob,) = plan.geoms
    links = robot_with([joint("revolute", "body", "left_foot")], root="body").links
    places = (("body", "collision"), ("left_foot", "collision"), ("left_foot", "visual"))
    shapes = tuple(Shape(link, role, None, None, 0, 0, 0.0, 0.0) for link, role in places)
    contacts = [shape.contact for shape in with_properties(shapes, {}, plan.geoms)]
    assert [contact and contact.priority for contact in contacts] == [None, 1, None]
    assert with_properties(shapes[:1], {}, plan.geoms) == shapes[:1]
    log = Diagnostics(optional=plan.optional)
    part_choices(links[:1], plan, False, log)
    part_choices(links, plan_of(geoms={"*hoof*": plan.geoms[glob].model_dump()}), False, log)
    problems = [(problem.code, problem.where) for problem in (*log.found, *log.problems)]
    assert problems == [("I-GLOB", "geoms"), ("E-GLOB", "geoms")]


@pytest.mark.parametrize(
    ("glob", "collider", "priorities"),
    [
        ("Foo*", "hull", [0, 1]),
        ("Foo*", "ladder", [0, 1]),
        ("Foo*", "primitives", [0, 1]),
        ("shank", "hull", [1]),
    ],
)
def test_part_that_is_named_has_a_collider_with_its_own_properties(kit, glob, collider, priorities):
    """A foot that is fastened to its shank, in one link."""
    base, shank, foot = kit.place("Base", fixed=True), kit.place("Shank"), kit.place("Foot")
    kit.root.revolute("Knee", (shank, TOP), (base, SIDE), value=0.3, limits=(-1, 1))
    kit.root.fasten("On", (foot, SIDE), (shank, SIDE))
    keys = {"geoms": {glob: {"collision": RUBBER}}, "mesh": {"collider": collider}}
    _, geometry, _ = shaped(kit.document, **keys)
    contacts = [shape.contact for shape in geometry.of("shank", "collision")]
    assert sorted(contact.priority if contact else 0 for contact in contacts) == priorities
    others = (*geometry.of("base", "collision"), *geometry.of("shank", "visual"))
    assert {shape.contact for shape in others} == {None}
