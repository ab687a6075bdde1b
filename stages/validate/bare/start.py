"""A bare file in MuJoCo: whether it compiles, how it starts, and whether a second of it stays finite."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from linkwright.stages.formats.meshes.points import STL_FACE, STL_HEADER
from linkwright.stages.formats.xml import parse, to_bytes
from linkwright.stages.mujoco.compile import NotCompiled, compiled_heard, spec_of_mjcf, spec_of_text
from linkwright.stages.mujoco.state import at_keyframe
from linkwright.stages.mujoco.trial import trial_run
from linkwright.stages.mujoco.urdf import with_every_link
from linkwright.stages.mujoco.warnings import listening
from linkwright.stages.robot.check import Check, CheckLevel, Finding
from linkwright.stages.robot.model.robot import Array
from linkwright.stages.robot.system.regular_files import is_file
from linkwright.stages.robot.text.plural import count
from linkwright.stages.validate.bare.mjcf_figures import body_name
from linkwright.stages.validate.findings import named, unstable
from linkwright.stages.validate.reading.asset_files import named_files
from linkwright.stages.validate.reading.documents import ModelDocument
from linkwright.stages.validate.simulate.running import DEEP, Touching, touching

ROOM = 128 << 20
"""Memory [bytes] for contacts in the trial, where a file reserves more, or counts rows as old files do."""

MOST_ROWS, MOST_ROOM = 100_000, 64 << 30
"""Rows of contacts, and memory [bytes], that a file of a robot may reserve."""

OPEN = 1e-3
"""A loop that is open by more [m, rad] at the start jumps when it is simulated: files have few digits."""

SECONDS = 1.0
"""The length of the trial."""

_READ_BY_MUJOCO = (".stl", ".obj", ".msh")

MOST_TRIANGLES = 200_000
"""Of an STL that MuJoCo reads."""


@dataclass(frozen=True, slots=True)
class Started:
    """`model`: the compiled model, None where there is none; `checks`: what was found on the way."""

    model: Any
    checks: tuple[Check, ...]


def start(document: ModelDocument) -> Started:
    """Compiles a document as it lies, and simulates it."""
    urdf = document.language == "urdf"
    name = document.path.name
    spec = _of_urdf if urdf else _of_mjcf
    try:
        model, warnings = compiled_heard(lambda: spec(document), document.path.parent)
    except NotCompiled as error:
        message = str(error)
        # A URDF may be right, and still not be for MuJoCo.
        level: CheckLevel = "warning" if urdf else "error"
        return Started(None, (Check(f"{name}: compiles", False, message, code="C-COMPILE", level=level),))
    heard = sorted(set(warnings))
    checks = [
        Check(
            f"{name}: compiles",
            not heard,
            "; ".join(heard) or "no warnings",
            float(len(heard)),
            0.0,
            "C-COMPILE",
            "warning",
        )
    ]
    checks += _simulated(document, model) if model.nv else []
    return Started(model, tuple(checks))


def _of_mjcf(document: ModelDocument) -> Any:
    """The MJCF with less room for contacts where it reserves gigabytes; what no computer has stays."""
    spec = spec_of_mjcf(document.path)
    if max(spec.njmax, spec.nconmax) > MOST_ROWS or spec.memory > MOST_ROOM:
        return spec
    if spec.memory > ROOM or max(spec.njmax, spec.nconmax) >= 0:
        spec.njmax = spec.nconmax = spec.nstack = -1
        spec.memory = ROOM
    return spec


def _of_urdf(document: ModelDocument) -> Any:
    """The URDF as MuJoCo reads URDFs, without what is only seen: each mesh by its own path, without meshes
    that MuJoCo cannot read, with every link, and with joints that float fixed."""
    root = parse(document.path.read_bytes())
    meshes = (one for one in named_files(document) if one.element.tag == "mesh")
    paths = {one.element.get("filename"): one.path for one in meshes}

    def place_of(name: str) -> str | None:
        if not name.strip():
            return name
        path = paths.get(name)
        return str(path.resolve()) if path is not None and is_file(path) and _is_read(path) else None

    with_every_link(root, place_of, visuals=False)
    return spec_of_text(to_bytes(root), document.path.resolve().parent)


def _is_read(mesh: Path) -> bool:
    """Whether MuJoCo reads a mesh: a binary STL of at most 200,000 triangles, an OBJ or an MSH."""
    if mesh.suffix.lower() != ".stl":
        return mesh.suffix.lower() in _READ_BY_MUJOCO
    with mesh.open("rb") as file:
        head = file.read(STL_HEADER + 4)
    size = mesh.stat().st_size - len(head)
    count = int.from_bytes(head[STL_HEADER:], "little")
    return count <= MOST_TRIANGLES and size >= count * STL_FACE.itemsize


def _simulated(document: ModelDocument, model: Any) -> Iterator[Check]:
    name, urdf = document.path.name, document.language == "urdf"
    level: CheckLevel = "warning" if urdf else "error"
    data = at_keyframe(model)
    with listening():
        mujoco.mj_forward(model, data)
    # A URDF says neither which links may touch nor where it starts.
    yield from () if urdf else _first_moment(name, model, data)
    trial = trial_run(model, SECONDS, np.inf, _within_limits(model) if urdf else None)
    detail = f"simulated for {trial.time:.3g} s without a warning"
    tried: tuple[Finding, ...] = ()
    if trial.failed:
        detail = f"after {trial.time:.3g} s {trial.failed}"
        tried = (unstable(trial.joint, detail),)
    yield Check(f"{name}: trial run", not trial.failed, detail, None, None, "C-TRIAL", level, tried)


def _within_limits(model: Any) -> Array:
    """The positions next to zero of the joints of a URDF within their limits, with what follows another."""
    qpos: Array = model.qpos0.copy()
    for joint in np.flatnonzero(model.jnt_limited):
        at = model.jnt_qposadr[joint]
        qpos[at] = np.clip(qpos[at], *model.jnt_range[joint])
    for equality in np.flatnonzero(model.eq_type == mujoco.mjtEq.mjEQ_JOINT):
        follower, driver = model.jnt_qposadr[[model.eq_obj1id[equality], model.eq_obj2id[equality]]]
        qpos[follower] = np.polynomial.polynomial.polyval(qpos[driver], model.eq_data[equality][:5])
    return qpos


def _first_moment(name: str, model: Any, data: Any) -> Iterator[Check]:
    deep = tuple(_deep(model, data))
    detail = f"nothing is deeper than {1000 * DEEP:g} mm inside another thing at the start"
    if deep:
        detail = f"{count(len(deep), 'pair')} deeper than {1000 * DEEP:g} mm: {_words(deep[0])}"
    yield Check(f"{name}: start", not deep, detail, float(len(deep)), 0.0, "C-START", "warning", deep)
    if model.neq:
        opened = tuple(_opened(model, data))
        detail = f"every loop and relation is closed to {OPEN:g} m or rad at the start"
        detail = _words(opened[0]) if opened else detail
        number = float(len(opened))
        yield Check(f"{name}: closed", not opened, detail, number, 0.0, "C-CLOSED", "error", opened)


def _words(finding: Finding) -> str:
    return f"{finding.element}: {finding.message}"


def _deep(model: Any, data: Any) -> Iterator[Finding]:
    for one in touching(model, data):
        if one.depth > DEEP:
            message = f"it is {1000 * one.depth:.2g} mm inside {_inside(model, one)} at the start"
            if one.other and one.other in _carriers(model, one.body):
                # Else MuJoCo leaves the pair out.
                message += ", on which it moves: that is fixed, so they collide without an <exclude>"
            yield Finding(named("body", body_name(model, one.body)), "pos", message)


def _carriers(model: Any, body: int) -> Iterator[int]:
    """The body that another moves on, and what that is fixed to."""
    above = int(model.body_parentid[body])
    while above:
        yield above
        above = 0 if model.body_jntnum[above] else int(model.body_parentid[above])


def _inside(model: Any, one: Touching) -> str:
    """A body by its name, and of the world the geom, where it has one."""
    if one.other:
        return f'"{body_name(model, one.other)}"'
    name = model.geom(one.geom).name
    return f"{named('geom', name)} of the world" if name else '"world"'


def _opened(model: Any, data: Any) -> Iterator[Finding]:
    """Equalities that are open, by their largest error."""
    rows = np.flatnonzero(data.efc_type[: data.nefc] == mujoco.mjtConstraint.mjCNSTR_EQUALITY)
    worst: dict[int, float] = {}
    for row in rows:
        equality = int(data.efc_id[row])
        worst[equality] = max(worst.get(equality, 0.0), abs(float(data.efc_pos[row])))
    for equality, error in sorted(worst.items(), key=lambda item: -item[1]):
        if error > OPEN:
            kind = mujoco.mjtEq(model.eq_type[equality]).name.removeprefix("mjEQ_").lower()
            name = model.equality(equality).name
            called = f'{kind} "{name}"' if name else f"{kind} of equality"
            attribute = {"connect": "anchor", "weld": "relpose", "joint": "polycoef"}.get(kind, "")
            if model.eq_objtype[equality] == mujoco.mjtObj.mjOBJ_SITE:
                attribute = "site2"
            yield Finding(called, attribute, f"it is open by {error:.3g} m or rad at the start")
