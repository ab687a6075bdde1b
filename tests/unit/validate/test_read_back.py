"""An SDF or a USD is read back: a good one passes every check, each fault planted in one fails its own."""

import re
import shutil
from dataclasses import replace

import numpy as np
import pytest

from linkwright.stages.formats.sdf.elements import SdfError
from linkwright.stages.formats.sdf.parse import parse_sdf
from linkwright.stages.formats.written import Written
from linkwright.stages.robot.model.poses import at_rest, from_parts, turn
from linkwright.stages.robot.model.robot import Actuator, Dynamics, Frame, Limits, Relation, frozen
from linkwright.stages.robot.motion.kinematics import link_poses
from tests.support.building import plan_of, write
from tests.support.cases import mostly_slow
from tests.support.faults.checks import DRIVES, SDF, UNREADABLE_SDF, USD
from tests.support.faults.edits import sub
from tests.support.faults.fault import table
from tests.support.robots import EVERY, LOOPS, at, joint, loop, pose, robot_with
from tests.support.usd import pxr

FILES = {"sdf": "robot.sdf", "usd": "robot.usda"}


def exported_file(form, robot, folder):
    """Exports a robot in a format and returns what was written; skips where nothing reads the format."""
    assert form == "sdf" or pxr.Usd
    written = write(robot, folder, plan_of(export={form: {}})).written
    (folder / "robot_meshes.usd").write_text("#usda 1.0\n")
    return written


def outcomes(form, written, folder, quick=False):
    """Whether each check of the file holds."""
    if form == "sdf":
        from linkwright.stages.validate.read.sdf import check_file
    else:
        from linkwright.stages.validate.read.usd import check_file
    checks = check_file(folder / FILES[form], written, quick=quick)
    return {check.name.partition(": ")[2]: not check.fails for check in checks}


def failed(form, robot, folder):
    """The checks of an exported file that fail."""
    passed = outcomes(form, exported_file(form, robot, folder), folder)
    assert len(passed) > 8
    return [name for name, holds in passed.items() if not holds]


@pytest.mark.parametrize("form", FILES)
@pytest.mark.parametrize("fixed", mostly_slow([True, False], 1))
@pytest.mark.parametrize("kind", EVERY)
def test_every_joint_passes_every_check(kind, fixed, form, tmp_path):
    rng = np.random.default_rng(EVERY.index(kind))
    root = "world" if (kind, form) == ("free", "usd") else "base"
    saved = [(0.1, 0.2, 0.3, 0.8, 0.6, 0.0, 0.0)] if (kind, root) == ("free", "base") else None
    origins = [pose(rng) for _ in range(3)]
    rows = [
        joint(kind, root, "one", saved, place=pose(rng), backwards=fixed, origins=origins),
        joint("prismatic", "one", "two", place=pose(rng), mirrored=True),
        joint("ball", "two", "three", [(0.8, 0.0, 0.6, 0.0)], place=pose(rng)),
    ]
    robot = robot_with(rows, root=root, fixed=fixed or root == "world")
    assert failed(form, robot, tmp_path) == []


def looped(kind="revolute"):
    """A robot whose loop is closed at its saved pose, not at zero, with a gear and a frame beside it."""
    rng = np.random.default_rng(5)
    limits = {"one_joint": Limits(-1, 2)}
    rows = [
        joint("revolute", "base", "one", [0.5], limits=limits, dynamics=Dynamics(0.1, 0.2, None, 3, 4)),
        joint("ball", "one", "two", [(0.8, 0.6, 0.0, 0.0)], place=pose(rng)),
        joint("cylindrical", "base", "three", [0.1, 0.3], place=pose(rng)),
        joint("revolute", "base", "gear", [1.5], place=at(0, 1, 0), limits={"gear_joint": Limits(None, 4)}),
    ]
    gear = Relation("Gear", "gear_joint", "one_joint", 2.0, 0.5)
    robot = robot_with(rows, relations=[gear], frames=[Frame("tip", "two", frozen(at(0, 0, 0.1)), "Tip")])
    poses = link_poses(robot, {dof.name: dof.saved for dof in robot.dofs})
    near = pose(rng)
    own = [0.2 * (index + 1) for index in range(len(loop(kind, "two", "base", near, near).dofs))]
    values = [(0.6, 0.0, 0.8, 0.0)] if kind == "ball" else own
    end = joint(kind, "base", "end", values)
    across = link_poses(robot_with([end]), {dof.name: dof.saved for dof in end.dofs})["end"]
    shut = loop(kind, "two", "base", near, poses["two"] @ near @ np.linalg.inv(across), values, name="shut")
    return replace(robot, loops=(shut,))


@pytest.mark.parametrize("kind", LOOPS)
def test_every_loop_passes_every_check(kind, tmp_path):
    assert failed("sdf", looped(kind), tmp_path) == []


@pytest.mark.parametrize("kind", ["ball", "pin_slot"])
def test_loop_that_begins_on_the_root_passes_every_check(kind, tmp_path):
    """The loop has the same values, seen from the other side."""
    robot = looped(kind)
    (shut,) = robot.loops
    end = joint(kind, "base", "end", [dof.saved for dof in shut.dofs])
    across = link_poses(robot_with([end]), {dof.name: dof.saved for dof in end.dofs})["end"]
    frames = {
        "a_from_frame": frozen(shut.b_from_frame @ across @ across),
        "b_from_frame": frozen(shut.a_from_frame),
    }
    turned = replace(shut, link_a="base", link_b="two", **frames)
    assert failed("sdf", replace(robot, loops=(turned,)), tmp_path) == []


@pytest.mark.parametrize("shifted", mostly_slow([True, False], 1))
@pytest.mark.parametrize("kind", LOOPS)
def test_every_loop_of_a_usd_passes_every_check(kind, shifted, tmp_path):
    rng = np.random.default_rng(LOOPS.index(kind))
    rows = [
        joint("planar", "base", "one", [0.2, -0.1, 0.4], place=pose(rng)),
        joint("revolute", "one", "two", [0.3], place=pose(rng)),
    ]
    robot = robot_with(rows)
    poses, near = link_poses(robot, {dof.name: dof.saved for dof in robot.dofs}), pose(rng)
    shut = loop(kind, "two", "base", near, poses["two"] @ near, name="shut")
    shut = replace(shut, dofs=tuple(replace(dof, saved=at_rest(dof.kind)) for dof in shut.dofs))
    if shifted:
        mate = joint(kind, "base", "end", name="shut", origins=[pose(rng) for _ in range(3)])
        across = link_poses(robot_with([mate]), {})["end"]
        shut = replace(shut, dofs=mate.dofs, b_from_frame=poses["two"] @ near @ np.linalg.inv(across))
    assert failed("usd", replace(robot, loops=(shut,)), tmp_path) == []


def test_limit_of_a_usd_on_a_motion_that_is_free_is_found(tmp_path):
    shut = loop("planar", "one", "base", np.eye(4), np.eye(4), name="shut")
    robot = replace(robot_with([joint("ball", "base", "one")]), loops=(shut,))
    written = exported_file("usd", robot, tmp_path)
    assert all(outcomes("usd", written, tmp_path).values())
    limit = "float limit:transX:physics"
    ends = f"{limit}:low = -1\n{limit}:high = 1\n"
    (fault,) = table("usd", ("a limit", sub('PhysicsJoint "shut".*?{', r"\g<0>" + ends), "loops"))
    fault.change(tmp_path, "robot")
    assert not outcomes("usd", written, tmp_path)["loops"]


@pytest.mark.parametrize("folder", ["", "model://robot/"])
def test_mesh_of_an_sdf_that_is_not_there_is_found(folder, tmp_path):
    mesh = f"<mesh><uri>{folder}assets/one.stl</uri></mesh>"
    visual = f'<visual name="lost"><geometry>{mesh}</geometry></visual>'
    (fault,) = table("sdf", ("a mesh", sub("</link>", f"{visual}</link>"), "meshes"))
    written = exported_file("sdf", robot_with([joint("revolute", "base", "one")]), tmp_path)
    fault.change(tmp_path, "robot")
    assert not outcomes("sdf", written, tmp_path)["meshes"]
    (tmp_path / "assets").mkdir(exist_ok=True)
    (tmp_path / "assets/one.stl").touch()
    assert outcomes("sdf", written, tmp_path)["meshes"]


ANGLES = (3e-9, 1.1e-7, 1.3e-5, 7.7e-3, 3.0, 4e-8, 3e-6, 4.7e-4, 0.3)


@pytest.mark.parametrize("angle", mostly_slow(ANGLES, 5))
def test_link_that_is_turned_by_any_angle_stands_where_it_is(angle, tmp_path):
    """A USD has single precision: it finds the angle as 2 arccos w, where w has steps of 1.1e-16."""

    def turned(by):
        place = from_parts(turn(np.array([0.6, 0.0, 0.8]), by), np.array([0.3, 0.2, 0.1]))
        return place, robot_with([joint("revolute", "base", "arm", name="elbow", place=place)], fixed=True)

    place, robot = turned(angle)
    assert failed("usd", robot, tmp_path) == []
    stage = pxr.Usd.Stage.Open(str(tmp_path / "robot.usda"))
    prim = next(prim for prim in stage.Traverse() if prim.GetName() == "arm")
    placed = np.array(pxr.UsdGeom.Xformable(prim).ComputeLocalToWorldTransform(0)).T
    assert np.abs(placed - place).max() < min(3e-8, 4e-16 / angle + 1e-11)
    _, other = turned(angle + 1e-7)
    assert not outcomes("usd", Written(other), tmp_path)["home"]


def test_link_may_have_the_name_of_its_robot(tmp_path):
    rows = [joint("revolute", "base", "robot"), joint("prismatic", "robot", "hand")]
    assert failed("usd", robot_with(rows, fixed=True), tmp_path) == []


def with_servo():
    """A robot with a loop, and the same with a servo."""
    limits = {"elbow": Limits(-1, 2), "slide": Limits(None, 0.5)}
    rows = [
        joint("revolute", "base", "arm", name="elbow", limits=limits, dynamics=Dynamics(0.1)),
        joint("prismatic", "arm", "hand", name="slide", limits=limits),
    ]
    shut = loop("ball", "hand", "base", np.eye(4), np.eye(4), name="shut")
    servo = Actuator("servo", "elbow", "position", kp=90, kv=3, force=(-7, 7))
    robot = replace(robot_with(rows), loops=(shut,))
    return robot, replace(robot, actuators=(servo,))


@pytest.mark.parametrize(
    ("pattern", "new"),
    [
        ('PhysicsFixedJoint "root_joint"', 'PhysicsRevoluteJoint "root_joint"'),
        (r'("root_joint".*?body1 = </robot/)base>', r"\g<1>hand>"),
        (r'("root_joint".*?)(\n +point3f)', r"\1\n bool physics:excludeFromArticulation = 1\2"),
    ],
)
def test_joint_of_a_base_that_holds_something_else_is_found(pattern, new, tmp_path):
    robot = robot_with([joint("revolute", "base", "hand")], fixed=True)
    written = exported_file("usd", robot, tmp_path)
    path = tmp_path / "robot.usda"
    text, count = re.subn(pattern, new, path.read_text(), count=1, flags=re.DOTALL)
    assert count
    path.write_text(text)
    assert [name for name, holds in outcomes("usd", written, tmp_path).items() if not holds] == ["model"]


@pytest.mark.parametrize(("old", "new"), [
    (r"coneAngle1Limit = [\d.]+", "coneAngle1Limit = 90"), (r'physics:axis = "X"', 'physics:axis = "Y"'),
])  # fmt: skip
def test_cone_of_a_ball_is_circular_about_x(old, new, tmp_path):
    limits = {"hand_joint": Limits(None, 0.5)}
    robot = robot_with([joint("ball", "base", "hand", limits=limits)])
    written = exported_file("usd", robot, tmp_path)
    assert all(outcomes("usd", written, tmp_path).values())
    path = tmp_path / "robot.usda"
    text, count = re.subn(old, new, path.read_text())
    assert count
    path.write_text(text)
    assert [name for name, holds in outcomes("usd", written, tmp_path).items() if not holds] == ["model"]


@pytest.fixture(scope="module")
def good(tmp_path_factory):
    """The files of a robot, by `sdf`, `usd` or `servo`, with no fault; each exported when first asked for."""
    made = {}

    def get(name, folder):
        if name not in made:
            robot = looped() if name == "sdf" else with_servo()[name == "servo"]
            place, form = tmp_path_factory.mktemp(name), "sdf" if name == "sdf" else "usd"
            made[name] = place, exported_file(form, robot, place)
            assert all(outcomes(form, made[name][1], place).values())
        shutil.copytree(made[name][0], folder, dirs_exist_ok=True)
        return made[name][1]

    return get


@pytest.mark.parametrize("fault", [*SDF, *USD, *DRIVES], ids=lambda fault: f"{fault.title}: {fault.expects}")
def test_fault_fails_the_check_that_is_meant_for_it(fault, good, tmp_path):
    written = good("servo" if fault in DRIVES else fault.file, tmp_path)
    fault.change(tmp_path, "robot")
    wrong = [name for name, holds in outcomes(fault.file, written, tmp_path).items() if not holds]
    assert "reads" not in wrong
    assert wrong == ["drives"] if fault in DRIVES else fault.expects in wrong


@pytest.mark.parametrize("fault", UNREADABLE_SDF, ids=lambda fault: fault.kind)
def test_what_cannot_be_read_is_one_failed_check_that_says_why(fault, good, tmp_path):
    written = good("sdf", tmp_path)
    fault.change(tmp_path, "robot")
    assert outcomes("sdf", written, tmp_path) == {"reads": False}
    with pytest.raises(SdfError, match=re.escape(fault.expects)):
        parse_sdf((tmp_path / "robot.sdf").read_bytes())


def sdf_of(frames):
    """An SDF of a link and of frames."""
    entries = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
    tensor = "".join(f"<{entry}>{int(entry[1] == entry[2])}</{entry}>" for entry in entries)
    inertial = f"<inertial><mass>1</mass><inertia>{tensor}</inertia></inertial>"
    model = f'<model name="m"><link name="base">{inertial}</link>{frames}</model>'
    return f'<sdf version="1.9">{model}</sdf>'.encode()


def test_long_chain_of_frames_is_placed():
    pose = "<pose>0 0 1 0 0 0</pose>"
    frames = [f'<frame name="f{n}" attached_to="f{n + 1}">{pose}</frame>' for n in range(1500)]
    last = '<frame name="f1500" attached_to="base"/>'
    frame = parse_sdf(sdf_of("".join(frames) + last)).frames["f0"]
    assert (frame.link, frame.model_from_frame[2, 3]) == ("base", 1500)


@pytest.mark.parametrize(("frames", "fault"), [
    ("<frame/>", "an element <frame> has no name"),
    ('<frame name="a"><pose relative_to="b"/></frame><frame name="b" attached_to="a"/>', "is on no link"),
    ('<frame name="a" attached_to="base"><pose relative_to="b">0 0 0 0 0 0</pose></frame>'
     '<frame name="b" attached_to="a"/>', "the pose of 'a' is relative to itself"),
    ('<frame name="a" attached_to="base"><pose relative_to="b">0 0 0 0 0 0</pose></frame>',
     "nothing is named 'b'"),
])  # fmt: skip
def test_frame_without_a_name_or_a_place_is_refused(frames, fault):
    with pytest.raises(SdfError, match=fault):
        parse_sdf(sdf_of(frames))


@pytest.mark.parametrize("text", ["", "nonsense", "#usda 1.0\n"])
def test_usd_that_cannot_be_read_is_one_failed_check(text, good, tmp_path):
    written = good("usd", tmp_path)
    (tmp_path / "robot.usda").write_text(text)
    assert outcomes("usd", written, tmp_path) == {"reads": False}


@pytest.mark.parametrize("form", FILES)
def test_quick_only_reads(form, good, tmp_path):
    assert outcomes(form, good(form, tmp_path), tmp_path, quick=True) == {"reads": True}
