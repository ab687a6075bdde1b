"""Checks that the scene has the ground and the physics options with which the robot was judged.

Other content of a scene, such as objects, lights and cameras, is the user's choice.
"""

from collections.abc import Iterator
from typing import Any

import mujoco
import numpy as np

from linkwright.stages.formats.numbers import number, spaced
from linkwright.stages.formats.xml import element, to_bytes
from linkwright.stages.mujoco.compile import compiled_text
from linkwright.stages.robot.check import Check, Finding
from linkwright.stages.robot.model.geom_form import ContactProperties
from linkwright.stages.robot.model.scene import FLOOR, Ground, Scene, Setting
from linkwright.stages.validate.compiled import CompiledModel
from linkwright.stages.validate.findings import differs, few, named, shown
from linkwright.stages.validate.model.contact_attributes import contact_differences, sets_defaults
from linkwright.stages.validate.model.coordinates import CAD_ERROR, ENGINE_TOLERANCE, ORIENTATIONS
from linkwright.stages.validate.model.poses import placed

_PLANE = mujoco.mjtGeom.mjGEOM_PLANE
"""MuJoCo's type of a geom that is a plane."""

_OPTIONS = (
    "timestep",
    "integrator",
    "cone",
    "impratio",
    "gravity",
    "wind",
    "magnetic",
    "density",
    "viscosity",
    "solver",
    "iterations",
    "tolerance",
    "noslip_iterations",
)
"""Attributes of `<option>` that change how a robot moves."""

_ENUMS = {"integrator": mujoco.mjtIntegrator, "cone": mujoco.mjtCone, "solver": mujoco.mjtSolver}
"""Option that is a word in a file → MuJoCo's enumeration of its values."""

_DISABLE_PREFIX = "mjDSBL_"
"""Prefix of the names of MuJoCo's disable flags."""


def check(compiled: CompiledModel) -> Iterator[Check]:
    """Compares the scene; yields nothing if the robot's scene is unknown. Settings of the user's own XML are
    not compared."""
    scene = compiled.written.scene
    if scene is None:
        return
    if scene.ground is None:
        yield _scene_check(compiled, "ground", "the build has no ground", ())
    else:
        ground_text = "the ground is where the build put it, with its friction"
        yield _scene_check(compiled, "ground", ground_text, few(_ground_differences(compiled, scene.ground)))
    physics_text = (
        "gravity, medium, time step, integrator and solver are those with which the robot was judged"
    )
    yield _scene_check(compiled, "physics", physics_text, few(_option_differences(compiled, scene)))


def _scene_check(
    compiled: CompiledModel, name: str, passed_text: str, findings: tuple[Finding, ...]
) -> Check:
    """Returns a check that passes without findings. Its detail is `passed_text`, or all findings."""
    texts = [f"{finding.element} {finding.attribute} {finding.message}" for finding in findings]
    detail = "; ".join(texts) or passed_text
    return compiled.within(name, float(len(findings)), 0.0, detail, findings)


def _ground_differences(compiled: CompiledModel, ground: Ground) -> Iterator[Finding]:
    """Compares the place, the friction and the contact bits of the scene's ground with those of the build."""
    model = compiled.model
    geom = _ground_geom(model, ground)
    if geom is None:
        place = shown(ground.world_from_ground[:3, 3])
        yield Finding(named("geom", FLOOR), "name", f"there is no ground: expected a plane at {place} [m]")
        return
    name = model.geom(geom).name
    title, user_sets = named("geom", name), compiled.sets_of(f"geom {name}")
    if model.geom_type[geom] != _PLANE:
        kind = mujoco.mjtGeom(int(model.geom_type[geom])).name.removeprefix("mjGEOM_").lower()
        yield differs(title, "type", kind, "plane")
        return
    # `not … <=` also reports NaN.
    height, tilt = _height_and_tilt(model, geom, ground)
    if not abs(height) <= CAD_ERROR and "pos" not in user_sets:
        yield differs(title, "pos", model.geom_pos[geom], ground.world_from_ground[:3, 3], "m")
    if not tilt <= CAD_ERROR and not user_sets & ORIENTATIONS:
        yield Finding(
            title, "quat", f"is tilted by {shown(np.degrees(tilt))} degrees from the expected orientation"
        )
    # Defaults of the user's own XML may set the values below.
    if sets_defaults(compiled):
        return
    for attribute in ("contype", "conaffinity"):
        bits = int(getattr(model, f"geom_{attribute}")[geom])
        if bits != 1 and attribute not in user_sets:
            yield differs(title, attribute, bits, 1)
    yield from contact_differences(model, geom, title, ContactProperties(ground.friction), user_sets)


def _ground_geom(model: Any, ground: Ground) -> int | None:
    """Returns the index of the world's geom that is the ground; None if there is no such geom.

    It is the first of these: a plane at the ground's place that collides, the geom with the ground's name, a
    plane at the ground's place that does not collide.
    """
    geoms = [geom for geom in range(model.ngeom) if model.geom_bodyid[geom] == 0]
    with_name = [geom for geom in geoms if model.geom(geom).name == FLOOR]
    planes = (geom for geom in geoms if model.geom_type[geom] == _PLANE)
    at_place = [geom for geom in planes if max(map(abs, _height_and_tilt(model, geom, ground))) <= CAD_ERROR]
    colliding = [geom for geom in at_place if model.geom_contype[geom] or model.geom_conaffinity[geom]]
    return next(iter((*colliding, *with_name, *at_place)), None)


def _height_and_tilt(model: Any, geom: int, ground: Ground) -> tuple[float, float]:
    """Returns the height [m] of a plane above the ground, and its tilt [rad]. Shifts along the plane and
    turns about its normal have no effect, since a plane is infinite."""
    pose = placed(model.geom_quat[geom], model.geom_pos[geom])
    normal, expected = pose[:3, 2], ground.world_from_ground[:3, 2]
    height = float(expected @ (pose[:3, 3] - ground.world_from_ground[:3, 3]))
    tilt = float(np.arctan2(np.linalg.norm(np.cross(normal, expected)), normal @ expected))
    return height, tilt


def _option_differences(compiled: CompiledModel, scene: Scene) -> Iterator[Finding]:
    """Compares MuJoCo's options, and the flags that disable something, with those of the build, unless the
    user's own XML adds an element with options or flags."""
    if any(change.added_tags & {"option", "flag"} for change in compiled.written.amendments.changes):
        return
    options, expected_options = compiled.model.opt, _expected_options(scene)
    for attribute in _OPTIONS:
        # Some options are missing in other versions of MuJoCo.
        if compiled.sets(attribute) or not hasattr(options, attribute):
            continue
        actual, expected = getattr(options, attribute), getattr(expected_options, attribute)
        # The absolute tolerance is far below the smallest settings, such as a solver's tolerance of 1e-8.
        if np.allclose(actual, expected, rtol=ENGINE_TOLERANCE, atol=ENGINE_TOLERANCE**2):
            continue
        enum = _ENUMS.get(attribute)
        if enum:
            actual, expected = _enum_word(enum, actual), _enum_word(enum, expected)
        yield differs("option", attribute, actual, expected)
    for bit in mujoco.mjtDisableBit.__members__.values():
        flag = bit.name.removeprefix(_DISABLE_PREFIX).lower()
        is_off, expected_off = (
            bool(int(option.disableflags) & int(bit)) for option in (options, expected_options)
        )
        # The enumeration also has the number of its flags, without the prefix.
        if bit.name.startswith(_DISABLE_PREFIX) and is_off != expected_off and not compiled.sets(flag):
            words = ("disabled" if off else "enabled" for off in (is_off, expected_off))
            yield differs("flag", flag, *words)


def _enum_word(enum: Any, value: Any) -> str:
    """Returns the word in a file for a value of an enumeration, such as "euler" for mjINT_EULER."""
    return str(enum(int(value)).name.split("_", 1)[1]).lower()


def _expected_options(scene: Scene) -> Any:
    """Returns the options (`mjOption`) of a model with only the build's options and flags of the scene."""
    root = element(None, "mujoco")
    option = element(root, "option", **{name: _setting_text(value) for name, value in scene.option.items()})
    if scene.flag:
        element(option, "flag", **scene.flag)
    return compiled_text(to_bytes(root), {}).opt


def _setting_text(value: Setting) -> str:
    """Returns the text of a setting in an MJCF."""
    if isinstance(value, str):
        return value
    return number(value) if isinstance(value, float | int) else spaced(np.array(value))
