"""Bad values of keys are refused before a build, and entries that do not fit the robot with what it has."""

import pytest

from linkwright.stages.robot.errors import ConfigError, ExportError
from tests.support.building import plan_of, solid
from tests.support.exports import exported
from tests.support.pendulums import both, pendulum
from tests.support.robots import joint, robot_with
from tests.unit.export.test_amend import add
from tests.unit.export.test_motors import motor
from tests.unit.export.test_sensors import arm

SCENE = [
    ({"option": {"gravty": [0, 0, 1]}}, ".option.gravty", "scene.option.gravity"),
    ({"option": {"flag": {"gravity": "off"}}}, ".option.flag.gravity", "enable, disable"),
    ({"compiler": {"angle": "degree"}}, ".compiler", "another meaning"),
    ({"pose": "tuch"}, ".pose.kind", "did you mean touch?"),
    ({"pose": {"kind": "touch", "xyz": [0, 0, 1]}}, ".pose", "neither xyz nor rpy"),
    ({"lights": {"a": "spt"}}, ".lights.a.kind", "did you mean spot?"),
    ({"lights": {"a": {"direction": [0, 0, 0]}}}, ".lights.a", "must not be 0 0 0"),
    ({"skybox": "nothing"}, ".skybox.kind", "gradient, none"),
    ({"cameras": {"a": {"frame": "eye", "look_at": [0, 0, 1]}}}, ".cameras.a", "without frame"),
    ({"cameras": {"a": {"look_at": [0, 0, 0]}}}, ".cameras.a", "must differ from xyz"),
]
SENSORS = [
    ({}, ".type", "missing"),
    ({"type": "sonar"}, ".type", "rangefinder"),
    ({"type": "imu", "joints": "*"}, "",
     "type imu takes frame, xyz, rpy, measure, noise, cutoff; not joints"),
    ({"type": "imu", "measure": ["gyr"]}, "",
     "type imu measures gyro, accelerometer, quat, velocimeter, magnetometer; not gyr"),
    ({"type": "imu", "measure": []}, "", "measure must name a quantity"),
    ({"type": "joint", "measure": ["pos", "pos"]}, "", "measure must name each quantity once"),
    ({"type": "frame", "relative_to": "base", "measure": ["linacc"]}, "", "exclude relative_to"),
    ({"type": "imu", "noise": {"acc": 1}}, "", "noise names acc, but the sensor measures gyro, acc"),
    ({"type": "imu", "cutoff": {"quat": 1}}, "", "cutoff does not apply to quat"),
    ({"type": "imu", "noise": -1}, "", "must be 0 or above"),
    ({"type": "imu", "noise": "1 deg"}, "", "noise: gyro is no angle, as '1 deg' is"),
    ({"type": "rangefinder", "cutoff": "1 deg"}, "", "distance is no angle"),
    ({"type": "rangefinder", "cutoff": "1 stone"}, "", "'stone' is unknown"),
    ({"type": "touch", "size": [1, 2]}, "", "radius of a ball"),
    ({"type": "touch", "size": 0}, "", "greater than 0"),
    ({"type": "camera", "fovy": 180}, "", "less than 180"),
]  # fmt: skip
ACTUATORS = [
    ({"type": "damper", "ctrlrange": [-1, 1]}, "", "begins at 0 or above"),
    ({"type": "damper", "kp": 3}, "", "type damper takes kv, forcerange, gear"),
    ({"type": "dcmotor", "forcerange": [-1, 1]}, "", "type dcmotor takes motorconst"),
    ({"type": "intvelocity", "ki": 3}, "", "type intvelocity takes kp"),
    ({"type": "pid", "kv": 1, "dampratio": 1}, "", "exclude each other"),
    ({"type": "motor", "delay": -0.1}, "", "greater than 0"),
    ({"type": "motor", "interp": "spline"}, "", "zoh"),
    ({"type": "dcmotor", "nominal": [12, 3]}, "", "3 numbers"),
    ({"type": "dcmotor", "motorconst": [1, 2, 3], "resistance": 1}, "", "list of 2 numbers"),
    ({"type": "servo"}, "", "intvelocity"),
    ({"type": "none", "motor": "sts3215"}, "", "type none takes nothing else; not motor"),
]


def effort(value):
    return {"title": "x", "values": {"effort": value}}


MOTORS = [
    ({"values": {}}, ".title", "missing"),
    (motor(torque=3), "", "torque is not a quantity of a motor: there are gear"),
    (motor(armatur=3), "", "armatur is not a quantity of a motor: did you mean armature?"),
    (motor(effort=0), "", "effort must be above 0"),
    (motor(effort=-1), "", "greater than or equal to 0"),
    (motor(armature=1, rotor_inertia=1, gear=2), "", "give only one"),
    (motor(rotor_inertia=1), "", "rotor_inertia needs the gear"),
    (effort({"value": 3, "kind": "measured"}), ".values.effort.source", "missing"),
    (effort({"value": 3, "source": "", "kind": "measured"}), "", "not be empty"),
    (effort({"value": 3, "source": "me", "kind": "guess"}), "", "datasheet"),
    (effort(3), "", "must be a mapping"),
    ({**motor(effort=1), "type": "dcmotor"}, "", "intvelocity"),
    ({**motor(effort=1), "price": 3}, ".price", ""),
]
ELEMENTS = [
    ({"into": {}, "xml": "<site/>"}, ".into", "{tag: worldbody}"),
    ({"xml": "<site/>"}, ".into", "missing"),
    ({"into": {"tag": "b"}}, "", "either xml or file"),
    (add("<site/>", {"tag": "b"}, file="c.xml"), "", "either xml or file"),
    (add("<site>", {"tag": "b"}), ".xml", "line 1, column 7"),
    (add("<site/>", {"tag": "b"}, formats=["x"]), ".formats[0]", "urdf"),
    (add("<site/>", {"tag": "b"}, formats=[]), "", "must name a format"),
    (add("<gazebo/>", {"tag": "b", "file": "scene"}, formats=["urdf"]), "", "applies only to an MJCF"),
    (add("<site/>", {"tag": "b", "name": "c", "fiel": "d"}), ".into.fiel", "elements.a.into.file"),
]
ATTRIBUTES = [
    ({}, "", "at least one attribute"),
    ({"formats": ["mjcf"]}, "", "at least one attribute"),
    ({"b": 1, "formats": ["mjfc"]}, "", "urdf, mjcf"),
    ({"b c": 1}, "", "'b c' cannot be the name"),
    ({"b": {"c": 1}}, ".b", "list of numbers"),
    ({"b": "\x00"}, ".b", "characters"),
    ({"b": 1, "tag": 3}, "", "tag must be text"),
]
FORMATS = {
    "urdf": [("meshes", "absolute", "'absolute' is not allowed"), ("package", "my robot", "of a package"),
             ("package", "../up", "of a package"), ("package", "", ""),
             ("fixed_joints", "drop", "'drop' is not allowed"),
             ("frame_inertia", "small", "'small' is not allowed")],
    "ros2": [*(("package", name, "") for name in ("My_arm", "my__arm", "9arm", "my-arm", "a")),
             ("version", "1.0", ""), ("email", "nobody", "")],
    "python": [*(("package", name, "") for name in ("My-arm", "class", "9arm", "my--arm", "arm-")),
               ("version", "one", ""), ("version", "1.0+local", "")],
}  # fmt: skip
NAMED = {"sensors": SENSORS, "actuators": ACTUATORS, "motors": MOTORS, "elements": ELEMENTS,
         "attributes": ATTRIBUTES}  # fmt: skip
REFUSED = [
    *(({"scene": value}, f"scene{place}", words) for value, place, words in SCENE),
    *(({key: {"a": value}}, f"{key}.a{place}", words) for key in NAMED for value, place, words in NAMED[key]),
    *(({"export": {name: {key: value}}}, f"export.{name}.{key}", words) for name in FORMATS
      for key, value, words in FORMATS[name]),
]  # fmt: skip


@pytest.mark.parametrize(("keys", "where", "words"), REFUSED, ids=lambda value: str(value)[:50])
def test_bad_values_are_refused_with_place_and_what_is_allowed(keys, where, words):
    with pytest.raises(ConfigError) as caught:
        plan_of(**keys)
    (problem,) = caught.value.problems
    assert problem.where.startswith(where)
    assert words in f"{problem.message} {problem.hint}"


BALLS = robot_with([joint("ball", "base", "arm"), joint("cylindrical", "arm", "rod", name="rod")])


TAKES = "type motor takes forcerange, gear, ctrlrange, gravcomp"


ENDS = "'arm*': ", ", for arm_joint"


UNFIT_ACTUATORS = [
    (both(), {"elbow": "position"}, "E-GLOB", "no joint matches 'elbow'", "arm_joint, lift"),
    (both(), {"lifft": "position"}, "E-GLOB", "no joint matches 'lifft'",
     "did you mean lift? joints are: arm_joint"),
    (both(), {"arm_joint": {"kp": 3}}, "E-ACTUATOR", "'arm_joint' gives no actuator type for arm_joint",
     "motor,"),
    (both(), {"lift": "motor", "li*": {"kp": 3}}, "E-ACTUATOR",
     "'li*' gives kp, which type motor of lift does not have", TAKES),
    (both(), {"*": {"type": "position", "kp": 3}}, "E-ACTUATOR",
     "'*' gives one kp to turns (arm_joint, ...) and slides (lift, ...)", "under its own glob"),
    (both(), {"*": {"type": "motor", "forcerange": [-1, 1]}}, "E-ACTUATOR",
     "'*' gives one forcerange to turns (arm_joint, ...) and slides (lift, ...)", "under its own glob"),
    (BALLS, {"arm_joint": "motor"}, "E-ACTUATOR",
     "'arm_joint' is a ball: an actuator drives one turn or slide", "name one of: rod_slide, rod_turn"),
    (BALLS, {"rod": "motor"}, "E-GLOB", "", "name one of its dofs: rod_slide, rod_turn"),
    (pendulum(), {"arm*": {"type": "dcmotor", "resistance": 2}}, "E-ACTUATOR", *ENDS,
     "type dcmotor needs the constants of its motor", "motorconst and resistance"),
    (pendulum(), {"arm*": {"type": "dcmotor", "resistance": 2, "nominal": [1, 2, 3]}}, "E-ACTUATOR", *ENDS,
     "nominal replaces resistance", "give nominal, or"),
    (pendulum(), {"arm*": {"type": "pid", "imax": 2}}, "E-ACTUATOR", *ENDS,
     "imax limits the integral part, which needs ki", "give ki"),
    (pendulum(), {"arm*": {"type": "motor", "interp": "linear"}}, "E-ACTUATOR", *ENDS, "there is no delay",
     "give delay"),
]  # fmt: skip


UNFIT_SENSORS = [
    ({"imu": "imu"}, "E-FRAME", "imu.frame", "no frame or link 'imu'", "mount"),
    ({"i": {"type": "imu", "frame": "mont"}}, "E-FRAME", "i.frame", "'mont'", "did you mean mount?", "hand"),
    ({"hand": {"type": "frame", "relative_to": "bse"}}, "E-FRAME", "hand.relative_to", "'bse'",
     "did you mean base?"),
    ({"hand": {"type": "camera", "sees": ["ey"]}}, "E-FRAME", "hand.sees", "'ey'", "did you mean eye?"),
    ({"j": {"type": "joint", "joints": "arm_jont"}}, "E-GLOB", "j.joints", "did you mean arm_joint?",
     "eye_joint"),
    ({"a": {"type": "actuator", "actuators": "x*"}}, "E-GLOB", "a.actuators", "no actuator matches 'x*'",
     "none"),
    ({"j": {"type": "joint", "joints": "eye_joint", "measure": ["limit_pos"]}}, "E-SENSOR", "j.joints",
     "eye_joint is a ball", "leave limit_pos out"),
    ({"eye": "touch"}, "E-SENSOR", "eye", "eye has no collider", "size"),
    ({"overview": {"type": "camera", "frame": "hand"}}, "E-SENSOR", "overview", "already", "another name"),
    ({"né": {"type": "imu", "frame": "hand"}}, "E-SENSOR", "né", "invalid name", "ne"),
    ({"a": {"type": "joint", "joints": "arm_joint"}, "a_pos": {"type": "rangefinder", "frame": "hand"}},
     "E-SENSOR", "a_pos", "'a_pos' is there already, from sensors.a"),
]  # fmt: skip


UNFIT = [
    (robot, {"actuators": rows}, code, "actuators", words) for robot, rows, code, *words in UNFIT_ACTUATORS
]
UNFIT += [
    (arm(), {"sensors": rows}, code, f"sensors.{where}", words) for rows, code, where, *words in UNFIT_SENSORS
]


@pytest.mark.parametrize(
    ("robot", "keys", "code", "where", "words"), UNFIT, ids=lambda value: str(value)[:40]
)
def test_entry_that_does_not_fit_the_robot_is_refused(robot, keys, code, where, words):
    with pytest.raises(ExportError) as error:
        exported(robot, solid(robot), **keys)
    (problem,) = error.value.problems
    assert (problem.code, problem.where) == (code, where)
    for word in words:
        assert word in f"{problem.message} {problem.hint}"
