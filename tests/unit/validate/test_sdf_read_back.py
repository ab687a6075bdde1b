"""The SDF is read back: a good one passes every check, every fault planted in one fails the check for it."""

import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from linkwright.stages.formats.sdf.elements import SdfError
from linkwright.stages.formats.sdf.parse import parse_sdf
from linkwright.stages.robot.model.robot import Dynamics, Frame, Limits, Relation, Robot, frozen
from linkwright.stages.robot.motion.kinematics import link_poses
from tests.support.building import plan_of, write
from tests.support.checked import checked
from tests.support.robots import EVERY, LOOPS, at, joint, loop, pose, robot_with

PLAN = plan_of(export={"sdf": {}})


def looped(kind: str = "revolute") -> Robot:
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


def checks(robot: Robot, folder: Path, change: Callable[[str], str] = str) -> dict[str, bool]:
    """What the checks of the SDF say, after a change to its text."""
    write(robot, folder, PLAN)
    path = folder / "robot.sdf"
    before = path.read_text()
    path.write_text(change(before))
    assert change is str or path.read_text() != before
    found = [one for one in checked(folder, robot, PLAN) if one.name.startswith("robot.sdf: ")]
    return {one.name.removeprefix("robot.sdf: "): one.passed for one in found}


@pytest.mark.parametrize("fixed", [True, False])
@pytest.mark.parametrize("kind", EVERY)
def test_every_joint_passes_every_check(kind: str, fixed: bool, tmp_path: Path) -> None:
    rng = np.random.default_rng(EVERY.index(kind))
    saved = [(0.1, 0.2, 0.3, 0.8, 0.6, 0.0, 0.0)] if kind == "free" else None
    origins = [pose(rng) for _ in range(3)]
    rows = [joint(kind, "base", "one", saved, place=pose(rng), backwards=fixed, origins=origins)]
    rows.append(joint("prismatic", "one", "two", place=pose(rng), mirrored=True))
    found = checks(robot_with(rows, fixed=fixed), tmp_path)
    assert len(found) == 11
    assert all(found.values()), found


@pytest.mark.parametrize("folder", ["", "model://robot/"])
def test_a_mesh_that_is_not_there_is_found(folder: str, tmp_path: Path) -> None:
    mesh = f"<mesh><uri>{folder}assets/one.stl</uri></mesh>"
    visual = f'<visual name="lost"><geometry>{mesh}</geometry></visual>'
    robot = robot_with([joint("revolute", "base", "one")])
    assert not checks(robot, tmp_path, lambda text: text.replace("</link>", f"{visual}</link>", 1))["meshes"]
    (tmp_path / "assets").mkdir()
    (tmp_path / "assets/one.stl").touch()
    assert checks(robot, tmp_path, lambda text: text.replace("</link>", f"{visual}</link>", 1))["meshes"]


@pytest.mark.parametrize("kind", LOOPS)
def test_every_loop_passes_every_check(kind: str, tmp_path: Path) -> None:
    found = checks(looped(kind), tmp_path)
    assert found.pop("loops")
    assert all(found.values()), found


def test_a_loop_that_begins_on_the_root_passes_every_check(tmp_path: Path) -> None:
    for kind in ("ball", "pin_slot"):
        robot = looped(kind)
        (one,) = robot.loops
        end = joint(kind, "base", "end", [dof.saved for dof in one.dofs])
        across = link_poses(robot_with([end]), {dof.name: dof.saved for dof in end.dofs})["end"]
        # Of the same values, seen from the other side.
        turned = replace(
            one,
            link_a="base",
            link_b="two",
            a_from_frame=frozen(one.b_from_frame @ across @ across),
            b_from_frame=frozen(one.a_from_frame),
        )
        found = checks(replace(robot, loops=(turned,)), tmp_path)
        assert all(found.values()), found


def within(tag: str, name: str, pattern: str, text: str) -> Callable[[str], str]:
    """Changes what matches in the element with a tag and a name."""

    def change(whole: str) -> str:
        (block,) = re.findall(rf'<{tag} name="{name}".*?</{tag}>', whole, re.DOTALL)
        return whole.replace(block, re.sub(pattern, text, block, count=1, flags=re.DOTALL))

    return change


FAULTS = {
    "a mass": ("mass", within("link", "two", r"<mass>.*?</mass>", "<mass>9</mass>")),
    "a mass between": ("mass", within("link", "three_joint_1", r"<mass>.*?</mass>", "<mass>0.1</mass>")),
    "a centre of mass": (
        "centre of mass",
        within("link", "one", r"(<inertial>\s*<pose>)\S+", r"\g<1>0.5"),
    ),
    "a product of inertia": ("inertia", within("link", "one", r"<ixy>.*?</ixy>", "<ixy>0</ixy>")),
    "an axis": ("motion", within("joint", "one_joint", r"<xyz>.*?</xyz>", "<xyz>0 1 0</xyz>")),
    "an axis's sign": ("motion", within("joint", "one_joint", r"<xyz>0 0 1</xyz>", "<xyz>0 0 -1</xyz>")),
    "a joint's place": ("motion", within("joint", "gear_joint", r"(<pose[^>]*>)\S+", r"\g<1>0.5")),
    "a link's place": ("motion", within("link", "gear", r"(<pose[^>]*>)0 0 0", r"\g<1>0 0.1 0")),
    "a part": ("poses", within("joint", "one_joint", r"(<pose[^>]*>)\S+", r"\g<1>0.5")),
    "a frame": ("motion", within("frame", "tip", r"0 0 0.1", "0 0 0.2")),
    "a frame's link": ("motion", lambda text: text.replace('attached_to="two"', 'attached_to="one"')),
    "a type": ("joints", within("joint", "one_joint", 'type="revolute"', 'type="prismatic"')),
    "an end of a range": ("joints", within("joint", "one_joint", r"<lower>.*?</lower>", "<lower>-1</lower>")),
    "a range less": ("joints", within("joint", "one_joint", r"<lower>.*?</lower>", "")),
    "a range more": ("joints", within("joint", "gear_joint", r"<limit>", "<limit><lower>0</lower>")),
    "an effort": ("joints", within("joint", "one_joint", r"<effort>3", "<effort>4")),
    "a velocity": ("joints", within("joint", "one_joint", r"<velocity>4", "<velocity>3")),
    "a damping": ("joints", within("joint", "one_joint", r"<damping>0.1", "<damping>0.2")),
    "a friction": ("joints", within("joint", "one_joint", r"<friction>0.2", "<friction>0.1")),
    "a gear's ratio": ("relations", within("joint", "gear_joint", r"<multiplier>2", "<multiplier>-2")),
    "a gear's offset": ("relations", within("joint", "gear_joint", r"<offset>1.5", "<offset>0.5")),
    "a gear's driver": ("relations", within("joint", "gear_joint", 'joint="one_', 'joint="three_')),
    "no gear": ("relations", within("joint", "gear_joint", "<mimic.*</mimic>", "")),
    "a loop's place": ("loops", within("joint", "shut", r"(<pose[^>]*>)\S+", r"\g<1>0.5")),
    "a loop's axis": ("loops", within("joint", "shut", r"<xyz>.*?</xyz>", "<xyz>1 0 0</xyz>")),
    "a loop's end": ("loops", within("joint", "shut", "<child>two", "<child>one")),
    "a frame less": (
        "links and joints", lambda text: re.sub('<frame name="tip.*?</frame>', "", text, flags=re.S)),
    "a frame more": (
        "links and joints",
        lambda text: text.replace("</model>", '<frame name="more" attached_to="one"/></model>'),
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", FAULTS)
def test_a_fault_fails_the_check_that_is_meant_for_it(name: str, tmp_path: Path) -> None:
    check, change = FAULTS[name]
    found = checks(looped(), tmp_path, change)
    assert found["reads"]
    assert not found[check], found


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (lambda text: text[:-20], "line"),
        (lambda text: text.replace('version="1.9"', 'version="1.4"'), "not one model"),
        (lambda text: text.replace('relative_to="one_joint"', 'relative_to="none"'), "'none'"),
        (lambda text: text.replace('<link name="one"', '<link name="two"'), "one name"),
        (lambda text: text.replace('<frame name="tip"', '<frame name="two"'), "'two'"),
        (lambda text: text.replace("<child>two", "<child>tow"), "'tow'"),
        (lambda text: text.replace("<mass>1</mass>", "<mass>heavy</mass>"), "'heavy'"),
        (lambda text: text.replace("<mass>1</mass>", "<mass>nan</mass>"), "'nan'"),
        (lambda text: text.replace("<mass>1</mass>", ""), "no <mass>"),
        (lambda text: text.replace('type="ball"', 'type="universal"'), "universal"),
        (lambda text: text.replace("</model>", "<static>true</static></model>"), "<static>"),
        (lambda text: text.replace("<xyz>0 0 1", '<xyz expressed_in="base">0 0 1'), "axis"),
        (lambda text: text.replace("<pose relative", '<pose degrees="true" relative'), "relative_to"),
        (lambda text: text.replace('attached_to="two"', 'attached_to="tip"'), "tip"),
    ],
)
def test_what_cannot_be_read_is_one_failed_check_that_says_why(
    change: Callable[[str], str], says: str, tmp_path: Path
) -> None:
    assert checks(looped(), tmp_path, change) == {"reads": False}
    with pytest.raises(SdfError, match=re.escape(says)):
        parse_sdf((tmp_path / "robot.sdf").read_bytes())


def test_quick_only_reads_it(tmp_path: Path) -> None:
    robot = looped()
    write(robot, tmp_path, PLAN)
    quick = plan_of(export={"sdf": {}}, validate={"level": "quick"})
    names = [check.name for check in checked(tmp_path, robot, quick)]
    assert names == ["model.config: names", "robot.sdf: reads"]
