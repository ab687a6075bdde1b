"""The page of the faults, and of what finds each: `python -m tests.config.regenerate`."""

from tests.support.faults import BARE, BUILD

PLACES = {
    "urdf": "URDF",
    "mjcf": "MJCF",
    "scene": "scene",
    "assets": "asset",
    "sdf": "SDF",
    "srdf": "SRDF",
    "usd": "USD",
    "config": "model.config",
    "ros2": "ROS 2",
    "python": "Python",
    "bare urdf": "URDF",
    "bare mjcf": "MJCF",
}

INTRODUCTION = """\
# What the checks find

Generated from `tests/support/faults` by `python -m tests.config.regenerate`; do not edit. Each fault
is planted in a finished build, at a place and of a size that a seed draws. The check with one of these
codes (`linkwright explain C-MASS`) must not pass, and must name the element and its attribute. Digests are
no evidence, nor is exporting again: the checks read the files. `tests/e2e/test_mutations.py` plants every
kind in the sample and in a robot with a free base, motors, sensors and a gear, its slow part with three
seeds; there is no false alarm on 200 random documents, nor after edits that mean nothing (comments, order
of attributes, white space, other digits for the same numbers, other names of materials).

Others' figures, as they publish them: simcheck 0.2.0 (its README, "Benchmark") plants 17 kinds in 52 assets
and catches 631 of 655 faults (96 %), among them 95 of 119 in robots. The figures cannot be compared directly:
simcheck has only the file, these checks know the robot that it was written from. "s" marks the kinds
that simcheck plants too, all 17 of them; mjcf-doctor and urdf_validate publish no such figures.
"""


ALONE = """
## Files that come alone

A URDF or MJCF without a build is judged by itself (`linkwright check arm.urdf`). Each of these faults is
planted in an arm of three links, and must be found at its element and its attribute.
"""


def markdown():
    """The page."""
    counted = f"{len(BUILD)} kinds; {sum(bool(fault.simcheck) for fault in BUILD)} are marked.\n"
    marks = ["s" if fault.simcheck else "" for fault in BUILD]
    build = _table(["fault", "in", "found by", ""], zip(*_columns(BUILD), marks, strict=True))
    bare = _table(["fault", "in", "found by"], zip(*_columns(BARE), strict=True))
    return "\n".join([INTRODUCTION, counted, *build, ALONE, f"{len(BARE)} kinds.\n", *bare]) + "\n"


def _columns(faults):
    codes = [", ".join(f"`{code}`" for code in fault.codes) for fault in faults]
    return [fault.kind for fault in faults], [PLACES[fault.file] for fault in faults], codes


def _table(header, rows):
    lines = [header, ["---"] * len(header), *rows]
    return ["| " + " | ".join(line) + " |" for line in lines]
