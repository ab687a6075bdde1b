"""Compiles and simulates a bare file in MuJoCo: checks that it compiles, starts without overlaps and open
loops, and stays finite for a second."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from linkwright.stages.formats.meshes.points import STL_FACE, STL_HEADER
from linkwright.stages.formats.xml import parse, to_bytes
from linkwright.stages.mujoco.compile import NotCompiled, compiled_with_warnings, spec_of_mjcf, spec_of_text
from linkwright.stages.mujoco.state import at_keyframe
from linkwright.stages.mujoco.trial import trial_run
from linkwright.stages.mujoco.urdf import prepare_for_inspection
from linkwright.stages.mujoco.warnings import collected_warnings
from linkwright.stages.robot.check import Check, CheckLevel, Finding
from linkwright.stages.robot.model.robot import Array
from linkwright.stages.robot.system.regular_files import is_file
from linkwright.stages.robot.text.plural import count
from linkwright.stages.validate.bare.mjcf_figures import body_name
from linkwright.stages.validate.findings import largest_error, named, unstable
from linkwright.stages.validate.reading.asset_files import referenced_files
from linkwright.stages.validate.reading.documents import ModelDocument
from linkwright.stages.validate.simulate.running import MAX_START_DEPTH, Touching, touching

CONTACT_MEMORY = 128 << 20
"""Memory [bytes] for contacts in the trial of a file that reserves more, or that sets njmax or nconmax as old
files do."""

MAX_ROWS, MAX_MEMORY = 100_000, 64 << 30
"""Largest njmax or nconmax, and largest memory [bytes], of a file that is simulated with `CONTACT_MEMORY`
instead."""

LOOP_TOLERANCE = 1e-3
"""Largest error [m, rad] of a loop at the start. Files have few digits, but with a larger error the loop
jumps when it is simulated."""

SECONDS = 1.0
"""Length of the trial [s]."""

_MUJOCO_MESH_ENDINGS = (".stl", ".obj", ".msh")
"""Extensions of mesh files that MuJoCo reads."""

MAX_TRIANGLES = 200_000
"""Largest number of triangles of an STL that MuJoCo reads."""


@dataclass(frozen=True, slots=True)
class TrialResult:
    """The result of compiling and simulating a document."""

    model: Any
    """The compiled model; None if it does not compile."""

    checks: tuple[Check, ...]
    """The results of the checks."""


def compile_and_simulate(document: ModelDocument) -> TrialResult:
    """Compiles a document in its folder, and simulates it."""
    urdf = document.language == "urdf"
    name = document.path.name
    make_spec = _urdf_spec if urdf else _mjcf_spec
    try:
        model, warnings = compiled_with_warnings(lambda: make_spec(document), document.path.parent)
    except NotCompiled as error:
        message = str(error)
        # A URDF may be correct although MuJoCo cannot read it.
        level: CheckLevel = "warning" if urdf else "error"
        return TrialResult(None, (Check(f"{name}: compiles", False, message, code="C-COMPILE", level=level),))
    texts = sorted(set(warnings))
    detail, number = "; ".join(texts) or "no warnings", float(len(texts))
    checks = [Check(f"{name}: compiles", not texts, detail, number, 0.0, "C-COMPILE", "warning")]
    checks += _simulation_checks(document, model) if model.nv else []
    return TrialResult(model, tuple(checks))


def _mjcf_spec(document: ModelDocument) -> Any:
    """Returns the spec of an MJCF, with less memory for contacts if it reserves gigabytes. Sizes that no
    computer has are kept, so that MuJoCo refuses them."""
    spec = spec_of_mjcf(document.path)
    if max(spec.njmax, spec.nconmax) > MAX_ROWS or spec.memory > MAX_MEMORY:
        return spec
    if spec.memory > CONTACT_MEMORY or max(spec.njmax, spec.nconmax) >= 0:
        spec.njmax = spec.nconmax = spec.nstack = -1
        spec.memory = CONTACT_MEMORY
    return spec


def _urdf_spec(document: ModelDocument) -> Any:
    """Returns MuJoCo's spec of a URDF, without purely visual shapes and without meshes that MuJoCo cannot
    read. Meshes have absolute paths, no links are merged, and floating joints are fixed."""
    root = parse(document.path.read_bytes())
    meshes = (file for file in referenced_files(document) if file.element.tag == "mesh")
    paths = {mesh.element.get("filename"): mesh.path for mesh in meshes}

    def path_of(name: str) -> str | None:
        if not name.strip():
            return name
        path = paths.get(name)
        return str(path.resolve()) if path is not None and is_file(path) and _is_readable(path) else None

    prepare_for_inspection(root, path_of, visuals=False)
    return spec_of_text(to_bytes(root), document.path.resolve().parent)


def _is_readable(mesh: Path) -> bool:
    """Tells whether MuJoCo reads a mesh: a binary STL of at most 200,000 triangles, an OBJ or an MSH."""
    if mesh.suffix.lower() != ".stl":
        return mesh.suffix.lower() in _MUJOCO_MESH_ENDINGS
    with mesh.open("rb") as file:
        head = file.read(STL_HEADER + 4)
    size = mesh.stat().st_size - len(head)
    triangle_count = int.from_bytes(head[STL_HEADER:], "little")
    return triangle_count <= MAX_TRIANGLES and size >= triangle_count * STL_FACE.itemsize


def _simulation_checks(document: ModelDocument, model: Any) -> Iterator[Check]:
    """Yields the results of the start (of an MJCF) and of the trial run."""
    name, urdf = document.path.name, document.language == "urdf"
    level: CheckLevel = "warning" if urdf else "error"
    data = at_keyframe(model)
    with collected_warnings():
        mujoco.mj_forward(model, data)
    # A URDF says neither which links may touch nor where it starts.
    if not urdf:
        yield from _start_checks(name, model, data)
    trial = trial_run(model, SECONDS, np.inf, _pose_within_limits(model) if urdf else None)
    detail = f"simulated for {trial.time:.3g} s without a warning"
    findings: tuple[Finding, ...] = ()
    if trial.failed:
        detail = f"after {trial.time:.3g} s {trial.failed}"
        findings = (unstable(trial.joint, detail),)
    yield Check(f"{name}: trial run", not trial.failed, detail, None, None, "C-TRIAL", level, findings)


def _pose_within_limits(model: Any) -> Array:
    """Returns the positions of a URDF's joints: each as near to zero as its limits allow, and each follower
    where its driver puts it."""
    qpos: Array = model.qpos0.copy()
    for joint in np.flatnonzero(model.jnt_limited):
        address = model.jnt_qposadr[joint]
        qpos[address] = np.clip(qpos[address], *model.jnt_range[joint])
    for equality in np.flatnonzero(model.eq_type == mujoco.mjtEq.mjEQ_JOINT):
        follower, driver = model.jnt_qposadr[[model.eq_obj1id[equality], model.eq_obj2id[equality]]]
        qpos[follower] = np.polynomial.polynomial.polyval(qpos[driver], model.eq_data[equality][:5])
    return qpos


def _start_checks(name: str, model: Any, data: Any) -> Iterator[Check]:
    """Yields the results for the start: whether bodies overlap, and whether loops and relations are
    closed."""
    deep_contacts = tuple(_deep_contacts(model, data))
    detail = f"no contact is deeper than {1000 * MAX_START_DEPTH:g} mm at the start"
    number = float(len(deep_contacts))
    if deep_contacts:
        pairs = f"{count(len(deep_contacts), 'pair')} deeper than {1000 * MAX_START_DEPTH:g} mm"
        detail = f"{pairs}: {_finding_text(deep_contacts[0])}"
    yield Check(f"{name}: start", not deep_contacts, detail, number, 0.0, "C-START", "warning", deep_contacts)
    if model.neq:
        open_equalities = tuple(_open_equalities(model, data))
        detail = f"every loop and relation is closed to {LOOP_TOLERANCE:g} m or rad at the start"
        detail = _finding_text(open_equalities[0]) if open_equalities else detail
        number = float(len(open_equalities))
        yield Check(
            f"{name}: closed", not open_equalities, detail, number, 0.0, "C-CLOSED", "error", open_equalities
        )


def _finding_text(finding: Finding) -> str:
    return f"{finding.element}: {finding.message}"


def _deep_contacts(model: Any, data: Any) -> Iterator[Finding]:
    """Yields the contacts that are too deep at the start."""
    for contact in touching(model, data):
        if contact.depth > MAX_START_DEPTH:
            message = (
                f"it is {1000 * contact.depth:.2g} mm inside {_title_of_other(model, contact)} at the start"
            )
            message += _carrier_hint(model, contact)
            yield Finding(named("body", body_name(model, contact.body)), "pos", message)


def _carrier_hint(model: Any, contact: Touching) -> str:
    """Returns why a body collides with a body that carries it; "" for other contacts."""
    if not contact.other or contact.other not in _carriers(model, contact.body):
        return ""
    # MuJoCo skips such a pair, unless the carrier is fixed to the world.
    is_parent = contact.other == int(model.body_parentid[contact.body])
    relation = "its parent" if is_parent else "to which its parent is fixed"
    return f", {relation}: that body is fixed, so the two collide unless an <exclude> forbids it"


def _carriers(model: Any, body: int) -> Iterator[int]:
    """Yields the body that `body` moves on, and the bodies to which that body is fixed."""
    above = int(model.body_parentid[body])
    while above:
        yield above
        above = 0 if model.body_jntnum[above] else int(model.body_parentid[above])


def _title_of_other(model: Any, contact: Touching) -> str:
    """Returns the name of the other body of a contact, or of the world's geom if it has a name."""
    if contact.other:
        return f'"{body_name(model, contact.other)}"'
    name = model.geom(contact.geom).name
    return f"{named('geom', name)} of the world" if name else '"world"'


def _open_equalities(model: Any, data: Any) -> Iterator[Finding]:
    """Yields the equalities that are open, with their largest error."""
    rows = np.flatnonzero(data.efc_type[: data.nefc] == mujoco.mjtConstraint.mjCNSTR_EQUALITY)
    worst: dict[int, float] = {}
    for row in rows:
        equality = int(data.efc_id[row])
        worst[equality] = largest_error((worst.get(equality, 0.0), abs(float(data.efc_pos[row]))))
    for equality, error in sorted(worst.items(), key=lambda item: -item[1]):
        if error > LOOP_TOLERANCE:
            kind = mujoco.mjtEq(model.eq_type[equality]).name.removeprefix("mjEQ_").lower()
            name = model.equality(equality).name
            title = f'{kind} "{name}"' if name else f"{kind} of equality"
            attribute = {"connect": "anchor", "weld": "relpose", "joint": "polycoef"}.get(kind, "")
            if model.eq_objtype[equality] == mujoco.mjtObj.mjOBJ_SITE:
                attribute = "site2"
            yield Finding(title, attribute, f"it is open by {error:.3g} m or rad at the start")
