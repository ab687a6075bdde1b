"""Nothing in the build's own code runs faster up than the assembly does: lines are counted, not seconds."""

import sys
from collections import Counter
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest

from linkwright.stages.export import export
from linkwright.stages.graph import build_robot
from linkwright.stages.graph.globs import entries_of
from linkwright.stages.mesh.collide.primitives import shapes as primitive_shapes
from linkwright.stages.robot.codec import decode_robot, encode_robot
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.model.geometry import Geometry
from linkwright.stages.robot.model.robot import Primitive, frozen
from linkwright.stages.show.graph_view.views import views
from tests.benchmarks.large import large
from tests.benchmarks.shapes import chain, gears, ladder, screws, star
from tests.support.building import NO_MESHES, plan_of
from tests.support.mjcfs import bundle_of, model, written
from tests.support.robots import joint, robot_with
from tests.support.urdfs import urdf_bundle

STAGES = str(Path(sys.modules["linkwright.stages.graph"].__file__).parents[1])

TIMES = 4
"""The larger assembly is so many times the smaller one."""

MOST = 2 * TIMES
"""A line that runs more than so many times as often is not of n log n work (of n²: 16)."""

FEW = 300
"""Lines that run less often in the larger assembly do not count: what they grow by is rounding."""


def lines_run(work):
    """How often each line of the stages runs in `work`; a loop on one line counts every time round."""
    counts = Counter()

    def local(frame, event, _):
        if event == "line":
            counts[frame.f_code.co_filename, frame.f_lineno] += 1
        return local

    def enter(frame, event, _):
        return local if frame.f_code.co_filename.startswith(STAGES) else None

    before = sys.gettrace()
    sys.settrace(enter)
    try:
        work()
    finally:
        sys.settrace(before)
    return counts


def whole(bundle):
    """The graph stage with all that it writes, and the export."""
    plan = plan_of()
    robot = build_robot(bundle, plan)
    views(robot)
    export(decode_robot(encode_robot(robot)), NO_MESHES, plan)


def urdf_of(count, kind, inside="", masses=True, star=False):
    """A URDF of `count` joints, each on the link before, or all on one; without `masses` every other link
    has none."""
    inertial = (
        '<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>'
    )
    links = [f'<link name="l{i}">{inertial if masses or i % 2 == 0 else ""}</link>' for i in range(count + 1)]
    joints = [
        f'<joint name="j{i}" type="{kind}"><parent link="l{0 if star else i}"/><child link="l{i + 1}"/>'
        f'<origin xyz="0 0 0.001"/>{inside.format(i - 1) if i else ""}</joint>'
        for i in range(count)
    ]
    return urdf_bundle(f'<robot name="r">{"".join(links)}{"".join(joints)}</robot>'.encode())


KINDS = {
    "fixed_chain": lambda size: urdf_of(size, "fixed"),
    "dummy_chain": lambda size: urdf_of(size, "fixed", masses=False),  # links without mass become frames
    "dummy_star": lambda size: urdf_of(size, "fixed", masses=False, star=True),
    # Links without mass stand between joints.
    "carrier_chain": lambda size: urdf_of(2 * (size // 2), "continuous", masses=False),
    "mimic_chain": lambda size: urdf_of(size, "continuous", '<mimic joint="j{}"/>'),
}


def mjcf_star(size):
    """Bodies with joints, sites, meshes and equalities, as read by MuJoCo."""
    bodies = [
        f'<body name="b{i}"><inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/><joint name="j{i}"/>'
        f'<geom type="mesh" mesh="m{i}"/><site name="s{i}"/></body>'
        for i in range(size)
    ]
    meshes = [f'<mesh name="m{i}" vertex="0 0 0 1 0 0 0 1 0 0 0 1"/>' for i in range(size)]
    ties = [f'<joint joint1="j{i}" joint2="j{i + 1}"/>' for i in range(size - 1)]
    more = f"<asset>{''.join(meshes)}</asset><equality>{''.join(ties)}</equality>"
    with TemporaryDirectory() as folder:
        return bundle_of(written(Path(folder), model("".join(bodies), more)))


pytestmark = pytest.mark.usefixtures("guests_at_home")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("make", "size"),
    [(large, 3), (chain, 30), (star, 20), (screws, 30), (ladder, 10), (gears, 20), (mjcf_star, 20)]
    + [(make, 60 if name == "dummy_chain" else 20) for name, make in KINDS.items()],
    ids=["large", "chain", "star", "screws", "ladder", "gears", "mjcf_star", *KINDS],
)
def test_no_line_runs_more_often_than_the_assembly_grows(make, size):
    small, big = make(size), make(TIMES * size)
    whole(small)  # imports, and what is remembered of them
    assert grown_beyond(lambda: whole(small), lambda: whole(big)) == []


def grown_beyond(small, big):
    """The lines that run too often in the larger work, with their counts in both."""
    before, after = lines_run(small), lines_run(big)
    assert max(after.values()) > FEW, "nothing was counted"
    rows = [(line, before[line], count) for line, count in after.items() if count > FEW]
    return [row for row in rows if row[2] > MOST * row[1]]


def test_shapes_are_written_in_proportion_to_their_number():
    """A chain with a ball on each link, every third of them on a fixed joint."""

    def exporting(size):
        names = ["base", *(f"l{number}" for number in range(size))]
        kinds = ["fixed" if number % 3 == 0 else "revolute" for number in range(size)]
        rows = [joint(kind, a, b) for kind, a, b in zip(kinds, names, names[1:], strict=False)]
        ball = (Primitive("sphere", (0.01,), frozen(np.eye(4))),)
        robot = robot_with(rows, shapes=dict.fromkeys(names, ball))
        geometry = Geometry(tuple(shape for link in robot.links for shape in primitive_shapes(link)), {})
        plan = plan_of(actuators={})
        return lambda: export(robot, geometry, plan)

    exporting(20)()
    assert grown_beyond(exporting(20), exporting(TIMES * 20)) == []


def test_a_file_is_read_in_proportion_to_its_length():
    """The fetch of an MJCF, whose compiled model is taken element by element."""
    mjcf_star(20)
    assert grown_beyond(lambda: mjcf_star(30), lambda: mjcf_star(TIMES * 30)) == []


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_two_thousand_links_are_nothing_special(kind):
    """Nothing calls itself once a link: Python ends at a thousand calls in calls."""
    whole(KINDS[kind](2_000))


def test_a_loop_within_a_loop_would_be_seen():
    """The measure itself, on a stage's function that looks at each pair of names."""

    def every_pair(count):
        names = [{f"n{number}"} for number in range(count)]
        wanted = {f"n{number}": None for number in range(count)}
        return lambda: list(entries_of(names, wanted, "here", "name", Diagnostics()))

    assert grown_beyond(every_pair(10), every_pair(40)) != []
