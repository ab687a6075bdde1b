"""The scene is the one that the robot was judged in: its ground, and what MuJoCo is told of physics.

Whatever else is put into it, as objects, lights and cameras, is the user's.
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
from linkwright.stages.validate.model.coordinates import CAD_ERROR, SAME, TURNS
from linkwright.stages.validate.model.poses import placed

PLANE = mujoco.mjtGeom.mjGEOM_PLANE

OPTIONS = (
    *("timestep", "integrator", "cone", "impratio", "gravity", "wind", "magnetic", "density", "viscosity"),
    *("solver", "iterations", "tolerance", "noslip_iterations"),
)
"""Attributes of `<option>` by which a robot moves otherwise."""

ENUMS = {"integrator": mujoco.mjtIntegrator, "cone": mujoco.mjtCone, "solver": mujoco.mjtSolver}
"""Those that are words in a file."""

PREFIX = "mjDSBL_"


def check(compiled: CompiledModel) -> Iterator[Check]:
    """Of a robot whose scene is known, but for what the user's own XML sets."""
    if compiled.written.scene is None:
        return
    ground = few(_ground(compiled, compiled.written.scene.ground)) if compiled.written.scene.ground else ()
    detail = "the ground is where the build put it, with its friction"
    if compiled.written.scene.ground is None:
        detail = "the build has no ground"
    yield compiled.within("ground", float(len(ground)), 0.0, _said(detail, ground), ground)
    options = few(_options(compiled, compiled.written.scene))
    detail = "gravity, medium, time step, integrator and solver are those that the robot was judged with"
    yield compiled.within("physics", float(len(options)), 0.0, _said(detail, options), options)


def _said(detail: str, findings: tuple[Finding, ...]) -> str:
    if not findings:
        return detail
    return "; ".join(f"{one.element} {one.attribute} {one.message}" for one in findings)


def _ground(compiled: CompiledModel, ground: Ground) -> Iterator[Finding]:
    model = compiled.model
    geom = _floor(model, ground)
    if geom is None:
        place = shown(ground.world_from_ground[:3, 3])
        yield Finding(named("geom", FLOOR), "name", f"there is no ground: expected a plane at {place} [m]")
        return
    called = model.geom(geom).name
    what, own = named("geom", called), compiled.sets_of(f"geom {called}")
    if model.geom_type[geom] != PLANE:
        kind = mujoco.mjtGeom(int(model.geom_type[geom])).name.removeprefix("mjGEOM_").lower()
        yield differs(what, "type", kind, "plane")
        return
    height, tilt = _off(model, geom, ground)
    if not abs(height) <= CAD_ERROR and "pos" not in own:
        yield differs(what, "pos", model.geom_pos[geom], ground.world_from_ground[:3, 3], "m")
    if not tilt <= CAD_ERROR and not own & TURNS:
        yield Finding(what, "quat", f"is tilted by {shown(np.degrees(tilt))} degrees from the expected")
    if sets_defaults(compiled):
        return
    for attribute in ("contype", "conaffinity"):
        found = int(getattr(model, f"geom_{attribute}")[geom])
        if found != 1 and attribute not in own:
            yield differs(what, attribute, found, 1)
    yield from contact_differences(model, geom, what, ContactProperties(ground.friction), own)


def _floor(model: Any, ground: Ground) -> int | None:
    """The geom of the world that is the ground: a plane in its place that is touched, else by its name."""
    geoms = [geom for geom in range(model.ngeom) if model.geom_bodyid[geom] == 0]
    named_so = [geom for geom in geoms if model.geom(geom).name == FLOOR]
    planes = (geom for geom in geoms if model.geom_type[geom] == PLANE)
    there = [geom for geom in planes if max(map(abs, _off(model, geom, ground))) <= CAD_ERROR]
    touched = [geom for geom in there if model.geom_contype[geom] or model.geom_conaffinity[geom]]
    return next(iter((*touched, *named_so, *there)), None)


def _off(model: Any, geom: int, ground: Ground) -> tuple[float, float]:
    """How high [m] a plane is above the ground, and its tilt [rad]: a plane has no end, so that where it is
    along itself, and how it is turned about its normal, means nothing."""
    found = placed(model.geom_quat[geom], model.geom_pos[geom])
    normal, expected = found[:3, 2], ground.world_from_ground[:3, 2]
    height = float(expected @ (found[:3, 3] - ground.world_from_ground[:3, 3]))
    tilt = float(np.arctan2(np.linalg.norm(np.cross(normal, expected)), normal @ expected))
    return height, tilt


def _options(compiled: CompiledModel, scene: Scene) -> Iterator[Finding]:
    if any(one.added_tags & {"option", "flag"} for one in compiled.written.amendments.changes):
        return
    found, expected = compiled.model.opt, _expected(scene)
    for attribute in OPTIONS:
        if compiled.sets(attribute) or not hasattr(found, attribute):
            continue
        values = getattr(found, attribute), getattr(expected, attribute)
        if not np.allclose(*values, rtol=SAME, atol=SAME * SAME):
            kind = ENUMS.get(attribute)
            words = (_word(kind, one) for one in values) if kind else values
            yield differs("option", attribute, *words)
    for bit in mujoco.mjtDisableBit.__members__.values():
        flag = bit.name.removeprefix(PREFIX).lower()
        off, wanted = (bool(int(one.disableflags) & int(bit)) for one in (found, expected))
        if bit.name.startswith(PREFIX) and off != wanted and not compiled.sets(flag):
            yield differs("flag", flag, *("disabled" if one else "enabled" for one in (off, wanted)))


def _word(kind: Any, value: Any) -> str:
    """The value of an attribute that is a word in a file."""
    return str(kind(int(value)).name.split("_", 1)[1]).lower()


def _expected(scene: Scene) -> Any:
    """The options of a model that is told what the build told MuJoCo, and nothing else."""
    root = element(None, "mujoco")
    option = element(root, "option", **{name: _text(value) for name, value in scene.option.items()})
    if scene.flag:
        element(option, "flag", **scene.flag)
    return compiled_text(to_bytes(root), {}).opt


def _text(value: Setting) -> str:
    if isinstance(value, str):
        return value
    return number(value) if isinstance(value, float | int) else spaced(np.array(value))
