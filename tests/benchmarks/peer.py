"""`python -m tests.benchmarks.peer`: Linkwright beside onshape-to-robot and onshape-robotics-toolkit.

Two documents on one local server. The first has 120 parts in 8 part studios, about 600 triangles a part, and
the server waits 100 ms before each reply; all tools begin with an empty folder and an empty cache. We write
a URDF and an MJCF, they a URDF: they write one format a run. Before the clock runs each tool builds once
without waiting, since the server makes its replies when first asked. The second has a parallelogram of hinges
and a sub-assembly with a hinge inside, and is built twice in each format.

Prints a table in Markdown, which README.md has, and what the server counted: replies of 2xx and 3xx, as
Onshape bills. Ends with exit status 1 where a goal against onshape-to-robot is missed.
"""

import sys
import tempfile
import time
import xml.etree.ElementTree as ET
from dataclasses import dataclass
from pathlib import Path

import mujoco
import numpy as np

from tests.benchmarks.many_parts import PARTS, STUDIOS, many_parts
from tests.benchmarks.peer_tools import tools
from tests.fake_onshape import solids
from tests.fake_onshape.document import Document
from tests.fake_onshape.frames import frame, turn
from tests.fake_onshape.server import OnshapeServer

LATENCY_S = 0.1
TIME_GOAL, CALLS_GOAL = 20, 15
LENGTH, WIDTH, SPREAD = 0.1, 0.2, 0.4
"""The parallelogram's cranks and base [m], and how far the cranks lean [rad]."""


@dataclass(frozen=True)
class Spent:
    """What builds of the large document took: seconds of the first; calls of the first, of the same again,
    and after an edit of one part; the masses that its MJCF has in MuJoCo and that the document has [kg]."""

    seconds: float
    first: int
    again: int
    edited: int
    mass: float
    true_mass: float


@dataclass(frozen=True)
class Built:
    """What the small document became: whether the joint inside the sub-assembly moves in the URDF, the number
    of equalities in the MJCF, whether a second build gave the same bytes, and why MuJoCo refuses the MJCF."""

    inside: bool
    loops: int
    same: bool
    refused: str


def main():
    with tempfile.TemporaryDirectory() as folder:
        compared = tools(Path(folder))
        spent = [spend(tool) for tool in compared]
        built = [build(tool) for tool in compared]
    print(table([tool.name for tool in compared], spent, built))
    for tool, each in zip(compared, built, strict=True):
        if each.refused:
            print(f"\nMuJoCo refuses the MJCF of {tool.name}: {each.refused}")
    ours, theirs = spent[:2]
    time_ratio, calls_ratio = theirs.seconds / ours.seconds, theirs.first / ours.first
    print(f"\nbeside onshape-to-robot: 1/{time_ratio:.1f} of the time (goal 1/{TIME_GOAL}),", end=" ")
    print(f"1/{calls_ratio:.1f} of the calls (goal 1/{CALLS_GOAL})")
    return 0 if time_ratio >= TIME_GOAL and calls_ratio >= CALLS_GOAL else 1


def table(names, spent, built):
    """The comparison as a table in Markdown."""
    rows = {
        f"{PARTS} parts in {STUDIOS} studios, first build": [f"{each.seconds:.1f} s" for each in spent],
        "API calls of it": [str(each.first) for each in spent],
        "API calls of the same again": [str(each.again) for each in spent],
        "API calls after an edit of one part": [str(each.edited) for each in spent],
        "mass in MuJoCo, off by": [f"{abs(each.mass / each.true_mass - 1):.0e}" for each in spent],
        "joints inside a sub-assembly": [_yes(each.inside) for each in built],
        "the loop of a four-bar in the MJCF": [_yes(each.loops > 0) for each in built],
        "a second build has the same bytes": [_yes(each.same) for each in built],
    }
    lines = ["| | " + " | ".join(names) + " |", "| --- |" + " ---: |" * len(names)]
    return "\n".join([*lines, *(f"| {title} | " + " | ".join(cells) + " |" for title, cells in rows.items())])


def _yes(value):
    return "yes" if value else "no"


def spend(tool):
    """Builds the large document by a tool: cold, again, and after an edit."""
    document = many_parts()
    with OnshapeServer(document) as server:
        with tempfile.TemporaryDirectory() as folder:
            path = tool.build(server, Path(folder), "xml")
            mass, _, _ = in_mujoco(path)
        with tempfile.TemporaryDirectory() as folder:
            tool.build(server, Path(folder), "urdf")
        with tempfile.TemporaryDirectory() as folder:
            here = Path(folder)
            server.latency_s = LATENCY_S
            start = time.perf_counter()
            first = _calls(server, tool, here)
            seconds = time.perf_counter() - start
            again = _calls(server, tool, here)
            after = document.edited("Studio 3")
            after.part("Disc 3").density *= 1.5
            after.changed()
            server.edit(after)
            edited = _calls(server, tool, here)
    return Spent(seconds, first, again, edited, mass, true_mass(many_parts()))


def _calls(server, tool, here):
    server.reset()
    tool.build(server, here, "urdf")
    return server.count


def build(tool):
    """Builds the small document twice by a tool, in each format."""
    document = linkage()
    written, joints, loops, refused = [], 0, 0, ""
    with OnshapeServer(document) as server:
        for _ in range(2):
            with tempfile.TemporaryDirectory() as folder:
                here = Path(folder)
                paths = [tool.build(server, here, kind) for kind in ("urdf", "xml")]
                written.append([path.read_bytes() for path in paths])
                joints = ET.parse(paths[0]).getroot().findall("joint")
                _, loops, refused = in_mujoco(paths[1])
    inside = any("knee" in joint.get("name") and joint.get("type") == "revolute" for joint in joints)
    return Built(inside, loops, written[0] == written[1], refused)


def in_mujoco(path):
    """Mass [kg], number of equalities between bodies or sites, and why MuJoCo refuses an MJCF."""
    try:
        model = mujoco.MjModel.from_xml_path(str(path))
    except ValueError as error:
        return np.nan, 0, str(error).splitlines()[0]
    return float(model.body_mass.sum()), model.neq, ""


def true_mass(document):
    """The mass of a document whose parts are all in its root assembly, each once [kg]."""
    return document.truth.total_mass()


def linkage():
    """A parallelogram of hinges `dof_...` on a fixed base, closed by `closing_d`, and a leg on the hinge
    `dof_hip`, which is a sub-assembly with the hinge `dof_knee` inside."""
    document = Document("Linkage")
    studio = document.studio("Parts")

    def bar(name, length):
        return studio.part(name, solids.box(length, 0.02, 0.01), density=2700)

    leg = document.assembly("Leg")
    thigh, shank = (leg.add(bar(name, LENGTH)) for name in ("Thigh", "Shank"))
    leg.revolute("dof_knee", (shank, np.eye(4)), (thigh, frame((LENGTH, 0, 0))), value=0.3, limits=(-1, 1))
    root = document.assembly("Robot")
    document.root = root
    base = root.add(bar("Base", WIDTH), fixed=True)
    left, right, top = (
        root.add(bar(name, size)) for name, size in (("Left", LENGTH), ("Right", LENGTH), ("Top", WIDTH))
    )
    lean = turn((0, 0, 1), SPREAD)
    limits = (-1, 1)
    root.revolute("dof_a", (left, np.eye(4)), (base, lean), value=0.2, limits=limits)
    root.revolute("dof_b", (right, np.eye(4)), (base, frame((WIDTH, 0, 0)) @ lean), value=0.2, limits=limits)
    root.revolute(
        "dof_c", (top, np.eye(4)), (left, frame((LENGTH, 0, 0)) @ lean.T), value=-0.2, limits=limits
    )
    root.revolute(
        "closing_d",
        (top, frame((WIDTH, 0, 0))),
        (right, frame((LENGTH, 0, 0)) @ lean.T),
        value=-0.2,
        closing=True,
    )
    hand = root.add(leg)
    root.revolute("dof_hip", (hand / thigh, np.eye(4)), (base, frame((0, 0, 0.1))), value=0.1, limits=limits)
    return document


if __name__ == "__main__":
    sys.exit(main())
