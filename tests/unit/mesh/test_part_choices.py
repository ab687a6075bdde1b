"""What globs choose for parts: the contact of their geoms, what is ignored; and keys that change nothing."""

from dataclasses import replace
from types import SimpleNamespace

import mujoco
import numpy as np
import pytest

from linkwright.pipeline.config.compose import compose_plan
from linkwright.stages.mesh import BY_CONTACT, COLLIDERS, make_geometry
from linkwright.stages.mesh.collide import make as collide
from linkwright.stages.mesh.collide.collision import Collision
from linkwright.stages.mesh.colliders import hull
from linkwright.stages.mesh.idle_keys import idle_key_reports
from linkwright.stages.mesh.makers import MAKERS
from linkwright.stages.mesh.part_choices import part_choices, with_properties
from linkwright.stages.mesh.section import MeshSections
from linkwright.stages.robot import codec
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.errors import ConfigError, MeshError
from linkwright.stages.robot.model.geom_form import ContactProperties
from linkwright.stages.robot.model.geometry import Shape
from linkwright.stages.robot.model.robot import Primitive, frozen
from tests.support.building import plan_of, shaped, write
from tests.support.exports import compiled, exported
from tests.support.kit import SIDE, TOP, hinged
from tests.support.robots import joint, robot_with
from tests.support.touching import ball, no_memo
from tests.unit.mesh.test_collide import BRACKET, bundle, kinds, part, robot

RUBBER = {"friction": [1.2, 0.005, 0.0001], "priority": 1, "condim": 4, "margin": 0.001}
SOFT = {"solref": [0.01, 1], "solimp": [0.9, 0.95, 0.001, 0.5, 2]}


def ball_and_hull(surfaces, settings):
    return Collision((*hull.make(surfaces, settings).pieces, ball(0.02)))


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


def test_base_for_legged_robots_needs_no_feet(tmp_path):
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
    problems = [(problem.code, problem.where) for problem in (*log.notes, *log.problems)]
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
def test_part_that_is_named_has_a_collider_of_its_own(kit, glob, collider, priorities):
    """A foot that is fastened to its shank, in one link."""
    base, shank, foot = kit.place("Base", fixed=True), kit.place("Shank"), kit.place("Foot")
    kit.root.revolute("Knee", (shank, TOP), (base, SIDE), value=0.3, limits=(-1, 1))
    kit.root.fasten("On", (foot, SIDE), (shank, SIDE))
    keys = {"geoms": {glob: {"collision": RUBBER}}, "mesh": {"collider": collider}}
    _, geometry, _ = shaped(kit.document, **keys)
    contacts = [shape.contact for shape in geometry.shapes_of("shank", "collision")]
    assert sorted(contact.priority if contact else 0 for contact in contacts) == priorities
    unnamed = (*geometry.shapes_of("base", "collision"), *geometry.shapes_of("shank", "visual"))
    assert {shape.contact for shape in unnamed} == {None}


BALL = Primitive("sphere", (0.01,), frozen(np.eye(4)))
BOTH = robot(part("Block <1>"), part(BRACKET, 0.2), shapes=(BALL,))


def made(value, **keys):
    merged = {"mesh": {"collider": "hull", "visual": {"merge": "part"}}, **keys}
    return make_geometry(value, bundle(), MeshSections.model_validate(merged), no_memo)


@pytest.mark.parametrize(
    ("visual", "collision", "seen", "solid"),
    [
        ((), (), {"base_block.stl", "base_bracket.stl", "primitive"}, [(BRACKET, "Block <1>")]),
        (["Bl*"], (), {"base_bracket.stl", "primitive"}, [(BRACKET, "Block <1>")]),
        ((), ["Arm <1>/*"], {"base_block.stl", "base_bracket.stl", "primitive"}, [("Block <1>",)]),
        (["Br*"], ["Br*"], {"base_block.stl", "primitive"}, [("Block <1>",)]),
        (["base"], ["Block"], set(), [(BRACKET,)]),
        (["*"], ["*"], set(), []),
    ],
)
def test_globs_on_links_and_parts(visual, collision, seen, solid):
    geometry = made(BOTH, ignore={"visual": visual, "collision": collision})
    assert {shape.file or "primitive" for shape in geometry.shapes if shape.role == "visual"} == seen
    assert [tuple(sorted(names)) for names in kinds(geometry)] == solid
    balls = [shape for shape in geometry.shapes_of("base", "collision") if shape.primitive is not None]
    assert len(balls) == ("*" not in collision)


def test_ignored_part_costs_no_collider(monkeypatch):
    names = set()
    monkeypatch.setattr(
        collide._ColliderMaker, "_make", lambda self, job, function: names.add(job.name) or Collision()
    )
    keys = {"mesh": {"collider": "coacd", "colliders": {"Bracket": "coacd"}}}
    made(BOTH, **keys, ignore={"collision": ["Bracket"]})
    assert names == {"Block <1>"}


def test_model_weighs_as_much_and_has_no_such_geom():
    arm = robot_with([joint("revolute", "base", "arm", name="elbow")])
    value = replace(arm, links=tuple(replace(link, parts=(part("Block <1>"),)) for link in arm.links))
    models = [
        compiled(exported(value, made(value, ignore=ignore)))
        for ignore in ({}, {"visual": ["base"], "collision": ["arm"]})
    ]

    def geoms(model):
        rows = [model.geom(number) for number in range(model.ngeom)]
        return sorted((model.body(int(geom.bodyid[0])).name, int(geom.group[0])) for geom in rows)

    assert geoms(models[0]) == [("arm", 2), ("arm", 3), ("base", 2), ("base", 3)]
    assert geoms(models[1]) == [("arm", 2), ("base", 3)]
    np.testing.assert_array_equal(models[0].body_mass, models[1].body_mass)
    np.testing.assert_array_equal(models[0].body_inertia, models[1].body_inertia)


@pytest.mark.parametrize(
    ("keys", "globs"),
    [
        ({"ignore": {"visual": ["Screw*", "*"], "collision": ["bse"]}},
         {"ignore.visual": "Screw*", "ignore.collision": "bse"}),
        ({"geoms": {"*": {}, "foot*": {"collision": {"condim": 4}}}}, {"geoms": "foot*"}),
        ({"mesh": {"collider": "ladder", "colliders": {"Finger*": "box", "*": "ladder"}}},
         {"mesh.colliders": "Finger*"}),
    ],
    ids=["ignore", "geoms", "colliders"],
)  # fmt: skip
def test_glob_without_a_match_lists_what_there_is(keys, globs):
    with pytest.raises(MeshError) as caught:
        made(BOTH, **keys)
    problems = {problem.where: problem for problem in caught.value.problems}
    assert {problem.code for problem in problems.values()} == {"E-GLOB"}
    assert problems.keys() == globs.keys()
    for where, problem in problems.items():
        assert globs[where] in problem.message
        assert "links are: base; parts are: Block, Bracket" in problem.hint


EXCLUDED = {"exclude": [["a", "b"]]}


@pytest.mark.parametrize(
    ("keys", "maker", "source", "named"),
    [
        ({}, None, "onshape", ""),
        ({"mesh__tolerance": 0.002}, None, "onshape", "mesh.tolerance"),
        ({"mesh__tolerance": 0.002}, COLLIDERS["spheres"], "onshape", ""),
        ({"mesh": {"tolerance": 0.002, "effort": "low"}}, COLLIDERS["ladder"], "onshape", ""),
        ({"mesh": {"effort": "low", "fine": "all"}}, BY_CONTACT, "onshape", "mesh.effort"),
        ({"mesh__fine": "all"}, COLLIDERS["hull"], "onshape", "mesh.fine"),
        ({"mesh": {"collider": "spheres", "effort": "low"}}, COLLIDERS["spheres"], "onshape", "mesh.effort"),
        ({"mesh": {"coacd": {"mcts_iterations": 9}, "extra_volume": 1}}, COLLIDERS["coacd"], "urdf",
         "mesh.extra_volume"),
        ({"mesh__basis": "visual"}, None, "onshape", "mesh.basis"),
        ({"mesh__basis": "visual"}, None, "mjcf", ""),
        ({"mesh__glb_up": "y"}, None, "onshape", "mesh.glb_up"),
        ({"mesh": {"glb_up": "y", "format": "glb"}}, None, "onshape", ""),
        ({"contact": EXCLUDED}, None, "onshape", "contact.exclude"),
        ({"contact": {**EXCLUDED, "self": "auto"}}, None, "onshape", ""),
    ],
)  # fmt: skip
def test_key_that_nothing_reads_is_named(keys, maker, source, named):
    problems = list(idle_key_reports(plan_of(**keys), (maker,) if maker else (), source))
    assert [(problem.code, problem.where) for problem in problems] == [("I-IDLE-KEY", named)] * bool(named)
