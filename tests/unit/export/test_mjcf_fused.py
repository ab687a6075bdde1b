"""Links on fixed joints in the MJCF: no bodies of their own, and nothing of them lost."""

import json
from dataclasses import replace

import mujoco
import numpy as np
import pytest

from linkwright.stages.formats.mjcf.form import MjcfForm
from linkwright.stages.formats.mjcf.written import mjcf_form
from linkwright.stages.formats.xml import parse
from linkwright.stages.robot.model.geometry import Exclude, Geometry, Touch
from linkwright.stages.robot.model.poses import from_parts, rotation_from_quat, turn
from linkwright.stages.robot.model.robot import Frame, Primitive, Sensor, frozen
from linkwright.stages.validate import validate
from tests.support.building import NO_MESHES, plan_of, solid, write
from tests.support.engines import Mujoco, Pinocchio
from tests.support.exports import exported, messages_of
from tests.support.robots import at, joint, loop, pose, robot_with, some_values
from tests.support.states import run, state
from tests.support.touching import ball

pytestmark = pytest.mark.usefixtures("no_score")

PLACES = [pose(np.random.default_rng(seed)) for seed in range(6)]
KEEP = {"mjcf": {"fixed_joints": "keep"}, "urdf": {}}


def arm(root="base", **more):
    """base – turn – arm – fixed – plate – fixed – tip – turn – hand; mast fixed to the base."""
    rows = [
        joint("revolute", root, "arm", place=PLACES[0]), joint("fixed", "arm", "plate", place=PLACES[1]),
        joint("fixed", "plate", "tip", place=PLACES[2]), joint("revolute", "tip", "hand", place=PLACES[3]),
        joint("fixed", root, "mast", place=PLACES[4]),
    ]  # fmt: skip
    box = Primitive("box", (0.02, 0.03, 0.04), frozen(PLACES[5]))
    shapes = dict.fromkeys(("arm", "plate", "tip", "hand", "mast"), (box,))
    frames = (Frame("tool", "tip", frozen(PLACES[5]), "Tool"), *more.pop("frames", ()))
    robot = robot_with(rows, root=root, frames=frames, shapes=shapes, **more)
    return robot, solid(robot)


def written(robot, geometry, folder, plan=None):
    """The MJCF, checked by the validate stage."""
    exported = write(robot, folder, plan, geometry)
    checks = validate(folder, exported.written, plan or plan_of())
    # What these links weigh was not drawn to fit their shapes.
    assert [check.name for check in checks if check.fails and check.code != "C-INERTIAL"] == []
    return Mujoco(folder / "robot.xml")


def bodies(engine):
    return [engine.model.body(index).name for index in range(1, engine.model.nbody)]


def test_mjcf_moves_and_weighs_as_the_urdf_does(tmp_path):
    robot, geometry = arm()
    fused = written(robot, geometry, tmp_path)
    assert bodies(fused) == ["base", "arm", "hand"]
    urdf = Pinocchio((tmp_path / "robot.urdf").read_bytes())
    dofs = [dof.name for dof in robot.dofs]
    rng = np.random.default_rng(7)
    for _ in range(5):
        q = some_values(robot, rng)
        actual, expected = fused.poses(q), urdf.poses(q)
        root_from_world = np.linalg.inv(actual["base"])
        for name in [link.name for link in robot.links] + ["tool"]:
            assert np.abs(root_from_world @ actual[name] - expected[name]).max() < 1e-9, name
        assert np.abs(fused.mass_matrix(q, dofs) - urdf.mass_matrix(q, dofs)).max() < 1e-9
        assert np.abs(fused.gravity(q, dofs) - urdf.gravity(q, dofs)).max() < 1e-9


@pytest.mark.skipif(
    tuple(map(int, mujoco.__version__.split(".")[:2])) < (3, 4),
    reason="the fusestatic of MuJoCo 3.3.3 gives a body another inertia than 4.0; ours are alike",
)
def test_bodies_are_those_that_mujoco_fuses(tmp_path):
    """Its own `fusestatic` is the oracle of masses, inertias and shapes."""
    robot, geometry = arm()
    fused = written(robot, geometry, tmp_path / "fused").model
    kept = written(robot, geometry, tmp_path / "kept", plan_of(export=KEEP)).model
    assert kept.nbody == 1 + len(robot.links)
    text = (tmp_path / "kept" / "robot.xml").read_text()
    text = text.replace("<compiler ", '<compiler fusestatic="true" ')
    oracle = mujoco.MjModel.from_xml_string(text)
    # Only bodies of the tree: it takes what is fixed to the world into the world.
    for name in ("arm", "hand"):
        ours, other = fused.body(name), oracle.body(name)
        assert ours.mass == pytest.approx(other.mass, rel=1e-12)
        tensors = []
        for model, body in ((fused, ours), (oracle, other)):
            turned = rotation_from_quat(model.body_iquat[body.id])
            tensors.append(turned @ np.diag(body.inertia) @ turned.T)
        assert np.abs(tensors[0] - tensors[1]).max() < 1e-9 * np.abs(tensors[1]).max()
        assert np.abs(ours.ipos - other.ipos).max() < 1e-9
    assert np.abs(geoms_of(fused) - geoms_of(kept)).max() < 1e-9


def geoms_of(model):
    """The places and axes of the geoms, in their order."""
    data = state(model)
    return np.array(sorted(np.hstack([data.geom_xpos, data.geom_xmat]).tolist()))


def test_link_fixed_to_a_root_called_world_has_a_body(tmp_path):
    robot, geometry = arm("world")
    engine = written(robot, geometry, tmp_path)
    assert sorted(bodies(engine)) == ["arm", "hand", "mast"]
    total = sum(link.inertial.mass for link in robot.links)
    assert engine.model.body_mass.sum() == pytest.approx(total, abs=1e-9)


@pytest.mark.parametrize(("code", "key", "export"), [
    ("I-MJCF-MERGED", "fused", {"mjcf": {}}),
    ("I-URDF-MERGED", "merged", {"urdf": {"fixed_joints": "merge"}}),
])  # fmt: skip
def test_robot_json_and_a_diagnostic_say_where_the_links_are(code, key, export):
    robot, geometry = arm()
    outcome = exported(robot, geometry, export=export)
    (message,) = messages_of(outcome, code)
    assert message.endswith("plate into arm, tip into arm, mast into base")
    table = json.loads(outcome.files["robot.json"])
    places = {entry["link"]: (entry["into"], entry["pose"]["xyz"]) for entry in table[key]}
    assert places["tip"][0] == "arm"
    assert np.abs((PLACES[1] @ PLACES[2])[:3, 3] - places["tip"][1]).max() < 1e-11
    assert len(table["links"]) == len(robot.links)
    kept = exported(robot, geometry, export=KEEP)
    assert key not in json.loads(kept.files["robot.json"])
    assert not messages_of(kept, code)


def test_cameras_and_gravity_compensation_stay_with_the_link(tmp_path):
    robot, geometry = arm()
    keys = {
        "scene__cameras": {"eye": {"frame": "tip", "xyz": [0.1, 0, 0]}},
        "actuators": {"*": {"type": "position", "gravcomp": 1}},
    }
    fused = written(robot, geometry, tmp_path / "fused", plan_of(**keys))
    kept = written(robot, geometry, tmp_path / "kept", plan_of(**keys, export=KEEP))
    cameras, forces = [], []
    for engine in (fused, kept):
        q = some_values(robot, np.random.default_rng(3))
        engine.poses(q)
        mujoco.mj_camlight(engine.model, engine.data)
        mujoco.mj_forward(engine.model, engine.data)
        cameras.append(np.hstack([engine.data.cam_xpos[0], engine.data.cam_xmat[0]]))
        forces.append(np.array(engine.data.qfrc_gravcomp))
    assert np.abs(cameras[0] - cameras[1]).max() < 1e-9
    assert np.abs(forces[0]).max() > 0.1
    assert np.abs(forces[0] - forces[1]).max() < 1e-9


SPIN = Sensor("spin", "frameangvel", "xbody", "tip")
RELATIVE = Sensor("spin", "frameangvel", "site", "tool", "xbody", "mast")
BODIES = {
    "nothing needs one": ({}, "plate tip mast"),
    "a sensor": ({"sensors": (SPIN,)}, "plate mast"),
    # What is fused into a body moves its centre of mass, where its sensors are.
    "a sensor at the centre": ({"sensors": (Sensor("place", "framepos", "body", "arm"),)}, "tip mast"),
    "a sensor relative to it": ({"sensors": (RELATIVE,)}, "plate tip"),
    "a frame of its name elsewhere": (
        {"frames": (Frame("tip", "hand", frozen(np.eye(4)), ""),)}, "plate mast"),
    "a frame of its name": ({"frames": (Frame("tip", "tip", frozen(np.eye(4)), ""),)}, "plate tip mast"),
    "a loop in its body": (
        {"loops": (loop("revolute", "tip", "arm", np.eye(4), PLACES[1] @ PLACES[2]),)}, "plate mast"),
    "a loop": ({"loops": (loop("revolute", "hand", "mast", np.eye(4), np.eye(4)),)}, "plate tip mast"),
}  # fmt: skip


@pytest.mark.parametrize(("fields", "fused"), BODIES.values(), ids=BODIES)
def test_links_that_need_a_body_keep_it(fields, fused):
    assert mjcf_form(replace(arm()[0], **fields)) == MjcfForm(tuple(fused.split()))


def test_link_with_nearly_the_frame_of_its_body_stays(tmp_path):
    """MuJoCo takes frames for the same that differ by less than 1e-6; the file does not."""
    turned = from_parts(turn(np.array([0.0, 0.6, 0.8]), 6.5e-7), np.array([0.0, 0.0, 0.3]))
    robot = robot_with([joint("revolute", "base", "arm"), joint("fixed", "arm", "plate", place=turned)])
    engine = written(robot, NO_MESHES, tmp_path)
    poses = engine.poses({"arm_joint": 0.4})
    assert bodies(engine) == ["base", "arm"]
    assert np.abs(np.linalg.inv(poses["arm"]) @ poses["plate"] - turned).max() < 1e-12


def test_site_of_the_name_is_there_once(tmp_path):
    robot, geometry = arm(frames=(Frame("mast", "mast", frozen(np.eye(4)), ""),))
    written(robot, geometry, tmp_path)
    names = [site.get("name") for site in parse((tmp_path / "robot.xml").read_bytes()).iter("site")]
    assert sorted(names) == ["mast", "plate", "tip", "tool"]


@pytest.mark.parametrize("kind", ["revolute", "ball", "fixed", "cylindrical"])
def test_loops_hold_a_fused_link(tmp_path, kind):
    """A link held by a loop that ends on a link that is fused, against the same with a body."""
    rows = [
        joint("revolute", "base", "arm"), joint("fixed", "arm", "plate", place=PLACES[1]),
        joint("revolute", "base", "rod", place=at(0, 0.1, 0)),
    ]  # fmt: skip
    bare = robot_with(rows)
    rod_from_plate = np.linalg.inv(at(0, 0.1, 0)) @ PLACES[1]
    closed = replace(bare, loops=(loop(kind, "plate", "rod", np.eye(4), rod_from_plate),))
    ways = []
    for name, plan in (("fused", plan_of()), ("kept", plan_of(export=KEEP))):
        model = written(closed, NO_MESHES, tmp_path / name, plan).model
        data = run(model, mujoco.MjData(model), 0.2)
        ways.append([float(data.joint(joint).qpos[0]) for joint in ("arm_joint", "rod_joint")])
    assert np.abs(np.array(ways[0]) - ways[1]).max() < 1e-4


def side_by_side():
    """An arm with a plate fixed to it, and a rod: a ball of the rod is in one of each of the others."""
    rows = [
        joint("revolute", "base", "arm"), joint("fixed", "arm", "plate", place=at(0, 0, 1)),
        joint("revolute", "base", "rod"),
    ]  # fmt: skip
    low, high = (ball(0.1, at(0, 0, height)) for height in (0.0, 1.0))
    robot = robot_with(rows, shapes={"arm": (low,), "plate": (low,), "rod": (low, high)})
    return robot, solid(robot).shapes


def touching(engine):
    data = state(engine.model)
    pairs = (contact.geom for contact in data.contact[: data.ncon])
    return {frozenset(engine.model.geom(geom).name for geom in pair) for pair in pairs}


@pytest.mark.parametrize("excluded", [(), ("plate",), ("arm",), ("arm", "plate")])
def test_excludes_are_by_the_links_that_were_meant(tmp_path, excluded):
    robot, shapes = side_by_side()
    apart = tuple(Exclude(link, "rod", "User", 0.0) for link in excluded)
    meet = tuple(Touch(link, "rod", 0.2) for link in ("arm", "plate") if link not in excluded)
    geometry = Geometry(shapes, {}, self_contact=True, excludes=apart, touching=meet)
    colliding = [
        touching(written(robot, geometry, tmp_path / name, plan))
        for name, plan in (("fused", plan_of()), ("kept", plan_of(export=KEEP)))
    ]
    expected = {"arm": {"arm_collision", "rod_collision_0"}, "plate": {"plate_collision", "rod_collision_1"}}
    meeting = {frozenset(expected[link]) for link in expected if link not in excluded}
    assert colliding == [meeting, meeting]
    pairs = parse((tmp_path / "fused" / "robot.xml").read_bytes()).findall("contact/exclude")
    assert len(pairs) == bool(excluded)


def test_links_keep_bodies_to_be_excluded_alone():
    """Each plate is apart from another rod, from which the arm below it is not."""
    rows, excludes = [], []
    for index in range(3):
        rows.append(joint("revolute", "base", f"arm_{index}", place=at(index, 0, 0)))
        rows.append(joint("fixed", f"arm_{index}", f"plate_{index}", place=at(0, 0, 1)))
        rows.append(joint("revolute", "base", f"rod_{index}", place=at(index, 1, 0)))
        excludes.append(Exclude(f"plate_{index}", f"rod_{index}", "User", 0.0))
    robot = robot_with(rows, shapes={link: (ball(0.1),) for link in ("base", *(row.child for row in rows))})
    outcome = exported(robot, solid(robot, self_contact=True, excludes=tuple(excludes)))
    assert outcome.written.mjcf_form.fused == ()
    contact = parse(outcome.files["robot.xml"]).find("contact")
    expected = [("exclude", f"plate_{index}") for index in range(3)]
    assert [(node.tag, node.get("body1")) for node in contact] == expected
