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

PLANE = mujoco.mjtGeom.mjGEOM_PLANE

OPTIONS = (
    *("timestep", "integrator", "cone", "impratio", "gravity", "wind", "magnetic", "density", "viscosity"),
    *("solver", "iterations", "tolerance", "noslip_iterations"),
)
"""Attributes of `<option>` that change how a robot moves."""

ENUMS = {"integrator": mujoco.mjtIntegrator, "cone": mujoco.mjtCone, "solver": mujoco.mjtSolver}
"""Options that are words in a file, with MuJoCo's enumerations."""

PREFIX = "mjDSBL_"


def check(compiled: CompiledModel) -> Iterator[Check]:
    """Compares the scene; yields nothing if the robot's scene is unknown. Settings of the user's own XML are
    not compared."""
    if compiled.written.scene is None:
        return
    ground = few(_ground(compiled, compiled.written.scene.ground)) if compiled.written.scene.ground else ()
    detail = "the ground is where the build put it, with its friction"
    if compiled.written.scene.ground is None:
        detail = "the build has no ground"
    yield compiled.within("ground", float(len(ground)), 0.0, _details(detail, ground), ground)
    options = few(_options(compiled, compiled.written.scene))
    detail = "gravity, medium, time step, integrator and solver are those that the robot was judged with"
    yield compiled.within("physics", float(len(options)), 0.0, _details(detail, options), options)


def _details(detail: str, findings: tuple[Finding, ...]) -> str:
    if not findings:
        return detail
    return "; ".join(f"{finding.element} {finding.attribute} {finding.message}" for finding in findings)


def _ground(compiled: CompiledModel, ground: Ground) -> Iterator[Finding]:
    model = compiled.model
    geom = _floor(model, ground)
    if geom is None:
        place = shown(ground.world_from_ground[:3, 3])
        yield Finding(named("geom", FLOOR), "name", f"there is no ground: expected a plane at {place} [m]")
        return
    name = model.geom(geom).name
    title, user_sets = named("geom", name), compiled.sets_of(f"geom {name}")
    if model.geom_type[geom] != PLANE:
        kind = mujoco.mjtGeom(int(model.geom_type[geom])).name.removeprefix("mjGEOM_").lower()
        yield differs(title, "type", kind, "plane")
        return
    height, tilt = _height_and_tilt(model, geom, ground)
    if not abs(height) <= CAD_ERROR and "pos" not in user_sets:
        yield differs(title, "pos", model.geom_pos[geom], ground.world_from_ground[:3, 3], "m")
    if not tilt <= CAD_ERROR and not user_sets & ORIENTATIONS:
        yield Finding(title, "quat", f"is tilted by {shown(np.degrees(tilt))} degrees from the expected")
    if sets_defaults(compiled):
        return
    for attribute in ("contype", "conaffinity"):
        bits = int(getattr(model, f"geom_{attribute}")[geom])
        if bits != 1 and attribute not in user_sets:
            yield differs(title, attribute, bits, 1)
    yield from contact_differences(model, geom, title, ContactProperties(ground.friction), user_sets)


def _floor(model: Any, ground: Ground) -> int | None:
    """Returns the geom of the world that is the ground: a colliding plane at its place, else the geom with
    its name."""
    geoms = [geom for geom in range(model.ngeom) if model.geom_bodyid[geom] == 0]
    named_so = [geom for geom in geoms if model.geom(geom).name == FLOOR]
    planes = (geom for geom in geoms if model.geom_type[geom] == PLANE)
    ground_planes = [
        geom for geom in planes if max(map(abs, _height_and_tilt(model, geom, ground))) <= CAD_ERROR
    ]
    touched = [geom for geom in ground_planes if model.geom_contype[geom] or model.geom_conaffinity[geom]]
    return next(iter((*touched, *named_so, *ground_planes)), None)


def _height_and_tilt(model: Any, geom: int, ground: Ground) -> tuple[float, float]:
    """Returns the height [m] of a plane above the ground, and its tilt [rad]. Shifts along the plane and
    turns about its normal have no effect, since it is infinite."""
    pose = placed(model.geom_quat[geom], model.geom_pos[geom])
    normal, expected = pose[:3, 2], ground.world_from_ground[:3, 2]
    height = float(expected @ (pose[:3, 3] - ground.world_from_ground[:3, 3]))
    tilt = float(np.arctan2(np.linalg.norm(np.cross(normal, expected)), normal @ expected))
    return height, tilt


def _options(compiled: CompiledModel, scene: Scene) -> Iterator[Finding]:
    if any(change.added_tags & {"option", "flag"} for change in compiled.written.amendments.changes):
        return
    options, expected = compiled.model.opt, _expected(scene)
    for attribute in OPTIONS:
        if compiled.sets(attribute) or not hasattr(options, attribute):
            continue
        values = getattr(options, attribute), getattr(expected, attribute)
        if not np.allclose(*values, rtol=ENGINE_TOLERANCE, atol=ENGINE_TOLERANCE * ENGINE_TOLERANCE):
            kind = ENUMS.get(attribute)
            words = (_word(kind, value) for value in values) if kind else values
            yield differs("option", attribute, *words)
    for bit in mujoco.mjtDisableBit.__members__.values():
        flag = bit.name.removeprefix(PREFIX).lower()
        is_off, expected_off = (bool(int(option.disableflags) & int(bit)) for option in (options, expected))
        if bit.name.startswith(PREFIX) and is_off != expected_off and not compiled.sets(flag):
            yield differs(
                "flag", flag, *("disabled" if state else "enabled" for state in (is_off, expected_off))
            )


def _word(kind: Any, value: Any) -> str:
    """Returns the word for the value of an attribute in a file."""
    return str(kind(int(value)).name.split("_", 1)[1]).lower()


def _expected(scene: Scene) -> Any:
    """Returns the options of a model with only the build's options of the scene."""
    root = element(None, "mujoco")
    option = element(root, "option", **{name: _text(value) for name, value in scene.option.items()})
    if scene.flag:
        element(option, "flag", **scene.flag)
    return compiled_text(to_bytes(root), {}).opt


def _text(value: Setting) -> str:
    if isinstance(value, str):
        return value
    return number(value) if isinstance(value, float | int) else spaced(np.array(value))
