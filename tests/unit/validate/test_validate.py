"""The validate stage finds what is wrong: every fault planted in a good build fails a check."""

import re
import shutil
from collections.abc import Callable
from pathlib import Path

import mujoco
import numpy as np
import pytest

from linkwright.stages.formats.urdf.as_written import form_with
from linkwright.stages.formats.urdf.form import UrdfForm
from linkwright.stages.mesh import make_geometry
from linkwright.stages.robot.model.poses import inverse, turns_from_rotation
from linkwright.stages.robot.model.poses import turn as turned
from linkwright.stages.robot.model.robot import Frame, Limits, Relation, Robot
from linkwright.stages.robot.motion.kinematics import chain, link_poses, saved_configuration
from linkwright.stages.validate.checks import MODEL_CHECKS
from linkwright.stages.validate.dynamics import mujoco_abilities as ability
from tests.fake_onshape.frames import turn
from tests.support import robots
from tests.support.building import bundle_of, plan_of, robot_of, write
from tests.support.checked import checked
from tests.support.kit import SIDE, TOP, Kit, four_bar
from tests.support.places import PROJECT

pytestmark = pytest.mark.usefixtures("no_score")


@pytest.fixture(scope="module")
def good(tmp_path_factory: pytest.TempPathFactory) -> tuple[Robot, Path]:
    """A robot with hinges, a slider, a loop, a gear and a frame, all saved at zero or not."""
    kit = Kit()
    four_bar(kit)
    base = kit.root.instances[0]
    from tests.fake_onshape.document import Occurrence

    ground = Occurrence([base])
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
    write(robot, folder, plan, geometry)
    return robot, folder


def test_the_good_build_passes_every_check(good: tuple[Robot, Path]) -> None:
    robot, folder = good
    checks = checked(folder, robot, plan_of())
    assert len(checks) > 30
    assert [check.name for check in checks if check.fails] == []


def drop(pattern: str) -> Callable[[str], str]:
    return lambda text: re.sub(pattern, "", text, flags=re.DOTALL)


def swap(old: str, new: str) -> Callable[[str], str]:
    return lambda text: text.replace(old, new, 1)


def joint_with(name, attribute):
    """Gives a joint of an MJCF this attribute, in place of its own or its class's."""
    key = attribute.partition("=")[0]

    def change(text):
        (old,) = re.findall(rf'<joint name="{name}"[^>]*>', text)
        return text.replace(old, re.sub(rf' {key}="[^"]*"', "", old).replace("/>", f" {attribute}/>"))

    return change


FAULTS = {
    "no equalities": ("robot.xml", drop(r"<equality>.*</equality>")),
    "no connects": ("robot.xml", drop(r"<connect [^>]*/>")),
    "one connect less": ("robot.xml", lambda text: re.sub(r"<connect [^>]*/>", "", text, count=1)),
    "gear turned round": ("robot.xml", swap("-1.5 0 0 0", "1.5 0 0 0")),
    "a range changed": ("robot.xml", swap('range="-0.1 0.2"', 'range="-0.1 0.3"')),
    "a range dropped": ("robot.xml", drop(r' range="-0.1 0.2"')),
    "effort changed": ("robot.xml", swap('actuatorfrcrange="-5 5"', 'actuatorfrcrange="-6 6"')),
    "damping changed": ("robot.xml", swap('damping="0.25"', 'damping="0.5"')),
    "friction dropped": ("robot.xml", swap(' frictionloss="0.125"', "")),
    "armature changed": ("robot.xml", swap('armature="0.0625"', 'armature="0.5"')),
    "damping changed in urdf": ("robot.urdf", swap('damping="0.25"', 'damping="0.5"')),
    "home changed": ("robot.xml", lambda text: re.sub(r'(name="home" qpos=")[^ ]+', r"\g<1>0.123", text)),
    "no keyframes": ("robot.xml", drop(r"<keyframe>.*</keyframe>")),
    "the saved pose changed": (
        "robot.xml",
        lambda text: re.sub(r'(name="cad" qpos=")[^ ]+', r"\g<1>0.123", text),
    ),
    "a site moved": ("robot.xml", lambda text: re.sub(r'(<site name="tool" pos=")[^ ]+', r"\g<1>9", text)),
    "a body moved": ("robot.xml", lambda text: re.sub(r'(<body name="cart" pos=")[^ ]+', r"\g<1>9", text)),
    "an axis flipped": (
        "robot.xml",
        joint_with("spin", 'axis="0 0 -1"'),
    ),
    "another axis": (
        "robot.xml",
        joint_with("spin", 'axis="1 0 0"'),
    ),
    "a hinge for a slide": ("robot.xml", swap('type="slide"', 'type="hinge"')),
    "a mass changed": ("robot.xml", lambda text: re.sub(r'mass="0.06"', 'mass="0.061"', text, count=1)),
    "an inertia changed": (
        "robot.xml",
        lambda text: re.sub(r'diaginertia="[^ ]+', 'diaginertia="5.1e-5', text, count=1),
    ),
    "a joint more": (
        "robot.xml",
        swap('<joint name="rail"', '<joint name="more" type="slide"/><joint name="rail"'),
    ),
    "a joint renamed": ("robot.xml", swap('name="rail"', 'name="rial"')),
    "no xml": ("robot.xml", swap("</mujoco>", "")),
    "mimic dropped": ("robot.urdf", drop(r"<mimic [^>]*/>")),
    "mimic turned round": ("robot.urdf", swap('multiplier="-1.5"', 'multiplier="1.5"')),
    "a limit changed": ("robot.urdf", swap('upper="0.2"', 'upper="0.3"')),
    "an axis flipped in urdf": ("robot.urdf", swap('<axis xyz="0 0 1"/>', '<axis xyz="0 0 -1"/>')),
    "an origin moved": (
        "robot.urdf",
        lambda text: re.sub(r'(<joint name="rail".*?<origin xyz=")[^ ]+', r"\g<1>9", text, flags=re.DOTALL),
    ),
    "a mass changed in urdf": ("robot.urdf", swap('<mass value="0.06"/>', '<mass value="0.07"/>')),
    "a mesh lost": ("robot.urdf", swap("assets/base.stl", "assets/nothing.stl")),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_a_planted_fault_fails_a_check(good: tuple[Robot, Path], tmp_path: Path, fault: str) -> None:
    robot, folder = good
    shutil.copytree(folder, tmp_path / "bad")
    file, change = FAULTS[fault]
    before = (folder / file).read_text()
    after = change(before)
    assert after != before
    (tmp_path / "bad" / file).write_text(after)
    assert any(name.startswith(file) for name in failed_of(robot, tmp_path / "bad"))


def failed_of(robot: Robot, folder: Path) -> list[str]:
    return [check.name for check in checked(folder, robot, plan_of()) if check.fails]


def test_what_this_mujoco_can_do_is_found_out() -> None:
    version = tuple(int(part) for part in mujoco.__version__.split(".")[:2])
    assert ability.reads_mimic() == (version >= (3, 13))
    assert [ability.axes_error(size) == 0 for size in (10.0, 1e-4, 1e-9)] == [version >= (3, 14)] * 3


def test_relations_of_a_urdf_are_read_from_its_text_where_mujoco_reads_none(
    good: tuple[Robot, Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    robot, folder = good
    shutil.copytree(folder, tmp_path / "old")
    file = tmp_path / "old" / "robot.urdf"
    text = file.read_text()
    monkeypatch.setattr("linkwright.stages.validate.read.urdf.reads_mimic", lambda: False)
    assert failed_of(robot, tmp_path / "old") == []
    for fault in ("mimic dropped", "mimic turned round"):
        file.write_text(FAULTS[fault][1](text))
        assert failed_of(robot, tmp_path / "old") == ["robot.urdf: relations"]


def test_an_inertia_of_a_urdf_is_judged_as_finely_as_mujoco_finds_axes(
    good: tuple[Robot, Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    robot, folder = good
    shutil.copytree(folder, tmp_path / "off")
    for name in ("robot.urdf", "robot.xml"):
        file = tmp_path / "off" / name
        change = r'(ixx=")([^"]+)' if name == "robot.urdf" else r'(diaginertia=")([^ ]+)'
        nearly = re.sub(change, lambda m: f"{m[1]}{float(m[2]) * (1 + 5e-7):.16g}", file.read_text(), count=1)
        file.write_text(nearly)
    exact = ["robot.xml: inertia"]
    if not ability.axes_error(1e-4):
        assert failed_of(robot, tmp_path / "off") == [*exact, "robot.urdf: inertia"]
    monkeypatch.setattr("linkwright.stages.validate.read.urdf.axes_error", lambda size: 1e-6)
    assert failed_of(robot, tmp_path / "off") == exact


def test_how_finely_mujoco_finds_axes_is_measured(monkeypatch: pytest.MonkeyPatch) -> None:
    true_axes = mujoco.mju_eig3

    def coarse(values: np.ndarray, vectors: np.ndarray, quat: np.ndarray, tensor: np.ndarray) -> None:
        true_axes(values, vectors, quat, tensor)
        values[:] *= 1 + 1e-5

    monkeypatch.setattr(mujoco, "mju_eig3", coarse)
    assert 1e-5 < ability._largest_error.__wrapped__(-4) < 1e-3


def test_quick_only_reads_and_compiles(good: tuple[Robot, Path]) -> None:
    robot, folder = good
    checks = checked(folder, robot, plan_of(validate={"level": "quick"}))
    assert [check.name for check in checks if check.code == "C-COMPILE"] == [
        "robot.xml: compiles",
        "scene.xml: compiles",
        "robot.urdf: compiles",
    ]
    of_text = {"C-XML", "C-XML-KNOWN", "C-NAME", "C-NUMBER", "C-REFERENCE", "C-ASSET", "C-PATH"}
    assert {check.code for check in checks} == {"C-COMPILE", "C-ASSET-UNUSED", *of_text}


def every_kind(root: str = "base", fixed: bool = True) -> Robot:
    """All types of joints in a row and of loops beside them, at odd places, saved off zero, with an
    inertial of the user's own and a root frame that is not the assembly's origin."""
    rng = np.random.default_rng(11)
    joints, above = [], root
    for kind in ("revolute", "cylindrical", "ball", "planar", "pin_slot", "parallel", "fixed"):
        values = [robots.some_value(what, rng) for _, what, _ in robots.CHAINS[kind]]
        limits = {f"{kind}_joint_slide": Limits(-2, 2)}
        origins = [robots.pose(rng) for _ in values[1:]]
        joints.append(
            robots.joint(
                kind,
                above,
                kind,
                values,
                place=robots.pose(rng),
                backwards=kind in ("cylindrical", "ball"),
                limits=limits,
                origins=origins,
            )
        )
        above = kind
    loose = robots.some_value("free", rng)
    joints.append(robots.joint("free", root, "loose", [loose], place=robots.pose(rng)))
    bare = robots.robot_with(joints, root=root)
    poses = link_poses(bare, saved_configuration(bare))
    loops = []
    for kind in robots.LOOPS:
        # From the loose body to the chain: whatever the mate, it is met at the saved pose.
        values = [robots.some_value(what, rng, 0.4) for _, what, _ in robots.CHAINS[kind]]
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
        frames=[
            Frame("tip", "parallel", robots.pose(rng), "Tip"),
            Frame("foot", root, robots.pose(rng), "Foot"),
        ],
        root=root,
        fixed=fixed,
        world_from_root=None if root == "world" else robots.pose(rng),
        given={"planar": robots.solid(3.0, (0.1, 0.0, 0.0))},
    )


PLACED = {"pose": {"xyz": [1, 2, 3], "rpy": [0.1, 0.2, 0.3]}}


@pytest.mark.slow
@pytest.mark.parametrize(("root", "fixed"), [("base", True), ("base", False), ("world", True)])
def test_every_type_of_joint_and_loop_passes_every_check(root: str, fixed: bool, tmp_path: Path) -> None:
    robot = every_kind(root, fixed)
    write(robot, tmp_path, plan_of(scene=PLACED))
    checks = checked(tmp_path, robot, plan_of())
    assert [check for check in checks if check.fails] == []
    files = {check.name.split(":")[0] for check in checks}
    assert files == {"robot.xml", "scene.xml", "robot.urdf", "robot.srdf"}


@pytest.fixture(scope="module")
def every(tmp_path_factory: pytest.TempPathFactory) -> tuple[Robot, Path, UrdfForm]:
    """With the form of its URDF, which takes seconds to find."""
    folder = tmp_path_factory.mktemp("every")
    robot = every_kind()
    write(robot, folder, plan_of(scene=PLACED))
    return robot, folder, form_with(robot)


def first_number(pattern: str, value: str = "0.111") -> Callable[[str], str]:
    """Another first number in the attribute that `pattern` ends in."""
    return lambda text: re.sub(f'({pattern}=")[^ "]+', rf"\g<1>{value}", text, count=1, flags=re.DOTALL)


def carrier(text: str) -> str:
    """The text without the inertial of the first carrier, but for a trace of it."""
    pattern = r'(<body name="planar_loop_carrier".*?<inertial [^>]*?mass=")[^"]+'
    return re.sub(pattern, r"\g<1>0.001", text, count=1, flags=re.DOTALL)


MORE_FAULTS = {
    "the axis of a slide of a planar": (
        "robot.xml",
        first_number(r'name="planar_joint_x"[^>]*? axis', "0.9"),
    ),
    "a joint's place in its body": (
        "robot.xml",
        first_number(r'name="cylindrical_joint_turn"[^>]*? pos', "9"),
    ),
    "a range of a slide": ("robot.xml", first_number(r'name="cylindrical_joint_slide"[^>]*? range', "-1")),
    "a joint's ref": ("robot.xml", first_number(r'name="pin_slot_joint_slide"[^>]*? ref', "0.9")),
    "a ball's body turned": ("robot.xml", first_number(r'<body name="ball"[^>]*? quat', "0.1")),
    "a ball for a hinge": (
        "robot.xml",
        joint_with("revolute_joint", 'type="ball"'),
    ),
    "two joints swapped": (
        "robot.xml",
        lambda text: re.sub(
            r'(<joint name="planar_joint_y"[^>]*/>)(\s*)(<joint name="planar_joint_turn"[^>]*/>)',
            r"\3\2\1",
            text,
        ),
    ),
    "the loose body moved": ("robot.xml", first_number(r'<body name="loose"[^>]*? pos', "9")),
    "a weld lost": ("robot.xml", drop(r'<weld name="planar_loop" [^>]*/>')),
    "the rigid weld lost": ("robot.xml", drop(r'<weld name="fixed_loop" [^>]*/>')),
    "the ball's connect lost": ("robot.xml", drop(r'<connect name="ball_loop" [^>]*/>')),
    "a carrier's site moved": ("robot.xml", first_number(r'<site name="planar_loop_a"[^>]*? pos', "9")),
    "a carrier's inertia lost": ("robot.xml", carrier),
    "a carrier moved": ("robot.xml", first_number(r'<body name="pin_slot_loop_carrier"[^>]*? pos', "9")),
    "a carrier's dof lost": ("robot.xml", drop(r'<joint name="parallel_loop_z" [^>]*/>')),
    "a carrier's dof turned round": (
        "robot.xml",
        first_number(r'<joint name="prismatic_loop" [^>]*? axis', "0.9"),
    ),
    "the user's mass": ("robot.urdf", swap('<mass value="3"/>', '<mass value="2"/>')),
    "a lowered dof lost its place": (
        "robot.urdf",
        first_number(r'<joint name="parallel_joint_z".*?<origin xyz', "9"),
    ),
    "a turn of a ball": ("robot.urdf", first_number(r'<joint name="ball_joint_y".*?<axis xyz', "1")),
    "a floating joint moved": ("robot.urdf", first_number(r'<joint name="loose_joint".*?<origin xyz', "9")),
    "a loop's first frame moved": (
        "robot.urdf",
        first_number(r'<joint name="ball_loop_a_fixed".*?<origin xyz', "9"),
    ),
    "a loop's second frame lost": (
        "robot.urdf",
        drop(r'<link name="fixed_loop_b"/>\s*<joint name="fixed_loop_b_fixed".*?</joint>'),
    ),
    "a floating joint fixed": ("robot.urdf", swap('type="floating"', 'type="fixed"')),
}


def test_the_extremes_of_a_ball_are_three_turns() -> None:
    """Also where the middle turn is a right angle, and the other two are one."""
    x, y, z = np.eye(3)
    for angles in ((0.3, -1.1, 2.0), (0.3, np.pi / 2, 0.4), (-2.0, -np.pi / 2, 3.0), (0.0, 0.0, 0.0)):
        rotation = turned(x, angles[0]) @ turned(y, angles[1]) @ turned(z, angles[2])
        again = turns_from_rotation(rotation)
        found = turned(x, again[0]) @ turned(y, again[1]) @ turned(z, again[2])
        assert np.abs(found - rotation).max() < 1e-12


@pytest.mark.parametrize("fault", MORE_FAULTS)
def test_a_fault_planted_in_any_kind_of_joint_or_loop_fails_a_check(
    every: tuple[Robot, Path, UrdfForm], tmp_path: Path, fault: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """One that compares with the robot: a simulation takes seconds."""
    compared = [check for check in MODEL_CHECKS if "simulated" not in check.files]
    monkeypatch.setattr("linkwright.stages.validate.checks.MODEL_CHECKS", compared)
    robot, folder, form = every
    shutil.copytree(folder, tmp_path / "bad")
    file, change = MORE_FAULTS[fault]
    before = (folder / file).read_text()
    after = change(before)
    assert after != before
    (tmp_path / "bad" / file).write_text(after)
    checks = checked(tmp_path / "bad", robot, plan_of(), urdf_form=form)
    assert any(check.fails and check.name.startswith(file) for check in checks)


def test_every_module_of_the_room_of_checks_is_a_row_of_its_table() -> None:
    room = PROJECT / "stages/validate/checks"
    modules = [file.stem for file in room.rglob("*.py") if file.name != "__init__.py"]
    assert sorted(check.title.replace(" ", "_") for check in MODEL_CHECKS) == sorted(modules)


def test_a_model_without_one_of_the_joints_is_checked_no_further(
    good: tuple[Robot, Path], tmp_path: Path
) -> None:
    robot, folder = good
    shutil.copytree(folder, tmp_path / "bad")
    file = tmp_path / "bad" / "robot.urdf"
    file.write_text(FAULTS["a joint renamed"][1](file.read_text()))
    every = [check for check in checked(tmp_path / "bad", robot, plan_of()) if "urdf" in check.name]
    checks = every[[check.code for check in every].index("C-COMPILE") :]
    assert [(check.name.split(": ")[1], check.passed) for check in checks] == [
        ("compiles", True),
        ("links and joints", False),
        ("runs", True),
    ]
    assert checks[1].detail == "missing: rail"
