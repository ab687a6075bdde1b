"""The validate stage finds what is wrong: every fault planted in a good build fails a check."""

import re
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

from stages.mesh import make_geometry
from stages.robot.model import Robot
from stages.validate import validate
from tests.building import bundle_of, plan_of, robot_of, write
from tests.kit import SIDE, TOP, Kit, four_bar
from tests.onshape.frames import turn


@pytest.fixture(scope="module")
def good(tmp_path_factory: pytest.TempPathFactory) -> tuple[Robot, Path]:
    """A robot with hinges, a slider, a loop, a gear and a frame, all saved at zero or not."""
    kit = Kit()
    four_bar(kit)
    base = kit.root.instances[0]
    from tests.onshape.document import Occurrence

    held = Occurrence([base])
    cart, wheel, idler = kit.place("Cart"), kit.place("Wheel"), kit.place("Idler")
    kit.root.slider("Rail", (cart, TOP), (held, SIDE), limits=(-0.1, 0.2))
    first = kit.root.revolute("Spin", (wheel, TOP), (held, TOP), limits=(-3, 3))
    second = kit.root.revolute("Idle", (idler, TOP), (held, turn((1, 0, 0), 1)), limits=(-3, 3))
    kit.root.gear("Gear", first, second, 1.5)
    kit.root.connector("Tool", cart, SIDE)
    plan = plan_of(joints={"*": {"effort": 5, "velocity": 2}})
    robot = robot_of(kit.document, plan)
    geometry = make_geometry(robot, bundle_of(kit.document), plan, lambda kind, key, make: make())
    folder = tmp_path_factory.mktemp("good")
    write(robot, folder, plan, geometry)
    return robot, folder


def test_the_good_build_passes_every_check(good: tuple[Robot, Path]) -> None:
    robot, folder = good
    checks = validate(folder, robot, plan_of())
    assert len(checks) > 30
    assert [check.name for check in checks if not check.passed] == []


def drop(pattern: str) -> Callable[[str], str]:
    return lambda text: re.sub(pattern, "", text, flags=re.DOTALL)


def swap(old: str, new: str) -> Callable[[str], str]:
    return lambda text: text.replace(old, new, 1)


FAULTS = {
    "no equalities": ("robot.xml", drop(r"<equality>.*</equality>")),
    "no connects": ("robot.xml", drop(r"<connect [^>]*/>")),
    "one connect less": ("robot.xml", lambda text: re.sub(r"<connect [^>]*/>", "", text, count=1)),
    "gear turned round": ("robot.xml", swap("-1.5 0 0 0", "1.5 0 0 0")),
    "a range changed": ("robot.xml", swap('range="-0.1 0.2"', 'range="-0.1 0.3"')),
    "a range dropped": ("robot.xml", drop(r' range="-0.1 0.2"')),
    "effort changed": ("robot.xml", swap('actuatorfrcrange="-5 5"', 'actuatorfrcrange="-6 6"')),
    "no keyframes": ("robot.xml", drop(r"<keyframe>.*</keyframe>")),
    "the saved pose changed": (
        "robot.xml",
        lambda text: re.sub(r'(name="cad" qpos=")[^ ]+', r"\g<1>0.123", text),
    ),
    "a site moved": ("robot.xml", lambda text: re.sub(r'(<site name="tool" pos=")[^ ]+', r"\g<1>9", text)),
    "a body moved": ("robot.xml", lambda text: re.sub(r'(<body name="cart" pos=")[^ ]+', r"\g<1>9", text)),
    "an axis flipped": (
        "robot.xml",
        swap('name="spin" type="hinge" axis="0 0 1"', 'name="spin" type="hinge" axis="0 0 -1"'),
    ),
    "another axis": (
        "robot.xml",
        swap('name="spin" type="hinge" axis="0 0 1"', 'name="spin" type="hinge" axis="1 0 0"'),
    ),
    "a hinge for a slide": ("robot.xml", swap('type="slide"', 'type="hinge"')),
    "a mass changed": ("robot.xml", lambda text: re.sub(r'mass="0.06"', 'mass="0.061"', text, count=1)),
    "an inertia changed": (
        "robot.xml",
        lambda text: re.sub(r'fullinertia="[^ ]+', 'fullinertia="5.1e-5', text, count=1),
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
    "a mesh lost": ("robot.urdf", swap("assets/cart.stl", "assets/nothing.stl")),
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
    failed = [check.name for check in validate(tmp_path / "bad", robot, plan_of()) if not check.passed]
    assert any(name.startswith(file) for name in failed)


def test_quick_only_compiles(good: tuple[Robot, Path]) -> None:
    robot, folder = good
    checks = validate(folder, robot, plan_of(validate={"level": "quick"}))
    assert [check.name for check in checks] == [
        "robot.xml: compiles",
        "scene.xml: compiles",
        "robot.urdf: compiles",
    ]
