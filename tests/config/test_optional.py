"""Globs of presets may match nothing, so that robots can share them; the robot's own must match."""

import pytest
import yaml

from linkwright.stages.export import export
from linkwright.stages.graph import build_robot
from linkwright.stages.mesh import make_geometry
from linkwright.stages.robot.errors import LinkwrightError
from linkwright.stages.robot.optional_section import GLOB_KEYS, all_globs
from tests.fake_onshape.sample import sample_document
from tests.support.building import bundle_of
from tests.support.touching import no_memo
from tests.support.users import GLOBAL, SAMPLE, composed, put, refused, write

LAB = yaml.safe_load("""
actuators: {"*wheel*": {type: velocity}}
contact: {exclude: [["*wheel*", "*fender*"]]}
depth: {rigid: ["*motor*"], flexible: ["*leg*"]}
frames: {include: ["*imu*"]}
geoms: {"*sole*": {collision: {priority: 1}}}
ignore: {visual: ["*cable*"], collision: ["*sticker*"]}
joints: {"*ankle*": {damping: 1}}
keyframes: {crouch: {"*knee*": 0.3}}
loops: {cut: ["*tie rod*"]}
mass: {parts: {"Battery*": {mass: 0.4}}, links: {"*hull*": {mass: 1}}}
mesh: {colliders: {"*sole*": box}}
mirrors: {"*mirror*": {normal: [0, 1, 0]}}
names: {links: {"Torso*": torso}, joints: {"Hip*": hip}}
relations: {"*differential*": {invert: true}}
sensors: {knees: {type: joint, joints: "*knee*"}, drives: {type: actuator, actuators: "*w*l"}}
variants: {n: 1, ranges: {"*.*nozzle*.*": 0.1}}
""")
"""A preset of a lab: for each key that holds globs a glob that nothing in the sample matches."""


def preset(folder, path, content):
    put(folder, {f"{path}.yaml": GLOBAL + yaml.safe_dump(content, sort_keys=False)})


def optional(folder, *arguments):
    return composed(folder, *arguments).plan.optional


def codes(folder, *arguments):
    """Code and place of all diagnostics of the stages about globs."""
    plan, bundle = composed(folder, *arguments).plan, bundle_of(sample_document())
    diagnostics = []
    try:
        robot = build_robot(bundle, plan)
        diagnostics += robot.diagnostics
        geometry = make_geometry(robot, bundle, plan, no_memo)
        diagnostics += geometry.diagnostics
        diagnostics += export(robot, geometry, plan).diagnostics
    except LinkwrightError as error:
        diagnostics += error.problems
    of_globs = ("I-GLOB", "E-GLOB", "E-RENAME")
    return [(problem.code, problem.where) for problem in diagnostics if problem.code in of_globs]


def test_globs_of_a_preset_may_match_nothing(tmp_path):
    assert all_globs(LAB).keys() == set(GLOB_KEYS)
    write(tmp_path, arm=f"{SAMPLE}  - override /mesh: visual\n")
    preset(tmp_path, "actuators/lab", LAB)
    shown = codes(tmp_path, "robot=arm", "actuators=lab")
    assert {code for code, _ in shown} == {"I-GLOB"}
    places = {
        where.partition(".")[0] if where.startswith(("sensors.", "keyframes.")) else where
        for _, where in shown
    }
    assert places == set(GLOB_KEYS)


@pytest.mark.slow
@pytest.mark.parametrize(
    "key", ["joints", "mass.parts", "geoms", "contact.exclude", "actuators", "sensors", "names.links"]
)
def test_the_same_globs_in_the_robots_file_are_errors(tmp_path, key):
    head = key.partition(".")[0]
    write(tmp_path, arm=f"{SAMPLE}  - override /mesh: visual\n" + yaml.safe_dump({head: LAB[head]}))
    assert {code for code, _ in codes(tmp_path, "robot=arm")} <= {"E-GLOB", "E-RENAME"}
    assert optional(tmp_path, "robot=arm") == {}


def test_presets_are_of_any_group_but_robot_and_experiment(tmp_path):
    base, arm = f"{SAMPLE}geoms: {{'*b': {{}}}}\n", f"{GLOBAL}defaults: [base]\ngeoms: {{'*a': {{}}}}\n"
    write(tmp_path, base=base, arm=arm)
    for path in ("experiment/e", "variants/v", "ground/g", "root/deep/r"):
        preset(tmp_path, path, {"geoms": {f"*{path[-1]}": {}}})
    typed = "robot=arm experiment=e +variants=v ground=g root=deep/r geoms.*t.collision.priority=1"
    plan = composed(tmp_path, *typed.split()).plan
    assert set(plan.geoms) == {"*a", "*b", "*e", "*v", "*g", "*r", "*t"}
    assert {key: set(globs) for key, globs in plan.optional.items()} == {"geoms": {"*v", "*g", "*r"}}


@pytest.mark.parametrize(
    ("robot", "expected"),
    [("dog", {"geoms": ("*[Ff]oot*",)}), ("legged", {"geoms": ("*[Ff]oot*",)}), ("sample", {})],
)
def test_a_robot_for_legs_needs_no_feet(tmp_path, robot, expected):
    write(tmp_path, dog=f"{GLOBAL}defaults: [/robot/legged, override /source: sample]\n")
    assert optional(tmp_path, f"robot={robot}", "source=sample") == expected


def test_globs_that_a_robot_replaces_are_no_longer_optional(tmp_path):
    keys = "frames: {include: ['*tool*']}\noptional: {joints: ['*mine*']}\njoints: {'*mine*': {}}\n"
    write(tmp_path, arm=SAMPLE + keys)
    preset(tmp_path, "root/lab", {"frames": {"include": ["*imu*"]}})
    assert optional(tmp_path, "robot=arm", "root=lab") == {"joints": ("*mine*",)}
    put(tmp_path, {"mesh/lab.yaml": "collider: hull\ncolliders: {'*sole*': box}\n"})
    globs = {"joints": ("*mine*",), "mesh.colliders": ("*sole*",)}
    assert optional(tmp_path, "robot=arm", "mesh=lab") == globs, "the place of a preset in the tree counts"


def test_an_optional_glob_that_does_not_exist_is_refused(tmp_path):
    write(tmp_path, arm=f"{SAMPLE}optional: {{joints: ['*ankel*']}}\njoints: {{'*ankle*': {{damping: 1}}}}\n")
    assert "optional.joints: joints has no glob '*ankel*'" in refused(tmp_path, "robot=arm")
    shown = refused(tmp_path, "source=sample", "optional.masses=[a]")
    assert "optional: masses holds no globs" in shown
