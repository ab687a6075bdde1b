"""Faults of a build's USD, planted in its text."""

import re

from tests.support.faults.edits import either
from tests.support.faults.fault import NothingToChange, table

BODY = re.compile(r'\n    def Xform "(\w+)" \(\n        prepend apiSchemas = \["PhysicsRigidBodyAPI"')
CONVEX = r'physics:approximation = "convexHull"'
HULL = f"uniform token {CONVEX}"


def replaced(pattern, new, element=""):
    """Replaces one of the places that match. A finding names `element`, or else the body that the place is
    in."""

    def plant(files, rng):
        text = files.path.read_text(encoding="utf-8")
        matches = list(re.finditer(pattern, text))
        if not matches:
            raise NothingToChange
        # What is drawn of the new text is drawn before the place where the text does not depend on that.
        words = new if isinstance(new, str) else new(rng)
        match = rng.choice(matches)
        words = words(match, text) if callable(words) else match.expand(words)
        files.path.write_text(text[: match.start()] + words + text[match.end() :], encoding="utf-8")
        bodies = [body[1] for body in BODY.finditer(text) if body.start() <= match.start()]
        return element or f'def "{(bodies or [""])[-1]}"'

    return plant


def moved_aside(rng):
    place = f"double3 xformOp:translate = (0, {rng.uniform(1e-4, 0.1):.6g}, 0)"
    return rf'\g<0>\n{place}\nuniform token[] xformOpOrder = ["xformOp:translate"]'


def ten_times(rng):
    return lambda match, text: f"{match[1]}{10 * float(match[2])!r}"


def another_mesh(rng):
    def words(match, text):
        meshes = set(re.findall(r"</meshes/(\w+)>", text))
        return f"</meshes/{rng.choice(sorted(meshes - {match[1]}))}>"

    return words


def no_force(rng):
    off = rng.choice(("bool physics:rigidBodyEnabled = 0", "bool physics:kinematicEnabled = 1"))
    return rf"{off}\n        \g<0>"


SELF = "physxArticulation:enabledSelfCollisions"

FAULTS = table(
    "usd",
    ("units in centimetres", replaced(r"metersPerUnit = 1\n", either("metersPerUnit = 0.01\n", ""), "layer"),
     "C-USD: metersPerUnit"),
    ("masses in grams", replaced(r"kilogramsPerUnit = 1\n", "kilogramsPerUnit = 0.001\n", "layer"),
     "C-USD: kilogramsPerUnit"),
    ("y points upwards", replaced(r'upAxis = "Z"\n', either('upAxis = "Y"\n', ""), "layer"), "C-USD: upAxis"),
    ("collider collides with nothing", replaced('"PhysicsCollisionAPI"', '"GeomModelAPI"'),
     "C-USD: apiSchemas"),
    ("collision switched off", replaced(HULL, r"\g<0>\n                bool physics:collisionEnabled = 0"),
     "C-USD: physics:collisionEnabled"),
    ("collider not convex", replaced(CONVEX, 'physics:approximation = "boundingCube"'),
     "C-USD: physics:approximation"),
    ("collider moved", replaced(HULL, moved_aside), "C-USD: collision"),
    ("collider resized",
     replaced(r"(double radius = |double height = |double3 xformOp:scale = \()([\d.e-]+)", ten_times),
     "C-USD: collision"),
    ("mesh of another part", replaced(r"</meshes/(\w+)>", another_mesh), "C-USD: visual"),
    ("body that no force moves", replaced(r"point3f physics:centerOfMass", no_force),
     "C-USD: physics:rigidBodyEnabled"),
    ("links pass through each other", replaced(f"{SELF} = 1", f"{SELF} = 0", "def"), f"C-USD: {SELF}"),
    ("pair collides again", replaced(r"(?:prepend )?rel physics:filteredPairs = [^\n\[]+\n", "\n", "def"),
     "C-USD: physics:filteredPairs"),
)  # fmt: skip
