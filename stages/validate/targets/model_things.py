"""Finds, in a compiled model, the things that engines do not take, by the elements of its file."""

from collections.abc import Callable, Collection, Iterator, Mapping
from functools import partial
from typing import Any

import mujoco
import numpy as np

from linkwright.stages.mujoco.names import OBJ, actuator_count, name_of
from linkwright.stages.robot.check import Finding
from linkwright.stages.targets.engines import ENGINES
from linkwright.stages.targets.row import Thing
from linkwright.stages.validate.findings import named
from linkwright.stages.validate.targets.geom_pairs import geom_pairs

_GEOM, _DYN, _GAIN = mujoco.mjtGeom, mujoco.mjtDyn, mujoco.mjtGain
_SENSOR, _OBJECT, _DISABLE = mujoco.mjtSensor, mujoco.mjtObj, mujoco.mjtDisableBit

FindThings = Callable[[Any], Iterator[Finding]]
"""A function that yields a finding on each thing of a kind in a compiled model."""

_CONVEX_OR_SDF = ("BOX", "MESH", "SDF")
"""Shapes that MJX collides as convex meshes or by a signed distance field."""

MAX_CONVEX_PAIRS = 20
"""Number of pairs of convex shapes that JAX compiles in about half a minute."""

MAX_DENSE_DOFS = 60
"""Largest number of degrees of freedom for which MuJoCo Warp takes a dense Jacobian."""

_NETFORCE_REDUCTION = 3
"""Number of the reduction of a contact sensor that sums forces."""

_MISSING_SENSORS = ("JOINTLIMIT", "TENDONLIMIT", "GEOM", "E_", "INSIDESITE", "USER", "PLUGIN")
"""Prefixes of the types of sensors that MJX lacks."""


def _finding_maker(kind: str) -> Callable[[Any, int, str], Finding]:
    """Returns a function that makes a finding on an element of this kind, by its number and attribute. A geom
    without a name is named after its body."""
    objects = {"geom": OBJ.mjOBJ_GEOM, "actuator": OBJ.mjOBJ_ACTUATOR, "sensor": OBJ.mjOBJ_SENSOR}
    objects |= {"body": OBJ.mjOBJ_BODY, "mesh": OBJ.mjOBJ_MESH, "pair": OBJ.mjOBJ_PAIR}

    def finding(model: Any, index: int, attribute: str) -> Finding:
        name = name_of(model, objects[kind], index)
        if not name and kind == "geom":
            body = name_of(model, OBJ.mjOBJ_BODY, int(model.geom_bodyid[index]))
            return Finding(f"geom of {named('body', body)}", attribute, "")
        return Finding(named(kind, name or str(index)), attribute, "")

    return finding


_geom, _actuator, _sensor, _body, _pair = map(_finding_maker, ("geom", "actuator", "sensor", "body", "pair"))


def _touching_geoms(type_name: str, other_type_names: Collection[str]) -> FindThings:
    """Returns a function that finds geoms of a type that may touch a geom of the other types."""

    def find(model: Any) -> Iterator[Finding]:
        own_type = int(getattr(_GEOM, f"mjGEOM_{type_name}"))
        other_types = {int(getattr(_GEOM, f"mjGEOM_{name}")) for name in other_type_names}
        types = model.geom_type
        geoms = set()
        for pair in geom_pairs(model):
            for geom, other in (pair.geoms, pair.geoms[::-1]):
                if types[geom] == own_type and int(types[other]) in other_types:
                    geoms.add(geom)
        return (_geom(model, index, "type") for index in sorted(geoms))

    return find


def _margins(model: Any) -> Iterator[Finding]:
    """Yields the geoms and pairs with a margin whose contacts are with a mesh or a height field."""
    types = {int(_GEOM.mjGEOM_MESH), int(_GEOM.mjGEOM_HFIELD)}
    geoms = set()
    for pair in geom_pairs(model):
        if not types & {int(model.geom_type[geom]) for geom in pair.geoms}:
            continue
        if pair.number is None:
            geoms |= {geom for geom in pair.geoms if model.geom_margin[geom]}
        elif model.pair_margin[pair.number]:
            yield _pair(model, pair.number, "margin")
    yield from (_geom(model, index, "margin") for index in sorted(geoms))


def _large_hulls(model: Any) -> Iterator[Finding]:
    """Yields the meshes of colliders whose hulls have more vertices than MJX takes."""
    max_vertices = ENGINES["mjx"].shapes.max_hull_vertices
    collides = (model.geom_contype | model.geom_conaffinity) != 0
    is_mesh = model.geom_type == int(_GEOM.mjGEOM_MESH)
    meshes = sorted(set(model.geom_dataid[collides & is_mesh].tolist()))
    for mesh in meshes:
        graph = int(model.mesh_graphadr[mesh])
        # The graph of a hull begins with the number of its vertices.
        count = int(model.mesh_graph[graph] if graph >= 0 else model.mesh_vertnum[mesh])
        if max_vertices is not None and count > max_vertices:
            name = name_of(model, OBJ.mjOBJ_MESH, mesh)
            yield Finding(named("mesh", name), "", f"its hull has {count} vertices: ")


def _convex_pairs(model: Any) -> Iterator[Finding]:
    """Yields a finding if MJX collides more than `MAX_CONVEX_PAIRS` pairs of meshes, or of a mesh and a box.
    Pairs of the same meshes count once, since JAX compiles them once."""
    mesh, box = int(_GEOM.mjGEOM_MESH), int(_GEOM.mjGEOM_BOX)
    shapes = {
        geom: (kind, int(model.geom_dataid[geom]) if kind == mesh else -1)
        for geom, kind in enumerate(model.geom_type.tolist())
        if kind in {mesh, box}
    }
    pairs = {
        tuple(sorted(shapes[geom] for geom in pair.geoms))
        for pair in geom_pairs(model)
        if all(geom in shapes for geom in pair.geoms)
    }
    pairs_with_mesh = [pair for pair in pairs if any(kind == mesh for kind, _ in pair)]
    if len(pairs_with_mesh) > MAX_CONVEX_PAIRS:
        yield Finding("worldbody", "", f"{len(pairs_with_mesh)} pairs of hulls may touch: ")


def _frictionless(model: Any) -> Iterator[Finding]:
    """Yields the geoms and pairs whose contacts have no friction, if friction cones are elliptic."""
    if model.opt.cone != int(mujoco.mjtCone.mjCONE_ELLIPTIC):
        return
    geoms = set()
    for pair in geom_pairs(model):
        if pair.number is None:
            if _condim(model, *pair.geoms) == 1:
                geoms.add(pair.geoms[0])
        elif model.pair_dim[pair.number] == 1:
            yield _pair(model, pair.number, "condim")
    yield from (_geom(model, index, "condim") for index in sorted(geoms))


def _condim(model: Any, first: int, second: int) -> int:
    """Returns the dimension of the contact of two geoms: that of the higher priority, else the larger."""
    priorities = model.geom_priority[first], model.geom_priority[second]
    if priorities[0] != priorities[1]:
        return int(model.geom_condim[first if priorities[0] > priorities[1] else second])
    return int(max(model.geom_condim[first], model.geom_condim[second]))


def _actuators(test: Callable[[Any, int], bool], attribute: str = "") -> FindThings:
    """Returns a function that finds the actuators that pass a test of the model and their number."""

    def find(model: Any) -> Iterator[Finding]:
        return (
            _actuator(model, index, attribute) for index in range(actuator_count(model)) if test(model, index)
        )

    return find


def _is(values: Any, index: int, enum: Any, *names: str) -> bool:
    """Tells whether a value is one of the members of an enum of MuJoCo; older versions lack some of them."""
    return int(values[index]) in {int(getattr(enum, name)) for name in names if hasattr(enum, name)}


def _sensors(test: Callable[[Any, int], bool]) -> FindThings:
    """Returns a function that finds the sensors that pass a test of the model and their number."""

    def find(model: Any) -> Iterator[Finding]:
        return (_sensor(model, index, "") for index in range(model.nsensor) if test(model, index))

    return find


def _is_unsupported_contact_sensor(model: Any, index: int) -> bool:
    """Tells whether a sensor is a contact sensor of a site or body, or one that sums forces."""
    if not _is(model.sensor_type, index, _SENSOR, "mjSENS_CONTACT"):
        return False
    kinds = {int(model.sensor_objtype[index]), int(model.sensor_reftype[index])}
    bodies_and_sites = {int(_OBJECT.mjOBJ_SITE), int(_OBJECT.mjOBJ_BODY), int(_OBJECT.mjOBJ_XBODY)}
    return bool(kinds & bodies_and_sites) or int(model.sensor_intprm[index, 1]) == _NETFORCE_REDUCTION


def _is_missing_sensor(model: Any, index: int) -> bool:
    """Tells whether MJX lacks sensors of this type."""
    name = str(_SENSOR(int(model.sensor_type[index])).name).removeprefix("mjSENS_")
    return name.startswith(_MISSING_SENSORS)


def _option(attribute: str, test: Callable[[Any], bool]) -> FindThings:
    """Returns a function that finds an attribute of the options if the options pass a test."""

    def find(model: Any) -> Iterator[Finding]:
        return iter([Finding("option", attribute, "")] if test(model.opt) else [])

    return find


def _flags(field: str, enum: Any, prefix: str, *names: str) -> FindThings:
    """Returns a function that finds the flags of these names that are set in a field of the options. Older
    versions of MuJoCo lack some of them."""

    def find(model: Any) -> Iterator[Finding]:
        bits = int(getattr(model.opt, field))
        for name in names:
            bit = int(getattr(enum, f"{prefix}{name.upper()}", 0))
            if bits & bit:
                yield Finding("flag", name, "")

    return find


def _flexes(model: Any) -> Iterator[Finding]:
    return (
        Finding(named("flex", name_of(model, OBJ.mjOBJ_FLEX, index)), "", "") for index in range(model.nflex)
    )


def _plugins(model: Any) -> Iterator[Finding]:
    """Yields the bodies, actuators and sensors that have a plug-in."""
    body_plugins = getattr(model, "body_plugin", np.full(model.nbody, -1))
    yield from (_body(model, index, "plugin") for index in np.flatnonzero(body_plugins >= 0).tolist())
    yield from (_actuator(model, index, "") for index in np.flatnonzero(model.actuator_plugin >= 0).tolist())
    yield from (_sensor(model, index, "") for index in np.flatnonzero(model.sensor_plugin >= 0).tolist())


def _sleep_policies(model: Any) -> Iterator[Finding]:
    """Yields the bodies for which the file sets a policy of sleep."""
    enum = getattr(mujoco, "mjtSleepPolicy", None)
    if enum is None or not hasattr(model, "tree_sleep_policy"):
        return
    automatic = {int(getattr(enum, f"mjSLEEP_{name}")) for name in ("AUTO", "AUTO_NEVER", "AUTO_ALLOWED")}
    for tree in range(model.ntree):
        if int(model.tree_sleep_policy[tree]) not in automatic:
            yield _body(model, int(model.tree_bodyadr[tree]), "sleep")


def _dense_jacobian(model: Any) -> Iterator[Finding]:
    """Yields a finding if a model with more than `MAX_DENSE_DOFS` has a dense Jacobian."""
    if model.nv > MAX_DENSE_DOFS and model.opt.jacobian == int(mujoco.mjtJacobian.mjJAC_DENSE):
        yield Finding("option", "jacobian", "")


def _sleeps_without_newton(opt: Any) -> bool:
    sleep = int(getattr(mujoco.mjtEnableBit, "mjENBL_SLEEP", 0))
    return bool(opt.enableflags & sleep) and opt.solver != int(mujoco.mjtSolver.mjSOL_NEWTON)


def _flexes_that_mjwarp_lacks(model: Any) -> Iterator[Finding]:
    """Yields flexes that are rigid, quadratic, or interpolated and in contact with themselves."""
    for index in range(model.nflex):
        # 0: no interpolation, 1: trilinear, 2: quadratic.
        interpolation = abs(int(model.flex_interp[index]))
        may_touch_itself = bool(model.flex_contype[index] & model.flex_conaffinity[index])
        self_collides = interpolation and may_touch_itself and model.flex_selfcollide[index]
        if model.flex_rigid[index] or interpolation == 2 or self_collides:
            yield Finding(named("flex", name_of(model, OBJ.mjOBJ_FLEX, index)), "", "")


_enabled = partial(_flags, "enableflags", mujoco.mjtEnableBit, "mjENBL_")
_INTEGRATOR = mujoco.mjtIntegrator

MODEL_FINDERS: Mapping[Thing, FindThings] = {
    "adhesion and slider-cranks": _actuators(
        lambda m, i: _is(m.actuator_trntype, i, mujoco.mjtTrn, "mjTRN_BODY", "mjTRN_SLIDERCRANK")
    ),
    "contact sensors of sites, bodies and net forces": _sensors(_is_unsupported_contact_sensor),
    "cylinders": _touching_geoms("CYLINDER", _CONVEX_OR_SDF),
    "dense Jacobian of more than 60 speeds": _dense_jacobian,
    "delays of actuators": _actuators(
        lambda m, i: bool(getattr(m, "actuator_delay", np.zeros(actuator_count(m)))[i]), "delay"
    ),
    "disabled midphase or autoreset": _flags("disableflags", _DISABLE, "mjDSBL_", "midphase", "autoreset"),
    "ellipsoids": _touching_geoms("ELLIPSOID", _CONVEX_OR_SDF),
    "flags of the solver": _enabled("override", "diagexact", "speculative"),
    "flag energy": _enabled("energy"),
    "flag fwdinv": _enabled("fwdinv"),
    "flag ipc": _enabled("ipc"),
    "flexes": _flexes,
    "fluid with implicitfast": _option(
        "density",
        lambda opt: (
            opt.integrator == int(_INTEGRATOR.mjINT_IMPLICITFAST)
            and bool(opt.density > 0 or opt.viscosity > 0 or np.any(opt.wind))
        ),
    ),
    "frictionless contacts in elliptic cones": _frictionless,
    "height fields": _touching_geoms("HFIELD", ("CYLINDER", "ELLIPSOID", "SDF")),
    "hulls of more than 32 vertices": _large_hulls,
    "implicit integrator": _option(
        "integrator", lambda opt: opt.integrator == int(_INTEGRATOR.mjINT_IMPLICIT)
    ),
    "many pairs of convex shapes": _convex_pairs,
    "margins of meshes": _margins,
    "motors by voltage": _actuators(lambda m, i: _is(m.actuator_gaintype, i, _GAIN, "mjGAIN_DCMOTOR")),
    "noslip iterations": _option("noslip_iterations", lambda opt: opt.noslip_iterations > 0),
    "noslip iterations of the discrete integrator": _option(
        "noslip_iterations",
        lambda opt: (
            opt.noslip_iterations > 0 and opt.integrator == getattr(_INTEGRATOR, "mjINT_DISCRETE", -1)
        ),
    ),
    "orientation servos": _actuators(lambda m, i: _is(m.actuator_trntype, i, mujoco.mjtTrn, "mjTRN_SO3")),
    "pid servos": _actuators(lambda m, i: _is(m.actuator_gaintype, i, _GAIN, "mjGAIN_PID")),
    "plug-ins": _plugins,
    "rigid, quadratic and self-colliding flexes": _flexes_that_mjwarp_lacks,
    "sensors of distances, limits and energies": _sensors(_is_missing_sensor),
    "signed distance fields": _touching_geoms("SDF", ("PLANE", "SPHERE", "CAPSULE", "BOX", "MESH", "SDF")),
    "sleep of another solver than Newton": _option("solver", _sleeps_without_newton),
    "sleep policies": _sleep_policies,
    "solver PGS": _option("solver", lambda opt: opt.solver == int(mujoco.mjtSolver.mjSOL_PGS)),
    "user actuators": _actuators(
        lambda m, i: (
            _is(m.actuator_dyntype, i, _DYN, "mjDYN_USER")
            or _is(m.actuator_gaintype, i, _GAIN, "mjGAIN_USER")
            or _is(m.actuator_biastype, i, mujoco.mjtBias, "mjBIAS_USER")
        )
    ),
}
"""Thing → function that finds such elements of a model. The message of a finding adds details."""
