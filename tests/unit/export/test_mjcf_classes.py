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
from tests.unit.export.test_standing import shaped

SOFT = {"friction": [0.8, 0.02, 0.001], "condim": 6, "priority": 1}


def crawler():
    """Joints of two motors, a slider, a ball, a loop and a relation; feet and a body that collide."""
    strong = Dynamics(damping=0.1, friction=0.02, armature=0.01, effort=20)
    weak = Dynamics(damping=0.05, armature=0.001, effort=3)
    limits = {f"hip_{side}": Limits(-1, 1) for side in "abc"}
    joints = [
        joint(
            "revolute",
            "base",
            f"leg_{side}",
            name=f"hip_{side}",
            limits=limits,
            dynamics=strong,
            place=at(x, 0, 0),
        )
        for side, x in (("a", 0.1), ("b", 0.2), ("c", 0.3))
    ]
    joints += [
        joint(
            "revolute",
            f"leg_{side}",
            f"foot_{side}",
            name=f"ankle_{side}",
            dynamics=weak,
            place=at(0, 0, -0.2),
        )
        for side in "ab"
    ]
    joints += [
        joint("prismatic", "base", "mast", name="mast"),
        joint("ball", "mast", "head", name="neck"),
        joint("revolute", "base", "bare", name="bare"),
    ]
    robot = robot_with(
        joints,
        loops=[loop("revolute", "leg_c", "bare", at(0, 0.1, 0), at(0.3, 0.1, 0))],
        relations=[Relation("gear", "hip_b", "hip_a", -1.0, 0.0)],
    )
    feet = {f"foot_{side}": [ball(0.02)] for side in "ab"}
    return shaped(robot, base=[box(0.4, 0.1, 0.1)], **feet)


KEYS = {
    "actuators": {"hip_*": {"type": "position", "kp": 20}, "ankle_*": {"type": "motor"}},
    "geoms": {"foot_*": {"collision": SOFT}},
}


def made_geometry(robot):
    return make_geometry(robot, NO_FILES, plan_of(contact={"self": "auto"}, **KEYS), no_memo)


def arrays(model):
    return {
        name: np.array(value)
        for name in dir(model)
        if not name.startswith("_")
        and isinstance(value := getattr(model, name), np.ndarray)
        and name != "names"
    }


def both(folder, monkeypatch, robot, geometry, keys):
    """The model with classes and the same without them."""
    models = []
    for name, classes in (("with", mjcf_model.write_classes), ("without", lambda *_: None)):
        monkeypatch.setattr(mjcf_model, "write_classes", classes)
        write(robot, folder / name, plan_of(**keys), geometry)
        models.append(mujoco.MjModel.from_xml_path(str(folder / name / f"{robot.name}.xml")))
    return models


def test_classes_change_no_number(tmp_path, monkeypatch):
    robot = crawler()
    geometry = made_geometry(robot)
    made, plain = both(tmp_path, monkeypatch, robot, geometry, KEYS)
    first, second = arrays(made), arrays(plain)
    assert "geom_friction" in first
    assert first.keys() == second.keys()
    different = [name for name in first if not np.array_equal(first[name], second[name], equal_nan=True)]
    assert different == []


def test_nothing_is_said_again_that_a_class_holds(tmp_path, monkeypatch):
    robot = crawler()
    write(robot, tmp_path, plan_of(**KEYS), made_geometry(robot))
    root = etree.parse(str(tmp_path / f"{robot.name}.xml")).getroot()
    held = {}
    for default in root.iter("default"):
        attributes = {
            key: value for element in default if element.tag != "default" for key, value in element.items()
        }
        above = held.get(default.getparent().get("class"), {})
        if default.get("class"):
            held[default.get("class")] = {**above, **attributes}
    assert {"hip", "ankle", "slide", "ball", "closure", "motor", "foot"} <= set(held)
    used = [element for element in root.iter() if element.get("class") and element.tag != "default"]
    assert {element.get("class") for element in used} <= set(held)
    for element in used:
        again = {key for key, value in element.items() if held[element.get("class")].get(key) == value}
        assert not again, etree.tostring(element)
    joints = {
        element.get("name"): element.get("class")
        for element in root.iter("joint")
        if element.get("class") != "closure"
    }
    assert joints["hip_a"] == joints["hip_b"] == joints["hip_c"] == "hip"
    assert joints["ankle_a"] == joints["ankle_b"] == "ankle"
    assert all(element.get("class") for element in root.find("worldbody").iter("geom", "joint"))
    for geom in root.find("worldbody").iter("geom"):
        assert not {"contype", "conaffinity", "group"} & set(geom.keys())


def test_class_is_named_after_its_motor_or_its_joints(tmp_path):
    robot = crawler()
    motors = {"hip_[ab]": {"motor": "sts3215"}, "ankle_*": "position"}
    write(robot, tmp_path, plan_of(actuators=motors), made_geometry(robot))
    root = etree.parse(str(tmp_path / f"{robot.name}.xml")).getroot()
    classes = {element.get("name"): element.get("class") for element in root.find("worldbody").iter("joint")}
    assert (classes["hip_a"], classes["ankle_a"]) == ("sts3215", "ankle")
    # Not `hip`: others are called so, too.
    assert classes["hip_c"] == "hinge"
