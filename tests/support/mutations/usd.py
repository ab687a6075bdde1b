"""Faults of a USD, planted in its text."""

import random
import re
from collections.abc import Callable

from tests.support.mutations.kind import Files, Kinds, NothingToChange, Planted

KINDS = Kinds("usd")

BODY = re.compile(r'\n    def Xform "(\w+)" \(\n        prepend apiSchemas = \["PhysicsRigidBodyAPI"')


def edited(
    files: Files, rng: random.Random, pattern: str, new: str | Callable[[re.Match[str]], str]
) -> tuple[str, re.Match[str]]:
    """Replaces one of the places that match, and says which body it is in, "" for none."""
    path = files.folder / f"{files.name}.usda"
    text = path.read_text(encoding="utf-8")
    found = list(re.finditer(pattern, text))
    if not found:
        raise NothingToChange
    one = rng.choice(found)
    words = new(one) if callable(new) else one.expand(new)
    path.write_text(text[: one.start()] + words + text[one.end() :], encoding="utf-8")
    bodies = [body[1] for body in BODY.finditer(text) if body.start() <= one.start()]
    return (bodies or [""])[-1], one


def of_body(body: str, *attributes: str) -> Planted:
    return Planted(f'def "{body}"', attributes)


@KINDS.add("units in centimetres", "C-USD")
def _(files: Files, rng: random.Random) -> Planted:
    edited(files, rng, r"metersPerUnit = 1\n", rng.choice(("metersPerUnit = 0.01\n", "")))
    return Planted("layer", ("metersPerUnit",))


@KINDS.add("masses in grams", "C-USD")
def _(files: Files, rng: random.Random) -> Planted:
    edited(files, rng, r"kilogramsPerUnit = 1\n", "kilogramsPerUnit = 0.001\n")
    return Planted("layer", ("kilogramsPerUnit",))


@KINDS.add("y points upwards", "C-USD")
def _(files: Files, rng: random.Random) -> Planted:
    edited(files, rng, r'upAxis = "Z"\n', rng.choice(('upAxis = "Y"\n', "")))
    return Planted("layer", ("upAxis",))


@KINDS.add("collider collides with nothing", "C-USD")
def _(files: Files, rng: random.Random) -> Planted:
    body, _ = edited(files, rng, '"PhysicsCollisionAPI"', '"GeomModelAPI"')
    return of_body(body, "apiSchemas")


@KINDS.add("collision switched off", "C-USD")
def _(files: Files, rng: random.Random) -> Planted:
    off = r"\g<0>\n                bool physics:collisionEnabled = 0"
    body, _ = edited(files, rng, r'uniform token physics:approximation = "convexHull"', off)
    return of_body(body, "physics:collisionEnabled")


@KINDS.add("collider not convex", "C-USD")
def _(files: Files, rng: random.Random) -> Planted:
    pattern = r'physics:approximation = "convexHull"'
    body, _ = edited(files, rng, pattern, 'physics:approximation = "boundingCube"')
    return of_body(body, "physics:approximation")


@KINDS.add("collider moved", "C-USD")
def _(files: Files, rng: random.Random) -> Planted:
    place = f"double3 xformOp:translate = (0, {rng.uniform(1e-4, 0.1):.6g}, 0)"
    moved = rf'\g<0>\n{place}\nuniform token[] xformOpOrder = ["xformOp:translate"]'
    body, _ = edited(files, rng, r'uniform token physics:approximation = "convexHull"', moved)
    return of_body(body, "collision")


@KINDS.add("collider resized", "C-USD")
def _(files: Files, rng: random.Random) -> Planted:
    pattern = r"(double radius = |double height = |double3 xformOp:scale = \()([\d.e-]+)"
    body, _ = edited(files, rng, pattern, lambda found: f"{found[1]}{10 * float(found[2])!r}")
    return of_body(body, "collision")


@KINDS.add("mesh of another part", "C-USD")
def _(files: Files, rng: random.Random) -> Planted:
    every = set(re.findall(r"</meshes/(\w+)>", (files.folder / f"{files.name}.usda").read_text()))

    def other(found: re.Match[str]) -> str:
        return f"</meshes/{rng.choice(sorted(every - {found[1]}))}>"

    body, _ = edited(files, rng, r"</meshes/(\w+)>", other)
    return of_body(body, "visual")


@KINDS.add("body that no force moves", "C-USD")
def _(files: Files, rng: random.Random) -> Planted:
    off = rng.choice(("bool physics:rigidBodyEnabled = 0", "bool physics:kinematicEnabled = 1"))
    body, _ = edited(files, rng, r"point3f physics:centerOfMass", rf"{off}\n        \g<0>")
    return of_body(body, "physics:rigidBodyEnabled")


@KINDS.add("links pass through each other", "C-USD")
def _(files: Files, rng: random.Random) -> Planted:
    attribute = "physxArticulation:enabledSelfCollisions"
    edited(files, rng, f"{attribute} = 1", f"{attribute} = 0")
    return Planted("def", (attribute,))


@KINDS.add("pair collides again", "C-USD")
def _(files: Files, rng: random.Random) -> Planted:
    edited(files, rng, r"(?:prepend )?rel physics:filteredPairs = [^\n\[]+\n", "\n")
    return Planted("def", ("physics:filteredPairs",))
