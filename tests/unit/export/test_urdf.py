"""URDF of each kind of joint and shape, and each option of `export.urdf`, as Pinocchio and MuJoCo read it."""

import math
from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from linkwright.stages.export.urdf.lowering import lower
from linkwright.stages.export.urdf.model import write_urdf
from linkwright.stages.export.urdf.section import UrdfFormatSection
from linkwright.stages.formats.urdf.form import UrdfForm
from linkwright.stages.formats.written import Written
from linkwright.stages.formats.xml import parse
from linkwright.stages.robot.dynamics.inertia import primitive_volume
from linkwright.stages.robot.dynamics.mass_matrix import mass_matrix
from linkwright.stages.robot.model.robot import Dynamics, Frame, Limits, Primitive, Relation, frozen
from linkwright.stages.robot.motion.kinematics import link_poses
from linkwright.stages.validate.dynamics.mujoco_features import reads_mimic
from linkwright.stages.validate.engines.mujoco_engine import load
from tests.support.building import NO_MESHES, plan_of, shaped, solid, write
from tests.support.checked import checked
from tests.support.engines import Mujoco, Pinocchio
from tests.support.exports import exported, failing, losses_of
from tests.support.kit import Kit
from tests.support.pinocchio import pin
from tests.support.robots import EVERY, LOOPS, at, joint, loop, pose, robot_around, robot_with, some_values
from tests.support.states import pose_of, state
from tests.unit.export.test_mjcf_fused import PLACES, arm

pytestmark = pytest.mark.usefixtures("no_score")

SEVERAL = {
    "cylindrical": ("slide", "turn"), "planar": ("x", "y", "turn"), "pin_slot": ("slide", "turn"),
    "parallel": ("x", "y", "z", "turn"), "ball": ("x", "y", "z"),
}  # fmt: skip


def urdf(robot, geometry=NO_MESHES, section=None):
    return write_urdf(Written(robot, geometry=geometry), *([section] if section else []))


def losses(robot):
    return losses_of(exported(robot, export={"urdf": {}}), "robot.urdf")


def by_mujoco(text, q):
    """The poses of all bodies, a ball as turns about x, y and z by scipy."""
    values = {}
    for name, value in q.items():
        if isinstance(value, tuple):
            angles = Rotation.from_quat(np.roll(value, -1)).as_euler("XYZ")
            values |= {f"{name}_{axis}": angle for axis, angle in zip("xyz", angles, strict=True)}
        else:
            values[name] = value
    model = mujoco.MjModel.from_xml_string(text.decode())
    data = state(model, **values)
    return {model.body(index).name: pose_of(data.body(index)) for index in range(model.nbody)}


@pytest.mark.parametrize("root", ["base", "world"])
@pytest.mark.parametrize("backwards", [False, True])
@pytest.mark.parametrize("kind", EVERY)
def test_links_are_where_the_robots_own_kinematics_have_them(kind, backwards, root):
    rng = np.random.default_rng(EVERY.index(kind))
    robot = robot_around(kind, rng, root, backwards)
    text = urdf(robot)
    for _ in range(5):
        q = some_values(robot, rng)
        expected = link_poses(robot, q)
        for poses in [Pinocchio(text).poses(q), *([] if kind == "free" else [by_mujoco(text, q)])]:
            assert max(np.abs(poses[name] - expected[name]).max() for name in expected) < 1e-12 * 8


@pytest.mark.parametrize("fixed", [True, False])
def test_mass_is_the_robots_and_links_between_weigh_nothing(fixed):
    rng = np.random.default_rng(3)
    rows = [joint(kind, "base", f"{kind}_link", place=pose(rng)) for kind in LOOPS]
    robot = robot_with(rows, fixed=fixed)
    made_up = [name for item in lower(robot) for name in item.added_links]
    assert len(made_up) == sum(len(names) - 1 for names in SEVERAL.values())
    total = sum(link.inertial.mass for link in robot.links)
    text = urdf(robot)
    model = mujoco.MjModel.from_xml_string(text.decode())
    assert model.body_mass.sum() == pytest.approx(total, abs=1e-10)
    for name in made_up:
        body = model.body(name)
        assert (body.mass[0], *body.inertia) == (1e-12,) * 4
    there = pin.buildModelFromXML(text.decode(), pin.JointModelFreeFlyer())
    assert pin.computeTotalMass(there) == pytest.approx(total, abs=1e-10)


@pytest.mark.parametrize(("kind", "suffixes"), SEVERAL.items())
def test_lowered_joints_are_reported_in_the_order_of_the_chain(kind, suffixes):
    message = losses(robot_with([joint(kind, "base", "arm")]))["I-URDF-LOWERED"]
    names = ", ".join(f"arm_joint_{suffix}" for suffix in suffixes)
    assert f"arm_joint ({kind}: {names})" in message
    if kind != "ball":
        (item,) = lower(robot_with([joint(kind, "base", "arm", backwards=True)]))
        assert [part.name for part in item.joints] == [f"arm_joint_{suffix}" for suffix in suffixes[::-1]]
        assert [part.child for part in item.joints] == [*item.added_links, "arm"]


def test_generated_names_are_unique():
    rows = [
        joint("ball", "base", "hip", name="hip"), joint("revolute", "base", "hip_1", name="hip_x"),
        joint("cylindrical", "base", "rod", name="rod"), joint("planar", "base", "puck", name="hip_1"),
    ]  # fmt: skip
    robot = robot_with(rows, frames=[Frame("hip_2", "base", frozen(np.eye(4)), "Hip")])
    ball, _, rod, puck = lower(robot)
    assert [part.name for part in ball.joints] == ["hip_x_2", "hip_y", "hip_z"]
    assert ball.added_links == ("hip_1_2", "hip_2_2")
    assert rod.added_links == ("rod_1",)
    assert puck.added_links == ("hip_1_1", "hip_1_2_2")
    root = parse(urdf(robot))
    for tag in ("link", "joint"):
        names = [node.get("name") for node in root.findall(tag)]
        assert len(set(names)) == len(names)
    assert "hip_2" in {node.get("name") for node in root.findall("link")}


def test_limits_and_dynamics_are_each_dofs_own():
    limits = {"arm_joint_x": Limits(-0.1, 0.2), "arm_joint_turn": Limits(None, 1.0)}
    dynamics = Dynamics(damping=0.5, effort=7, velocity=3)
    robot = robot_with([joint("planar", "base", "arm", limits=limits, dynamics=dynamics)])
    nodes = {node.get("name"): node for node in parse(urdf(robot)).findall("joint")}
    ends = {name: (n.find("limit").get("lower"), n.find("limit").get("upper")) for name, n in nodes.items()}
    assert ends["arm_joint_x"] == ("-0.1", "0.2")
    assert ends["arm_joint_y"] == ("-1", "1")
    assert float(ends["arm_joint_turn"][0]) == pytest.approx(-2 * math.pi)
    assert {node.find("limit").get("effort") for node in nodes.values()} == {"7"}
    assert {node.find("dynamics").get("damping") for node in nodes.values()} == {"0.5"}
    message = losses(robot)["I-URDF-UNSET"]
    assert message.endswith("arm_joint_y: lower, upper; arm_joint_turn: lower")


def test_losses_of_a_urdf_are_reported():
    cone = joint("ball", "base", "arm", limits={"arm_joint": Limits(None, 0.5)})
    lost = losses(robot_with([cone, joint("ball", "arm", "hand"), joint("free", "base", "nut")]))
    assert list(lost) == ["I-URDF-LOWERED", "W-BALL-CONE", "I-URDF-FREE", "I-URDF-UNSET"]
    assert lost["W-BALL-CONE"].endswith(": arm_joint")
    assert lost["I-URDF-FREE"].endswith(": nut_joint")
    assert lost["I-URDF-UNSET"].endswith("arm_joint: effort, velocity; hand_joint: effort, velocity")
    assert losses(robot_with([joint("fixed", "base", "arm")])) == {}


def test_relation_of_two_dofs_of_one_joint_is_a_mimic():
    relation = Relation("Screw", "nut_joint_slide", "nut_joint_turn", 0.002, 0.1)
    robot = robot_with([joint("cylindrical", "base", "nut")], relations=[relation])
    nodes = {node.get("name"): node for node in parse(urdf(robot)).findall("joint")}
    mimic = nodes["nut_joint_slide"].find("mimic")
    assert dict(mimic.attrib) == {"joint": "nut_joint_turn", "multiplier": "0.002", "offset": "0.1"}
    assert nodes["nut_joint_turn"].find("mimic") is None
    if reads_mimic():
        model = mujoco.MjModel.from_xml_string(urdf(robot).decode())
        assert np.allclose(model.eq_data[0][:2], [0.1, 0.002])


@pytest.mark.parametrize("kind", LOOPS)
def test_loop_of_any_type_is_a_frame_on_either_side(kind):
    rng = np.random.default_rng(6)
    near, far = pose(rng), pose(rng)
    rows = [
        joint(type_, "base", name, place=pose(rng))
        for type_, name in (("planar", "one"), ("revolute", "two"))
    ]
    robot = robot_with(rows, loops=[loop(kind, "one", "two", near, far, name="shut")])
    q = some_values(robot, rng)
    poses, links = Pinocchio(urdf(robot)).poses(q), link_poses(robot, q)
    assert np.abs(poses["shut_a"] - links["one"] @ near).max() < 1e-11
    assert np.abs(poses["shut_b"] - links["two"] @ far).max() < 1e-11
    assert "shut" in losses(robot)["I-URDF-LOOP"]


@pytest.mark.parametrize("frame_inertia", ["none", "tiny"])
def test_root_called_world_is_mujocos_world(frame_inertia):
    robot = robot_with([joint("revolute", "world", "arm", place=at(1, 2, 3))], root="world")
    text = urdf(robot, section=UrdfFormatSection(frame_inertia=frame_inertia))
    assert len(parse(text).find("link[@name='world']")) == 0
    model = mujoco.MjModel.from_xml_string(text.decode())
    assert [model.body(index).name for index in range(model.nbody)] == ["world", "arm"]


def test_free_body_of_the_world_is_where_it_rests():
    rng = np.random.default_rng(11)
    rows = [joint("free", "world", "nut", place=pose(rng)), joint("revolute", "nut", "arm", place=pose(rng))]
    robot = robot_with(rows, root="world")
    expected, actual = link_poses(robot), by_mujoco(urdf(robot), {"arm_joint": 0.0})
    assert max(np.abs(actual[name] - expected[name]).max() for name in ("nut", "arm")) < 1e-11


PLACE = pose(np.random.default_rng(8))
RED = (1.0, 0.0, 0.0, 1.0)
PRIMITIVES = {"box": (0.1, 0.2, 0.3), "sphere": (0.1,), "cylinder": (0.1, 0.4), "capsule": (0.1, 0.4)}


@pytest.mark.parametrize(("kind", "size"), PRIMITIVES.items())
def test_primitive_is_seen_and_collides_where_it_is(kind, size):
    shape = Primitive(kind, size, frozen(PLACE), RED)
    robot = robot_with([joint("revolute", "base", "arm")], shapes={"arm": (shape,)})
    text = urdf(robot, solid(robot))
    link = parse(text).find("link[@name='arm']")
    tags = {"capsule": ["cylinder", "sphere", "sphere"]}.get(kind, [kind])
    for role in ("visual", "collision"):
        assert [node[0].tag for node in link.findall(f"{role}/geometry")] == tags
    assert {node.get("name") for node in link.findall("visual/material")} == {"red"}
    assert not link.findall("collision/material")
    model = mujoco.MjModel.from_xml_string(text.decode())
    assert model.ngeom == 2 * len(tags)
    assert np.allclose(model.geom_rgba[model.geom_group == 1], RED)
    assert_fills(model, shape)
    # Geometry adds no mass.
    assert model.body("arm").mass[0] == pytest.approx(robot.link("arm").inertial.mass)
    visual = pin.buildGeomFromUrdfString(pin.buildModelFromXML(text.decode()), text.decode(), pin.VISUAL)
    assert visual.ngeoms == len(tags)


def assert_fills(model, shape):
    """MuJoCo's rays from outside meet the surface where the primitive has it."""
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    link = data.body("arm").xmat.reshape(3, 3)
    centre, turn = data.body("arm").xpos + link @ PLACE[:3, 3], link @ PLACE[:3, :3]
    for direction in np.random.default_rng(1).normal(size=(40, 3)):
        direction /= np.linalg.norm(direction)
        start = centre + turn @ direction * 2
        met = mujoco.mj_ray(model, data, start, -turn @ direction, None, 1, -1, np.zeros(1, dtype=np.int32))
        assert 2 - met == pytest.approx(radius_along(shape, direction), abs=1e-9)


def radius_along(shape, direction):
    """How far the surface is from the middle of the shape in a direction, in closed form."""
    if shape.kind == "box":
        return float(np.min(np.array(shape.size) / 2 / np.abs(direction)))
    radius, half = shape.size[0], (shape.size[1] / 2 if len(shape.size) > 1 else 0.0)
    across, along = math.hypot(*direction[:2]), abs(direction[2])
    side = radius / across
    if shape.kind == "cylinder":
        return min(side, half / along)
    if side * along <= half and shape.kind == "capsule":
        return side
    # On the ball about (0, 0, half): |t d − h| = r.
    return along * half + math.sqrt(radius**2 - half**2 * across**2)


def test_primitive_that_is_only_seen_does_not_collide():
    ghost = Primitive("box", (1.0, 1.0, 1.0), frozen(np.eye(4)), None, visual=True, collision=False)
    robot = robot_with([], shapes={"base": (ghost,)})
    link = parse(urdf(robot, solid(robot))).find("link")
    assert [node.tag for node in link] == ["inertial", "visual"]
    assert primitive_volume(ghost.kind, ghost.size) == 1


def with_meshes(**keys):
    """Two bars on a hinge, and their meshes."""
    kit = Kit()
    kit.elbow(value=0.3, limits=(0, 1))
    return shaped(kit.document, **keys)


def built(folder, **keys):
    """The URDF of two bars with meshes, checked by the validate stage."""
    robot, geometry, _ = with_meshes()
    return urdf_of(robot, geometry, folder, **keys).read_bytes()


@pytest.mark.parametrize("package", [None, "my-robot_2"])
def test_meshes_by_package_are_found_there_and_by_the_checks(package, tmp_path):
    folder = tmp_path / (package or "robot")
    text = built(folder, meshes="package", package=package)
    files = {node.get("filename") for node in parse(text).iter("mesh")}
    assert files
    assert all(file.startswith(f"package://{folder.name}/assets/") for file in files)
    model = pin.buildModelFromXML(text.decode())
    visual = pin.buildGeomFromUrdfString(model, text.decode(), pin.VISUAL, package_dirs=[str(tmp_path)])
    paths = {Path(shape.meshPath) for shape in visual.geometryObjects}
    assert paths <= set((folder / "assets").iterdir())
    assert visual.ngeoms == 2


def test_mesh_missing_from_the_package_fails_the_check(tmp_path):
    text = built(tmp_path, meshes="package")
    (tmp_path / "robot.urdf").write_bytes(text.replace(b"assets/arm", b"assets/nothing"))
    checks = checked(tmp_path, robot_with([]), plan_of(validate__level="quick"))
    assert [check.name for check in checks if check.fails] == ["robot.urdf: paths", "robot.urdf: compiles"]


@pytest.mark.parametrize("meshes", ["relative", "package"])
def test_meshes_that_mujoco_compiles_are_the_same(meshes, tmp_path):
    built(tmp_path, meshes=meshes)
    model = load(tmp_path / "robot.urdf").model
    assert (model.nmesh, model.ngeom) == (4, 4)


def test_inertial_of_frames_is_left_out_or_tiny():
    rng = np.random.default_rng(2)
    frames = [Frame(name, "arm", frozen(pose(rng)), name) for name in ("tool", "camera")]
    robot = robot_with([joint("revolute", "base", "arm", place=pose(rng))], frames=frames)
    texts = [write_urdf(Written(robot), UrdfFormatSection(frame_inertia=kind)) for kind in ("none", "tiny")]
    for text, expected in zip(texts, ([], ["tool", "camera"]), strict=True):
        links = parse(text).findall("link")
        assert [link.get("name") for link in links if link.find("inertial") is not None][2:] == expected
    light, heavy = (mujoco.MjModel.from_xml_string(text.decode()) for text in texts)
    assert (heavy.body("tool").mass[0], tuple(heavy.body("tool").inertia)) == (1e-12, (1e-12,) * 3)
    assert light.body("tool").mass[0] == 0
    weights = [pin.computeTotalMass(pin.buildModelFromXML(text.decode())) for text in texts]
    assert weights[1] - weights[0] == pytest.approx(2e-12, rel=1e-2)


def urdf_of(robot, geometry, folder, **keys):
    """The URDF in a folder of its own, checked by the validate stage."""
    plan = plan_of(export={"urdf": keys})
    assert failing(folder, write(robot, folder, plan, geometry), plan) == []
    return folder / "robot.urdf"


def test_merged_links_move_weigh_and_stand_as_they_did(tmp_path):
    robot, geometry = arm()
    kept = urdf_of(robot, geometry, tmp_path / "keep", fixed_joints="keep")
    merged = urdf_of(robot, geometry, tmp_path / "merge", fixed_joints="merge")
    tree = parse(merged.read_bytes())
    assert [link.get("name") for link in tree.findall("link")] == ["base", "arm", "hand", "tool"]
    dofs = [dof.name for dof in robot.dofs]
    engines = [(Pinocchio(kept.read_bytes()), Pinocchio(merged.read_bytes())), (Mujoco(kept), Mujoco(merged))]
    rng = np.random.default_rng(7)
    # MuJoCo 3.3.3 diagonalises the inertia of the merged link with an error of 2.5e-9.
    old_mujoco = tuple(map(int, mujoco.__version__.split(".")[:2])) < (3, 4)
    for (before, after), error in zip(engines, (1e-9, 1e-8 if old_mujoco else 1e-9), strict=True):
        for _ in range(5):
            q = some_values(robot, rng)
            old, new = before.poses(q), after.poses(q)
            own = link_poses(robot, q)
            own["tool"] = own["tip"] @ PLACES[5]
            for name in ("arm", "hand", "tool"):
                assert np.abs(new[name] - old[name]).max() < 1e-9
                assert np.abs(new[name] - own[name]).max() < 1e-9
            inertia = after.mass_matrix(q, dofs)
            assert np.abs(inertia - before.mass_matrix(q, dofs)).max() < error
            assert np.abs(inertia - mass_matrix(robot, q)).max() < error
            assert np.abs(after.gravity(q, dofs) - before.gravity(q, dofs)).max() < 1e-9
    places = [np.array(sorted(engine.data.geom_xpos.tolist())) for engine in engines[1]]
    assert len(places[0]) == 10
    assert np.abs(places[0] - places[1]).max() < 1e-9
    total = sum(link.inertial.mass for link in robot.links)
    assert engines[1][1].model.body_mass.sum() == pytest.approx(total, abs=1e-9)
    free = pin.buildModelFromXML(merged.read_text(), pin.JointModelFreeFlyer())
    assert (pin.computeTotalMass(free), free.nbodies) == (pytest.approx(total, abs=1e-9), 1 + 3)


def test_mesh_of_a_merged_link_is_where_it_was(tmp_path):
    robot, geometry, _ = with_meshes()
    held = replace(robot.joints[0], type="fixed", dofs=())  # as a URDF source has it
    robot = replace(robot, joints=(held,))
    (tmp_path / "assets").mkdir()
    for name, data in geometry.files.items():
        (tmp_path / "assets" / name).write_bytes(data)
    places = []
    for is_merged in (False, True):
        form = UrdfForm(merged=is_merged)
        text = write_urdf(Written(robot, geometry=geometry, urdf_form=form)).decode()
        model = pin.buildModelFromXML(text)
        shapes = pin.buildGeomFromUrdfString(model, text, pin.VISUAL, package_dirs=[str(tmp_path)])
        places.append({shape.meshPath: shape.placement.homogeneous for shape in shapes.geometryObjects})
    assert places[0].keys() == places[1].keys()
    assert max(np.abs(places[0][key] - places[1][key]).max() for key in places[0]) < 1e-12
    assert max(np.abs(place - np.eye(4)).max() for place in places[1].values()) > 0.01


def test_link_fixed_to_a_root_called_world_keeps_its_mass(tmp_path):
    robot, geometry = arm("world")
    merged = urdf_of(robot, geometry, tmp_path, fixed_joints="merge")
    names = [link.get("name") for link in parse(merged.read_bytes()).findall("link")]
    assert names == ["world", "arm", "hand", "mast", "tool"]
    total = sum(link.inertial.mass for link in robot.links)
    assert Mujoco(merged).model.body_mass.sum() == pytest.approx(total, abs=1e-9)


def test_controls_of_a_merged_joint_are_left_out():
    joints = '<joint name="plate_joint"/><joint name="arm_joint"/>'
    text = f'<ros2_control name="c" type="system">{joints}</ros2_control>'
    robot = replace(arm()[0], controls=(text,))
    tree = parse(write_urdf(Written(robot, geometry=NO_MESHES, urdf_form=UrdfForm(merged=True))))
    assert [node.get("name") for node in tree.findall("ros2_control/joint")] == ["arm_joint"]
