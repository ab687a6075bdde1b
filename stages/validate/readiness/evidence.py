"""Judges the points that other checks of the run prove, and the points about the files as a whole."""

import hashlib
import json
from collections.abc import Iterator

import numpy as np

from linkwright.stages.formats.meshes.points import STL_FACE, STL_HEADER
from linkwright.stages.mujoco.compile import NotCompiled, compiled_and_rewritten
from linkwright.stages.robot.system.install import install
from linkwright.stages.validate.readiness.finished import FinishedRobot, NotApplicable

MAX_STL_FACES = 200_000
"""Largest number of faces of an STL that MuJoCo reads."""

WRITER_PRECISION = 1e-5
"""Relative precision of MuJoCo's own writer, which writes six digits."""

QUANTITIES_WITH_PROVENANCE = ("damping", "friction", "armature", "effort", "velocity")
"""Quantities of a dof for which robot.json must say where their value comes from."""

PUBLISHED_FILES = ("README.md", "LICENSE")
"""Further files of a published model, except its picture, which a build draws at its end."""

REWRITTEN_COUNTS = ("nq", "nv", "nu", "nbody", "ngeom", "neq", "nsite", "nkey", "nexclude")
REWRITTEN_ARRAYS = (
    "body_mass",
    "body_inertia",
    "body_pos",
    "jnt_range",
    "dof_armature",
    "geom_size",
    "key_qpos",
)
"""Numbers of elements, and arrays, of a model that must stay the same when MuJoCo writes and reads it."""


def compiles(finished: FinishedRobot) -> Iterator[str]:
    """Judges by the checks that compile the files."""
    return finished.failures_of(["COMPILE"], "no check compiled the files")


def same_mass(finished: FinishedRobot) -> Iterator[str]:
    """Judges by the checks that compare masses with the source."""
    return finished.failures_of(["MASS"], "no check compared the masses with the source")


def rests(finished: FinishedRobot) -> Iterator[str]:
    """Judges by the checks that let the robot rest at `home`."""
    return finished.failures_of(["REST"], "no check let it rest at home")


def noise(finished: FinishedRobot) -> Iterator[str]:
    """Judges by the checks that simulate the robot under control noise."""
    return finished.failures_of(["NOISE", "TRIAL"], "no check simulated it")


def contacts_at_home(finished: FinishedRobot) -> Iterator[str]:
    """Judges by the checks that look for contacts at `home`."""
    codes = ["SELF-CONTACT", "START"]
    return finished.failures_of(codes, "no check looked for contacts at home")


def collider_tolerances(finished: FinishedRobot) -> Iterator[str]:
    """Judges whether colliders are within the tolerances of the configuration."""
    figures = finished.geometry.colliders if finished.geometry else ()
    judged = [figure for figure in figures if figure.rung != "none" and figure.tolerance is not None]
    if not judged:
        raise NotApplicable("no collider was judged when it was made")
    for figure in judged:
        if not figure.meets or (figure.miss or 0.0) > 1.0:
            times = f"{figure.miss:.2g} times its tolerance" if figure.miss else "out of its tolerance"
            parts = ", ".join(figure.parts[:2])
            yield f"the collider of {parts} of {figure.link} is {times} off: mesh.colliders"


def assets(finished: FinishedRobot) -> Iterator[str]:
    """Judges whether MuJoCo reads every STL, and no two assets are equal."""
    digests: dict[str, str] = {}
    for path in sorted((finished.folder / "assets").glob("*")):
        data = path.read_bytes()
        first = digests.setdefault(hashlib.sha256(data).hexdigest(), path.name)
        if first != path.name:
            yield f"{path.name} is the same as {first}"
        if path.suffix == ".stl":
            start = STL_HEADER + 4
            faces = int.from_bytes(data[STL_HEADER:start], "little")
            if len(data) != start + STL_FACE.itemsize * faces or not 0 < faces <= MAX_STL_FACES:
                expected = f"a binary STL of 1 to {MAX_STL_FACES:,} faces"
                yield f"{path.name} is not {expected}: mesh.visual.max_faces"
    if not digests:
        raise NotApplicable("there are no meshes")


def closes(finished: FinishedRobot) -> Iterator[str]:
    """Judges by the checks of loops and relations."""
    if not finished.robot.loops and not finished.robot.relations:
        raise NotApplicable("the robot has no loops and no relations")
    return finished.failures_of(["LOOP", "RELATION", "CLOSED"], "no check looked at loops and relations")


def parity(finished: FinishedRobot) -> Iterator[str]:
    """Judges by the comparison with a second engine."""
    otherwise = f"proved elsewhere: no second engine is installed here ({install('pin')})"
    return finished.failures_of(["PARITY"], otherwise)


def formats(finished: FinishedRobot) -> Iterator[str]:
    """Judges by the checks of the files in other formats than MJCF."""
    files = [path for ending in ("urdf", "sdf", "usda") for path in finished.folder.glob(f"*.{ending}")]
    if not files:
        raise NotApplicable("the robot was written in one format")
    endings = tuple(f"{path.name}:" for path in files)
    yield from (
        f"{check.name}: {check.detail}"
        for check in finished.checks
        if check.fails and check.name.startswith(endings)
    )


def round_trip(finished: FinishedRobot) -> Iterator[str]:
    """Judges whether the model stays the same when MuJoCo writes and reads it."""
    files = {path.name: path.read_bytes() for path in (finished.folder / "assets").glob("*")}
    try:
        # C-COMPILE reports its warnings.
        first, second = compiled_and_rewritten(finished.path, files)
    except NotCompiled as error:
        yield f"what MuJoCo writes of it does not compile: {error}"
        return
    for key in REWRITTEN_COUNTS:
        if getattr(first, key) != getattr(second, key):
            yield f"what MuJoCo writes of it has {getattr(second, key)} in {key}, not {getattr(first, key)}"
            return
    for key in REWRITTEN_ARRAYS:
        before, after = getattr(first, key), getattr(second, key)
        difference = float(np.abs(before - after).max(initial=0.0))
        if not difference <= WRITER_PRECISION * max(1.0, float(np.abs(before).max(initial=0.0))):
            yield f"what MuJoCo writes of it is {difference:.2g} off in {key}"


def provenance(finished: FinishedRobot) -> Iterator[str]:
    """Judges whether robot.json says where each parameter comes from, and README and LICENSE exist."""
    path = finished.folder / "robot.json"
    tree = json.loads(path.read_bytes()) if path.exists() else {}
    if not tree:
        yield "write robot.json, which says where each parameter comes from"
    for dof in (dof for joint in tree.get("joints", ()) for dof in joint.get("dofs", ())):
        sources = dof.get("provenance", {})
        missing = [
            name for name in QUANTITIES_WITH_PROVENANCE if dof.get(name) is not None and not sources.get(name)
        ]
        if missing:
            yield f"say where the {', '.join(missing)} of {dof['name']} come from"
    missing_files = [name for name in PUBLISHED_FILES if not (finished.folder / name).exists()]
    if missing_files:
        yield f"add {', '.join(missing_files)} beside the files"
