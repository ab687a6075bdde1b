"""Default classes change no number of the compiled model, and nothing that a class holds is said again."""

import mujoco
import numpy as np
from lxml import etree

from linkwright.stages.export.mjcf import model as mjcf_model
from linkwright.stages.mesh import make_geometry
from linkwright.stages.robot.model.robot import Dynamics, Limits, Relation
from tests.support.building import plan_of, write
from tests.support.robots import at, joint, loop, robot_with
from tests.support.touching import NO_FILES, ball, box, no_memo

SOFT = {"friction": [0.8, 0.02, 0.001], "condim": 6, "priority": 1}


def crawler():
    """Joints of two motors, a slider, a ball, a loop and a relation; feet and a body that collide."""
    strong = Dynamics(damping=0.1, friction=0.02, armature=0.01, effort=20)
    weak = Dynamics(damping=0.05, armature=0.001, effort=3)
    joints = []
    for side, x in (("a", 0.1), ("b", 0.2), ("c", 0.3)):
        hip = {"name": f"hip_{side}", "limits": {f"hip_{side}": Limits(-1, 1)}, "place": at(x, 0, 0)}
        joints.append(joint("revolute", "base", f"leg_{side}", dynamics=strong, **hip))
    for side in "ab":
        ankle = {"name": f"ankle_{side}", "place": at(0, 0, -0.2)}
        joints.append(joint("revolute", f"leg_{side}", f"foot_{side}", dynamics=weak, **ankle))
    joints.append(joint("prismatic", "base", "mast", name="mast"))
    joints.append(joint("ball", "mast", "head", name="neck"))
    joints.append(joint("revolute", "base", "bare", name="bare"))
    return robot_with(
        joints,
        loops=[loop("revolute", "leg_c", "bare", at(0, 0.1, 0), at(0.3, 0.1, 0))],
        relations=[Relation("gear", "hip_b", "hip_a", -1.0, 0.0)],
        shapes={"base": (box(0.4, 0.1, 0.1),), "foot_a": (ball(0.02),), "foot_b": (ball(0.02),)},
    )


KEYS = {
    "actuators": {"hip_*": {"type": "position", "kp": 20}, "ankle_*": {"type": "motor"}},
    "geoms": {"foot_*": {"collision": SOFT}},
}


def written(folder, keys=KEYS):
    """The elements of the crawler's MJCF, and the model that MuJoCo compiles."""
    robot = crawler()
    geometry = make_geometry(robot, NO_FILES, plan_of(contact={"self": "auto"}, **KEYS), no_memo)
    write(robot, folder, plan_of(**keys), geometry)
    path = str(folder / "robot.xml")
    return etree.parse(path).getroot(), mujoco.MjModel.from_xml_path(path)


def arrays(model):
    values = {name: getattr(model, name) for name in dir(model) if not name.startswith("_")}
    return {name: v.copy() for name, v in values.items() if isinstance(v, np.ndarray) and name != "names"}


def test_classes_change_no_number(tmp_path, monkeypatch):
    first = arrays(written(tmp_path / "with")[1])
    monkeypatch.setattr(mjcf_model, "write_classes", lambda *_: None)
    second = arrays(written(tmp_path / "without")[1])
    assert "geom_friction" in first
    assert first.keys() == second.keys()
    assert [key for key in first if not np.array_equal(first[key], second[key], equal_nan=True)] == []


def test_attributes_of_a_class_are_not_repeated(tmp_path):
    root, _ = written(tmp_path)
    held = {}
    for default in root.iter("default"):
        elements = [element for element in default if element.tag != "default"]
        attributes = {key: value for element in elements for key, value in element.items()}
        above = held.get(default.getparent().get("class"), {})
        if default.get("class"):
            held[default.get("class")] = {**above, **attributes}
    assert {"hip", "ankle", "slide", "ball", "closure", "motor", "foot"} <= set(held)
    used = [element for element in root.iter() if element.get("class") and element.tag != "default"]
    assert {element.get("class") for element in used} <= set(held)
    for element in used:
        again = {key for key, value in element.items() if held[element.get("class")].get(key) == value}
        assert not again, etree.tostring(element)
    world = root.find("worldbody")
    joints = {element.get("name"): element.get("class") for element in world.iter("joint")}
    assert joints["hip_a"] == joints["hip_b"] == joints["hip_c"] == "hip"
    assert joints["ankle_a"] == joints["ankle_b"] == "ankle"
    assert all(element.get("class") for element in world.iter("geom", "joint"))
    assert not [geom for geom in world.iter("geom") if {"contype", "conaffinity", "group"} & set(geom.keys())]


def test_class_is_named_after_its_motor_or_its_joints(tmp_path):
    root, _ = written(tmp_path, {"actuators": {"hip_[ab]": {"motor": "sts3215"}, "ankle_*": "position"}})
    classes = {element.get("name"): element.get("class") for element in root.find("worldbody").iter("joint")}
    assert (classes["hip_a"], classes["ankle_a"]) == ("sts3215", "ankle")
    # Not `hip`: others are called so, too.
    assert classes["hip_c"] == "hinge"
