"""The points that other checks of the run prove, and those about the files as a whole."""

import hashlib
import json
from collections.abc import Iterator

import numpy as np

from linkwright.stages.mujoco.compile import NotCompiled, compiled_and_rewritten
from linkwright.stages.robot.system.install import install
from linkwright.stages.validate.readiness.finished import Aside, Finished

FACES = 200_000
"""Faces that MuJoCo reads of an STL."""

WRITTEN = 1e-5
"""MuJoCo writes numbers with six digits."""

SOURCES = ("damping", "friction", "armature", "effort", "velocity")

BESIDE = ("README.md", "LICENSE")
"""What a published model has beside its files; but its picture, which a build draws at its end."""

COUNTS = ("nq", "nv", "nu", "nbody", "ngeom", "neq", "nsite", "nkey", "nexclude")
ARRAYS = ("body_mass", "body_inertia", "body_pos", "jnt_range", "dof_armature", "geom_size", "key_qpos")


def compiles(finished: Finished) -> Iterator[str]:
    return finished.proved_by(["COMPILE"], "no check compiled the files")


def same_mass(finished: Finished) -> Iterator[str]:
    return finished.proved_by(["MASS"], "no check compared the masses with the source")


def rests(finished: Finished) -> Iterator[str]:
    return finished.proved_by(["REST"], "no check let it rest at home")


def noise(finished: Finished) -> Iterator[str]:
    return finished.proved_by(["NOISE", "TRIAL"], "no check simulated it")


def apart(finished: Finished) -> Iterator[str]:
    codes = ["SELF-CONTACT", "START"]
    return finished.proved_by(codes, "no check looked for contacts at home")


def near(finished: Finished) -> Iterator[str]:
    figures = finished.geometry.colliders if finished.geometry else ()
    judged = [one for one in figures if one.rung != "none" and one.tolerance is not None]
    if not judged:
        raise Aside("no collider was judged when it was made")
    for one in judged:
        if not one.meets or (one.miss or 0.0) > 1.0:
            times = f"{one.miss:.2g} times its tolerance" if one.miss else "out of its tolerance"
            yield f"the collider of {', '.join(one.parts[:2])} of {one.link} is {times} off: mesh.colliders"


def assets(finished: Finished) -> Iterator[str]:
    digests: dict[str, str] = {}
    for path in sorted((finished.folder / "assets").glob("*")):
        data = path.read_bytes()
        first = digests.setdefault(hashlib.sha256(data).hexdigest(), path.name)
        if first != path.name:
            yield f"{path.name} is the same as {first}"
        if path.suffix == ".stl":
            faces = int.from_bytes(data[80:84], "little")
            if len(data) != 84 + 50 * faces or not 0 < faces <= FACES:
                yield f"{path.name} is no binary STL of 1 to {FACES:,} faces: mesh.visual.max_faces"
    if not digests:
        raise Aside("there are no meshes")


def closes(finished: Finished) -> Iterator[str]:
    if not finished.robot.loops and not finished.robot.relations:
        raise Aside("the robot has no loops and no relations")
    return finished.proved_by(["LOOP", "RELATION", "CLOSED"], "no check looked at loops and relations")


def parity(finished: Finished) -> Iterator[str]:
    otherwise = f"proved elsewhere: no second engine is installed here ({install('pin')})"
    return finished.proved_by(["PARITY"], otherwise)


def formats(finished: Finished) -> Iterator[str]:
    others = [path for ending in ("urdf", "sdf", "usda") for path in finished.folder.glob(f"*.{ending}")]
    if not others:
        raise Aside("the robot was written in one format")
    endings = tuple(f"{path.name}:" for path in others)
    yield from (
        f"{one.name}: {one.detail}" for one in finished.checks if one.fails and one.name.startswith(endings)
    )


def round_trip(finished: Finished) -> Iterator[str]:
    files = {path.name: path.read_bytes() for path in (finished.folder / "assets").glob("*")}
    try:
        # What it warns of is in C-COMPILE.
        first, second = compiled_and_rewritten(finished.path, files)
    except NotCompiled as error:
        yield f"what MuJoCo writes of it does not compile: {error}"
        return
    for key in COUNTS:
        if getattr(first, key) != getattr(second, key):
            yield f"what MuJoCo writes of it has {getattr(second, key)} in {key}, not {getattr(first, key)}"
            return
    for key in ARRAYS:
        one, other = getattr(first, key), getattr(second, key)
        off = float(np.abs(one - other).max(initial=0.0))
        if off > WRITTEN * max(1.0, float(np.abs(one).max(initial=0.0))):
            yield f"what MuJoCo writes of it is {off:.2g} off in {key}"


def provenance(finished: Finished) -> Iterator[str]:
    path = finished.folder / "robot.json"
    tree = json.loads(path.read_bytes()) if path.exists() else {}
    if not tree:
        yield "write robot.json, which says where each parameter comes from"
    for dof in (dof for one in tree.get("joints", ()) for dof in one.get("dofs", ())):
        known = dof.get("provenance", {})
        missing = [name for name in SOURCES if dof.get(name) is not None and not known.get(name)]
        if missing:
            yield f"say where the {', '.join(missing)} of {dof['name']} come from"
    beside = [name for name in BESIDE if not (finished.folder / name).exists()]
    if beside:
        yield f"add {', '.join(beside)} beside the files"
