"""Nothing in the build's own code runs faster up than the assembly does: lines are counted, not seconds."""

import sys
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory
from types import FrameType
from typing import Any

import numpy as np
import pytest

from linkwright.stages.export import export
from linkwright.stages.graph import build_robot
from linkwright.stages.mesh.collide.primitives import shapes as primitive_shapes
from linkwright.stages.robot.bundle import Bundle
from linkwright.stages.robot.codec import decode_robot, encode_robot
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

Line = tuple[str, int]


def lines_run(work: Callable[[], object]) -> Counter[Line]:
    """How often each line of the stages runs in `work`; a loop on one line counts every time round."""
    counts: Counter[Line] = Counter()

    def local(frame: FrameType, event: str, _: Any) -> Any:
        if event == "line":
            counts[frame.f_code.co_filename, frame.f_lineno] += 1
        return local

    def enter(frame: FrameType, event: str, _: Any) -> Any:
        return local if frame.f_code.co_filename.startswith(STAGES) else None

    before = sys.gettrace()
    sys.settrace(enter)
    try:
        work()
    finally:
        sys.settrace(before)
    return counts


def whole(bundle: Bundle) -> None:
    """The graph stage with all that it writes, and the export."""
    plan = plan_of()
    robot = build_robot(bundle, plan)
    views(robot)
    export(decode_robot(encode_robot(robot)), NO_MESHES, plan)


def urdf_of(count: int, kind: str, inside: str = "", masses: bool = True, star: bool = False) -> Bundle:
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


def fixed_chain(size: int) -> Bundle:
    return urdf_of(size, "fixed")


def dummy_chain(size: int) -> Bundle:
    """Links without mass become frames."""
    return urdf_of(size, "fixed", masses=False)


def dummy_star(size: int) -> Bundle:
    return urdf_of(size, "fixed", masses=False, star=True)


def carrier_chain(size: int) -> Bundle:
    """Links without mass stand between joints."""
    return urdf_of(2 * (size // 2), "continuous", masses=False)


def mimic_chain(size: int) -> Bundle:
    return urdf_of(size, "continuous", '<mimic joint="j{}"/>')


def mjcf_star(size: int) -> Bundle:
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

FILES = [fixed_chain, dummy_chain, dummy_star, carrier_chain, mimic_chain, mjcf_star]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("make", "size"),
    [
        pytest.param(large, 3, marks=pytest.mark.slow),
        (chain, 30),
        (star, 20),
        (screws, 30),
        pytest.param(ladder, 10, marks=pytest.mark.slow),
        (gears, 20),
        *((make, 60 if make is dummy_chain else 20) for make in FILES),
    ],
    ids=lambda it: getattr(it, "__name__", ""),
)
def test_no_line_runs_more_often_than_the_assembly_grows(make: Callable[[int], Bundle], size: int) -> None:
    small, big = make(size), make(TIMES * size)
    whole(small)  # imports, and what is remembered of them
    before, after = lines_run(lambda: whole(small)), lines_run(lambda: whole(big))
    grown = {line: (before[line], count) for line, count in after.items() if count > FEW}
    assert grown, "nothing was counted"
    beyond = {line: pair for line, pair in grown.items() if pair[1] > MOST * pair[0]}
    shown = [f"{file}:{line} {first} -> {then}" for (file, line), (first, then) in sorted(beyond.items())]
    assert not shown, "\n".join(shown)


def test_the_shapes_of_links_are_written_in_proportion_to_their_number() -> None:
    """A chain with a ball on each link, every third of them on a fixed joint."""

    def exported(size: int) -> Counter[Line]:
        names = ["base", *(f"l{number}" for number in range(size))]
        kinds = ["fixed" if number % 3 == 0 else "revolute" for number in range(size)]
        rows = [joint(kind, a, b) for kind, a, b in zip(kinds, names, names[1:], strict=False)]
        ball = (Primitive("sphere", (0.01,), frozen(np.eye(4))),)
        robot = robot_with(rows, shapes=dict.fromkeys(names, ball))
        geometry = Geometry(tuple(one for link in robot.links for one in primitive_shapes(link)), {})
        plan = plan_of(actuators={})
        return lines_run(lambda: export(robot, geometry, plan))

    exported(20)
    before, after = exported(20), exported(TIMES * 20)
    beyond = [
        (line, before[line], count)
        for line, count in after.items()
        if count > FEW and count > MOST * before[line]
    ]
    assert beyond == []
    assert max(after.values()) > FEW


def test_a_file_is_read_in_proportion_to_its_length() -> None:
    """The fetch of an MJCF, whose compiled model is taken element by element."""
    mjcf_star(20)
    before, after = lines_run(lambda: mjcf_star(30)), lines_run(lambda: mjcf_star(TIMES * 30))
    beyond = [line for line, count in after.items() if count > FEW and count > MOST * before[line]]
    assert beyond == []
    assert max(after.values()) > FEW


@pytest.mark.slow
@pytest.mark.parametrize("make", FILES[:-1], ids=lambda it: it.__name__)
def test_two_thousand_links_are_nothing_special(make: Callable[[int], Bundle]) -> None:
    """Nothing calls itself once a link: Python ends at a thousand calls in calls."""
    whole(make(2_000))


def test_a_loop_within_a_loop_would_be_seen() -> None:
    """The measure itself, on a stage's function that looks at each pair of names."""
    from linkwright.stages.graph.globs import entries_of
    from linkwright.stages.robot.diagnostics import Diagnostics

    def every_pair(count: int) -> Counter[Line]:
        names = [{f"n{number}"} for number in range(count)]
        wanted = {f"n{number}": None for number in range(count)}
        return lines_run(lambda: list(entries_of(names, wanted, "here", "name", Diagnostics())))

    before, after = every_pair(10), every_pair(40)
    assert max(after[line] / before[line] for line in after if after[line] > FEW) > MOST
