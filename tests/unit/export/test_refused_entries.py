"""Entries of `actuators` and `sensors` that do not fit the robot are refused, with what it has."""

import pytest

from linkwright.stages.robot.errors import ExportError
from tests.support.building import solid
from tests.support.exports import exported
from tests.support.pendulums import both, pendulum
from tests.support.robots import joint, robot_with
from tests.unit.export.test_sensors import arm

BALLS = robot_with([joint("ball", "base", "arm"), joint("cylindrical", "arm", "rod", name="rod")])
TAKES = "type motor takes forcerange, gear, ctrlrange, gravcomp"
ENDS = "'arm*': ", ", for arm_joint"
ACTUATORS = [
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
SENSORS = [
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
REFUSED = [
    *(
        (robot, {"actuators": entries}, code, "actuators", words)
        for robot, entries, code, *words in ACTUATORS
    ),
    *(
        (arm(), {"sensors": entries}, code, f"sensors.{where}", words)
        for entries, code, where, *words in SENSORS
    ),
]


@pytest.mark.parametrize(
    ("robot", "keys", "code", "where", "words"), REFUSED, ids=lambda value: str(value)[:40]
)
def test_an_entry_that_does_not_fit_the_robot_is_refused(robot, keys, code, where, words):
    with pytest.raises(ExportError) as error:
        exported(robot, solid(robot), **keys)
    (problem,) = error.value.problems
    assert (problem.code, problem.where) == (code, where)
    for word in words:
        assert word in f"{problem.message} {problem.hint}"
