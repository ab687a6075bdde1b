"""Faults of the file by which Gazebo finds an SDF."""

import random

from tests.support.mutations.kind import Element, Files, Kinds, Planted

KINDS = Kinds("config")


def sdf(files: Files) -> Element:
    return files.tree("model.config").find("sdf")


@KINDS.add("SDF that is not there", "C-SDF")
def _(files: Files, rng: random.Random) -> Planted:
    sdf(files).text = rng.choice(("model.sdf", f"{files.name}.urdf", ""))
    return Planted("sdf", ("",))


@KINDS.add("version of another SDF", "C-SDF")
def _(files: Files, rng: random.Random) -> Planted:
    sdf(files).set("version", rng.choice(("1.4", "1.11")))
    return Planted("sdf", ("version",))


@KINDS.add("no SDF named", "C-SDF")
def _(files: Files, rng: random.Random) -> Planted:
    node = sdf(files)
    node.getparent().remove(node)
    return Planted("sdf", ("",))
