"""The validate stage finds what is wrong: every fault planted in a good build fails a check."""

import re
import shutil

import mujoco
import numpy as np
import pytest

from linkwright.stages.formats.urdf.urdf_robot import urdf_form
from linkwright.stages.mesh import make_geometry
from linkwright.stages.robot.model.poses import inverse, turns_from_rotation
from linkwright.stages.robot.model.poses import turn as turned
from linkwright.stages.robot.model.robot import Frame, Limits, Relation
from linkwright.stages.robot.motion.kinematics import chain, link_poses, saved_configuration
from linkwright.stages.validate import validate
from linkwright.stages.validate.checks import MODEL_CHECKS
from linkwright.stages.validate.dynamics import mujoco_features
from linkwright.stages.validate.model.coordinates import distance
from linkwright.stages.validate.same import motion
from tests.fake_onshape.document import Occurrence
from tests.fake_onshape.frames import turn
from tests.support import robots
from tests.support.building import bundle_of, plan_of, robot_of, write
from tests.support.checked import checked
from tests.support.faults import mjcf, mjcf_world, urdf
from tests.support.faults.checks import ANY_JOINT
from tests.support.faults.fault import catches, plant
from tests.support.kit import SIDE, TOP, Kit, four_bar
from tests.support.places import PROJECT

pytestmark = pytest.mark.usefixtures("no_score")

ABSENT = {
    "urdf: collider resized", "urdf: inertia's off-diagonal sign", "mjcf: collider resized",
    "mjcf: mesh of another part", "mjcf: axes of inertia turned the other way", "mjcf: actuator removed",
    "mjcf: actuator on another joint", "mjcf: gear's sign", "mjcf: servo without stiffness",
    "mjcf: range of control", "mjcf: range of force", "mjcf: control of the keyframe",
    "mjcf: sensor removed", "mjcf: sensor on another place", "mjcf: freejoint removed",
    "mjcf: free base 5 cm up at home", "mjcf: free base turned at home", "mjcf: exclude removed",
    "mjcf: exclude added",
}  # fmt: skip
"""Faults for which the robot of this test has no place: slow tests plant them in others."""


@pytest.fixture(scope="module")
def good(tmp_path_factory):
    """A robot with hinges, a slider, a loop, a gear and a frame, all saved at zero or not."""
    kit = Kit()
    four_bar(kit)
    ground = Occurrence([kit.root.instances[0]])
    cart, wheel, idler = kit.place("Cart"), kit.place("Wheel"), kit.place("Idler")
    kit.root.slider("Rail", (cart, TOP), (ground, SIDE), limits=(-0.1, 0.2))
    first = kit.root.revolute("Spin", (wheel, TOP), (ground, TOP), limits=(-3, 3))
    second = kit.root.revolute("Idle", (idler, TOP), (ground, turn((1, 0, 0), 1)), limits=(-3, 3))
    kit.root.gear("Gear", first, second, 1.5)
    kit.root.connector("Tool", cart, SIDE)
    resists = {"damping": 0.25, "friction": 0.125, "armature": 0.0625}
    plan = plan_of(joints={"*": {"effort": 5, "velocity": 2, **resists}})
    robot = robot_of(kit.document, plan)
    geometry = make_geometry(robot, bundle_of(kit.document), plan, lambda kind, key, make: make())
    folder = tmp_path_factory.mktemp("good")
    return robot, folder, write(robot, folder, plan, geometry).written


@pytest.fixture
def copy(good, tmp_path):
    return good[0], shutil.copytree(good[1], tmp_path / "copy")


def only_compared(monkeypatch):
    """Leaves the checks that compare with the robot: a simulation takes seconds."""
    compared = [check for check in MODEL_CHECKS if "simulated" not in check.files]
    monkeypatch.setattr("linkwright.stages.validate.checks.MODEL_CHECKS", compared)


def test_good_build_passes_every_check(good):
    robot, folder, _ = good
    checks = checked(folder, robot, plan_of())
    assert len(checks) > 30
    assert [check.name for check in checks if check.fails] == []


PLANTED = [*urdf.FAULTS, *mjcf.BODIES, *mjcf_world.FAULTS, *mjcf.SHAPES]


@pytest.mark.parametrize(
    "fault", [fault for fault in PLANTED if fault.title not in ABSENT], ids=lambda fault: fault.title
)
def test_planted_fault_is_found_and_named(fault, good, tmp_path, monkeypatch):
    if fault.title == "urdf: inertia zero" and mujoco.__version__ < "3.4":
        pytest.skip("this MuJoCo does not say which link it refuses")
    _, folder, written = good
    only_compared(monkeypatch)
    planted = plant(fault, folder, "robot", tmp_path / "bad", seed=5)
    checks = validate(tmp_path / "bad", written, plan_of())
    assert catches(fault, planted, checks), (planted, [check for check in checks if not check.passed])


def failed_of(robot, folder):
    return [check.name for check in checked(folder, robot, plan_of()) if check.fails]


def test_a_part_without_a_pose_is_not_hidden_by_the_next(copy, monkeypatch):
    missing = iter([np.full((4, 4), np.nan)])
    monkeypatch.setattr(motion, "distance", lambda actual, goal: distance(next(missing, actual), goal))
    assert [name for name in failed_of(*copy) if name.endswith("poses")] == ["robot.xml: poses"]


def test_limits_of_a_urdf_joint_that_has_none_are_found(tmp_path, monkeypatch):
    only_compared(monkeypatch)
    plan = plan_of(export={"urdf": {}})
    written = write(robots.robot_with([robots.joint("revolute", "base", "arm")]), tmp_path, plan).written
    path = tmp_path / "robot.urdf"
    text = path.read_text().replace('type="continuous"', 'type="revolute"')
    path.write_text(text.replace("<limit ", '<limit lower="-1" upper="1" '))
    failed = [check.name for check in validate(tmp_path, written, plan) if check.fails]
    assert failed == ["robot.urdf: joints"]


def test_what_this_mujoco_can_do_is_found_out():
    version = tuple(int(part) for part in mujoco.__version__.split(".")[:2])
    assert mujoco_features.reads_mimic() == (version >= (3, 13))
    assert [mujoco_features.principal_axes_error(size) == 0 for size in (10.0, 1e-4, 1e-9)] == [
        version >= (3, 14)
    ] * 3


def test_relations_are_read_from_text_where_mujoco_reads_none(copy, monkeypatch):
    robot, folder = copy
    file = folder / "robot.urdf"
    text = file.read_text()
    monkeypatch.setattr(mujoco_features, "reads_mimic", lambda: False)
    assert failed_of(robot, folder) == []
    for change in ((r"<mimic [^>]*/>", ""), ('multiplier="-1.5"', 'multiplier="1.5"')):
        file.write_text(re.sub(*change, text))
        assert failed_of(robot, folder) == ["robot.urdf: relations"]


def test_inertia_is_judged_as_finely_as_mujoco_finds_axes(copy, monkeypatch):
    robot, folder = copy
    for name in ("robot.urdf", "robot.xml"):
        file = folder / name
        change = r'(ixx=")([^"]+)' if name == "robot.urdf" else r'(diaginertia=")([^ ]+)'
        nearly = re.sub(change, lambda m: f"{m[1]}{float(m[2]) * (1 + 5e-7):.16g}", file.read_text(), count=1)
        file.write_text(nearly)
    exact = ["robot.xml: inertia"]
    if not mujoco_features.principal_axes_error(1e-4):
        assert failed_of(robot, folder) == [*exact, "robot.urdf: inertia"]
    monkeypatch.setattr(mujoco_features, "principal_axes_error", lambda size: 1e-6)
    assert failed_of(robot, folder) == exact


def test_how_finely_mujoco_finds_axes_is_measured(monkeypatch):
    true_axes = mujoco.mju_eig3

    def coarse(values, vectors, quat, tensor):
        true_axes(values, vectors, quat, tensor)
        values[:] *= 1 + 1e-5

    monkeypatch.setattr(mujoco, "mju_eig3", coarse)
    assert 1e-5 < mujoco_features._largest_error.__wrapped__(-4) < 1e-3


def test_quick_only_reads_and_compiles(good):
    robot, folder, _ = good
    checks = checked(folder, robot, plan_of(validate={"level": "quick"}))
    assert [check.name for check in checks if check.code == "C-COMPILE"] == [
        "robot.xml: compiles",
        "scene.xml: compiles",
        "robot.urdf: compiles",
    ]
    of_text = {"C-XML", "C-XML-KNOWN", "C-NAME", "C-NUMBER", "C-REFERENCE", "C-ASSET", "C-PATH"}
    assert {check.code for check in checks} == {"C-COMPILE", "C-ASSET-UNUSED", *of_text}


def every_kind(root="base", fixed=True):
    """All types of joints in a row and of loops beside them, at odd places, saved off zero, with an
    inertial of the user's own and a root frame that is not the assembly's origin."""
    rng = np.random.default_rng(11)
    joints, above = [], root
    for kind in ("revolute", "cylindrical", "ball", "planar", "pin_slot", "parallel", "fixed"):
        values = [robots.some_value(freedom, rng) for _, freedom, _ in robots.CHAINS[kind]]
        mate = {
            "limits": {f"{kind}_joint_slide": Limits(-2, 2)},
            "backwards": kind in ("cylindrical", "ball"),
        }
        mate |= {"origins": [robots.pose(rng) for _ in values[1:]], "place": robots.pose(rng)}
        joints.append(robots.joint(kind, above, kind, values, **mate))
        above = kind
    loose = robots.some_value("free", rng)
    joints.append(robots.joint("free", root, "loose", [loose], place=robots.pose(rng)))
    bare = robots.robot_with(joints, root=root)
    poses = link_poses(bare, saved_configuration(bare))
    loops = []
    for kind in robots.LOOPS:
        # From the loose body to the chain: whatever the mate, it is met at the saved pose.
        values = [robots.some_value(freedom, rng, 0.4) for _, freedom, _ in robots.CHAINS[kind]]
        dofs = robots.dofs_of(f"{kind}_loop", kind, values)
        own = chain(dofs, {dof.name: dof.saved for dof in dofs})
        near = robots.pose(rng)
        far = inverse(poses["loose"]) @ poses["planar"] @ near @ own
        loops.append(robots.loop(kind, "loose", "planar", far, near, values, name=f"{kind}_loop"))
    first, second = joints[0].dofs[0], joints[1].dofs[0]
    return robots.robot_with(
        joints,
        loops=loops,
        relations=[Relation("tie", second.name, first.name, 0.3, second.saved - 0.3 * first.saved)],
        frames=[Frame(n, link, robots.pose(rng), n) for n, link in (("tip", "parallel"), ("foot", root))],
        root=root,
        fixed=fixed,
        world_from_root=None if root == "world" else robots.pose(rng),
        given={"planar": robots.solid(3.0, (0.1, 0.0, 0.0))},
    )


PLACED = {"pose": {"xyz": [1, 2, 3], "rpy": [0.1, 0.2, 0.3]}}


@pytest.mark.slow
@pytest.mark.parametrize(("root", "fixed"), [("base", True), ("base", False), ("world", True)])
def test_every_type_of_joint_and_loop_passes_every_check(root, fixed, tmp_path):
    robot = every_kind(root, fixed)
    write(robot, tmp_path, plan_of(scene=PLACED))
    checks = checked(tmp_path, robot, plan_of())
    assert [check for check in checks if check.fails] == []
    files = {check.name.split(":")[0] for check in checks}
    assert files == {"robot.xml", "scene.xml", "robot.urdf", "robot.srdf"}


@pytest.fixture(scope="module")
def every(tmp_path_factory):
    """With the form of its URDF, which takes seconds to find."""
    folder = tmp_path_factory.mktemp("every")
    robot = every_kind()
    write(robot, folder, plan_of(scene=PLACED))
    return robot, folder, urdf_form(robot)


def test_extremes_of_a_ball_are_three_turns():
    """Also where the middle turn is a right angle, and the other two are one."""
    x, y, z = np.eye(3)
    for angles in ((0.3, -1.1, 2.0), (0.3, np.pi / 2, 0.4), (-2.0, -np.pi / 2, 3.0), (0.0, 0.0, 0.0)):
        rotation = turned(x, angles[0]) @ turned(y, angles[1]) @ turned(z, angles[2])
        again = turns_from_rotation(rotation)
        back = turned(x, again[0]) @ turned(y, again[1]) @ turned(z, again[2])
        assert np.abs(back - rotation).max() < 1e-12


@pytest.mark.parametrize("fault", ANY_JOINT, ids=lambda fault: fault.kind)
def test_fault_in_any_kind_of_joint_or_loop_fails_a_check(every, tmp_path, fault, monkeypatch):
    only_compared(monkeypatch)
    robot, folder, form = every
    bad = shutil.copytree(folder, tmp_path / "bad")
    fault.change(bad, "robot")
    checks = checked(bad, robot, plan_of(), urdf_form=form)
    assert any(check.fails and check.name.startswith(fault.expects) for check in checks)


def test_module_of_a_check_is_a_row_of_the_table():
    room = PROJECT / "stages/validate/checks"
    modules = [file.stem for file in room.rglob("*.py") if file.name != "__init__.py"]
    assert sorted(check.title.replace(" ", "_") for check in MODEL_CHECKS) == sorted(modules)


def test_model_without_one_of_the_joints_is_checked_no_further(copy):
    robot, folder = copy
    file = folder / "robot.urdf"
    file.write_text(file.read_text().replace('name="rail"', 'name="rial"'))
    every = [check for check in checked(folder, robot, plan_of()) if "urdf" in check.name]
    checks = every[[check.code for check in every].index("C-COMPILE") :]
    assert [(check.name.split(": ")[1], check.passed) for check in checks] == [
        ("compiles", True),
        ("links and joints", False),
        ("runs", True),
    ]
    assert checks[1].detail == "missing: rail"
