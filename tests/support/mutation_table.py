"""The page of the kinds of faults, and of what finds each: `python -m tests.config.regenerate`."""

from tests.support.mutations import KINDS

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
}

INTRODUCTION = """\
# What the checks find

Generated from `tests/support/mutations` by `python -m tests.config.regenerate`; do not edit. Each fault
is planted in a finished build, at a place and of a size that a seed draws. The check with one of these
codes (`linkwright explain C-MASS`) must not pass, and must name the element and its attribute. Digests are
no evidence, nor is exporting again: the checks read the files. `tests/e2e/test_mutations.py` plants every
kind in the sample and in a robot with a free base, motors, sensors and a gear, its slow part with three
seeds; there is no false alarm on 200 random documents, nor after edits that mean nothing (comments, order
of attributes, white space, other digits for the same numbers, other names of materials).

Others' figures, as they publish them: simcheck 0.2.0 (its README, "Benchmark") plants 17 kinds in 52 assets
and catches 631 of 655 faults (96 %), of which 95 of 119 in robots. They do not compare with these one by
one: simcheck has the file alone, these checks know the robot that it was written from. "s" marks the kinds
that simcheck plants too, all 17 of them; mjcf-doctor and urdf_validate publish no such figures.
"""


def markdown() -> str:
    """The page."""
    counted = f"{len(KINDS)} kinds, of which {sum(bool(one.simcheck) for one in KINDS)} are marked.\n"
    lines = ["| fault | in | found by | |", "| --- | --- | --- | --- |"]
    for one in KINDS:
        codes = ", ".join(f"`{code}`" for code in one.codes)
        lines.append(f"| {one.name} | {PLACES[one.file]} | {codes} | {'s' if one.simcheck else ''} |")
    return "\n".join([INTRODUCTION, counted, *lines]) + "\n"
