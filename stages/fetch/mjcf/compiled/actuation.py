"""Converts actuators and sensors of a model that MuJoCo compiled."""

from collections.abc import Collection, Mapping
from typing import Any

import mujoco

from linkwright.stages.formats.mjcf.model import MjcfActuator, MjcfSensor, MjcfSensorEnd
from linkwright.stages.formats.numbers import exact
from linkwright.stages.mujoco.elements import actuator_attributes
from linkwright.stages.mujoco.names import controls_of, name_of
from linkwright.stages.mujoco.sensors import sensor_attributes

_SCALAR_JOINTS = (mujoco.mjtJoint.mjJNT_HINGE, mujoco.mjtJoint.mjJNT_SLIDE)

_WORDS_OF_ATTRIBUTES: Mapping[str, tuple[str, Mapping[str, str]]] = {
    "gaintype": ("mjtGain", {"mjGAIN_FIXED": "fixed", "mjGAIN_AFFINE": "affine"}),
    "biastype": ("mjtBias", {"mjBIAS_NONE": "none", "mjBIAS_AFFINE": "affine"}),
    "dyntype": (
        "mjtDyn",
        {
            "mjDYN_NONE": "none",
            "mjDYN_INTEGRATOR": "integrator",
            "mjDYN_FILTER": "filter",
            "mjDYN_FILTEREXACT": "filterexact",
        },
    ),
}
"""The attributes whose values are words, with the words that every MuJoCo version knows. Muscles, plug-ins
and the motors of later versions are left out."""

_DEFAULT_PARAMETERS: Mapping[str, tuple[float, ...]] = {"gainprm": (1.0,), "biasprm": (), "dynprm": (1.0,)}
"""Parameters of a general actuator → MuJoCo's defaults, without the zeros at the end."""


def carried_actuators(model: Any, robot_bodies: Collection[int]) -> tuple[int, ...]:
    """Returns the numbers of the actuators that our model can have: those of hinges and slides of the bodies
    `robot_bodies`, of a known type, with a gear other than 0."""
    return tuple(
        index for index in range(len(model.actuator_trntype)) if _is_carried_over(model, index, robot_bodies)
    )


def _is_carried_over(model: Any, index: int, robot_bodies: Collection[int]) -> bool:
    if int(model.actuator_trntype[index]) not in (
        mujoco.mjtTrn.mjTRN_JOINT,
        mujoco.mjtTrn.mjTRN_JOINTINPARENT,
    ):
        return False
    joint = int(model.actuator_trnid[index][0])
    has_known_words = all(_word(model, index, name) is not None for name in _WORDS_OF_ATTRIBUTES)
    return (
        has_known_words
        # Without a gear no control would hold the joint.
        and float(model.actuator_gear[index][0]) != 0.0
        and int(model.jnt_type[joint]) in _SCALAR_JOINTS
        and int(model.jnt_bodyid[joint]) in robot_bodies
    )


def _word(model: Any, index: int, attribute: str) -> str | None:
    kind, words = _WORDS_OF_ATTRIBUTES[attribute]
    return words.get(getattr(mujoco, kind)(int(getattr(model, f"actuator_{attribute}")[index])).name)


def actuator(model: Any, index: int, order: Mapping[int, int]) -> MjcfActuator:
    """Converts an actuator. `order`: MuJoCo's number of a joint → its number in our model."""
    words = {name: _word(model, index, name) or "" for name in _WORDS_OF_ATTRIBUTES}
    parameters = {name: _trimmed(getattr(model, f"actuator_{name}")[index]) for name in _DEFAULT_PARAMETERS}
    kind, kp, kv = _shortcut(words, parameters)
    terms = () if kind != "general" else _terms(model, index, words, parameters)
    return MjcfActuator(
        name=name_of(model, mujoco.mjtObj.mjOBJ_ACTUATOR, index),
        joint=order[int(model.actuator_trnid[index][0])],
        type=kind,
        gear=float(model.actuator_gear[index][0]),
        kp=kp,
        kv=kv,
        control=_range(model, controls_of(model, index).start, "ctrl"),
        force=_range(model, index, "force"),
        terms=terms,
        attributes=actuator_attributes(model, index),
    )


def _shortcut(
    words: Mapping[str, str], numbers: Mapping[str, tuple[float, ...]]
) -> tuple[str, float | None, float | None]:
    """Returns the shortcut of MJCF (motor, position, velocity) that has these parameters, else "general";
    with its kp and kv."""
    gain, bias = numbers["gainprm"], (*numbers["biasprm"], 0.0, 0.0, 0.0)
    is_plain = words["dyntype"] == "none" and words["gaintype"] == "fixed" and len(gain) == 1
    if is_plain and words["biastype"] == "none" and gain == (1.0,):
        return "motor", None, None
    if is_plain and words["biastype"] == "affine" and bias[0] == 0 and not any(bias[3:]) and gain[0] > 0:
        if bias[1] == -gain[0] and bias[2] <= 0:
            return "position", gain[0], -bias[2] + 0.0
        if bias[1] == 0 and bias[2] == -gain[0]:
            return "velocity", None, gain[0]
    return "general", None, None


def _terms(
    model: Any, index: int, words: Mapping[str, str], numbers: Mapping[str, tuple[float, ...]]
) -> tuple[tuple[str, str], ...]:
    terms = [(name, words[name]) for name in ("dyntype", "gaintype", "biastype")]
    for name in ("dynprm", "gainprm", "biasprm"):
        # Nothing but zeros must be written too where MuJoCo's default is another number.
        if numbers[name] or _DEFAULT_PARAMETERS[name]:
            terms.append((name, exact(numbers[name] or (0.0,))))
    if model.actuator_actlimited[index]:
        terms.append(("actrange", exact(tuple(float(end) for end in model.actuator_actrange[index]))))
    if model.actuator_actearly[index]:
        terms.append(("actearly", "true"))
    return tuple(terms)


def _trimmed(values: Any) -> tuple[float, ...]:
    """Returns the numbers without the zeros at the end."""
    numbers = [float(value) for value in values]
    while numbers and numbers[-1] == 0:
        numbers.pop()
    return tuple(numbers)


def _range(model: Any, index: int, name: str) -> tuple[float, float] | None:
    if not getattr(model, f"actuator_{name}limited")[index]:
        return None
    low, high = (float(end) for end in getattr(model, f"actuator_{name}range")[index])
    return low, high


_PLAIN_SENSORS = (
    *("touch", "accelerometer", "velocimeter", "gyro", "force", "torque", "magnetometer", "rangefinder"),
    *("jointpos", "jointvel", "jointactuatorfrc", "jointlimitpos", "jointlimitvel", "jointlimitfrc"),
    *("ballquat", "ballangvel", "actuatorpos", "actuatorvel", "actuatorfrc"),
    *("framepos", "framequat", "framexaxis", "frameyaxis", "framezaxis", "framelinvel", "frameangvel"),
    *("framelinacc", "frameangacc", "subtreecom", "subtreelinvel", "subtreeangmom"),
    *("e_potential", "e_kinetic", "clock"),
)
"""Sensors that are carried over: those on joints, actuators, sites and bodies."""

_ELEMENT_NAMES = {"jointactfrc": "jointactuatorfrc"}
"""Name in MuJoCo's code → name of the element in an MJCF, if they differ."""

_OBJECTS: Mapping[int, str] = {
    mujoco.mjtObj.mjOBJ_UNKNOWN: "",
    mujoco.mjtObj.mjOBJ_JOINT: "joint",
    mujoco.mjtObj.mjOBJ_ACTUATOR: "actuator",
    mujoco.mjtObj.mjOBJ_SITE: "site",
    mujoco.mjtObj.mjOBJ_BODY: "body",
    mujoco.mjtObj.mjOBJ_XBODY: "xbody",
}

Numbers = Mapping[str, Mapping[int, int]]
"""Kind of object → MuJoCo's numbers of the objects that are carried over → ours."""


def sensor(model: Any, index: int, numbers: Numbers) -> MjcfSensor | None:
    """Converts a sensor; returns None if the sensor, or its object, is not carried over."""
    name_in_code = mujoco.mjtSensor(int(model.sensor_type[index])).name.removeprefix("mjSENS_").lower()
    kind = _ELEMENT_NAMES.get(name_in_code, name_in_code)
    target = _end(int(model.sensor_objtype[index]), int(model.sensor_objid[index]), numbers)
    reference = _end(int(model.sensor_reftype[index]), int(model.sensor_refid[index]), numbers)
    # A rangefinder may give more than a distance.
    has_vector_output = kind == "rangefinder" and int(model.sensor_intprm[index][0]) not in (0, 1)
    if kind not in _PLAIN_SENSORS or target is None or reference is None or has_vector_output:
        return None
    return MjcfSensor(
        name=name_of(model, mujoco.mjtObj.mjOBJ_SENSOR, index),
        type=kind,
        on=target,
        relative_to=reference,
        noise=float(model.sensor_noise[index]),
        cutoff=float(model.sensor_cutoff[index]),
        attributes=sensor_attributes(model, index),
        **(_zone(model, int(model.sensor_objid[index])) if kind == "touch" else {}),
    )


def _zone(model: Any, site: int) -> dict[str, Any]:
    """Returns the shape of a site, and its full sizes: MuJoCo stores half sizes."""
    shape = mujoco.mjtGeom(int(model.site_type[site])).name.removeprefix("mjGEOM_").lower()
    half = [float(length) for length in model.site_size[site]]
    if shape == "sphere":
        return {"shape": shape, "size": (half[0],)}
    if shape in ("capsule", "cylinder"):
        return {"shape": shape, "size": (half[0], 2 * half[1])}
    return {"shape": shape, "size": tuple(2 * length for length in half)}


def _end(kind: int, number: int, numbers: Numbers) -> MjcfSensorEnd | None:
    word = _OBJECTS.get(kind)
    if word is None:
        return None
    if not word or number < 0:
        return MjcfSensorEnd("", -1)
    our_number = numbers.get(word, {}).get(number)
    return None if our_number is None else MjcfSensorEnd(word, our_number)
