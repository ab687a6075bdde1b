"""Checks that an MJCF closes the robot's loops by the right equalities, between the right bodies and frames.

A URDF can close loops only by its relations. It has a link for each of the two frames that must meet.
"""

import math
from collections import Counter
from collections.abc import Iterator
from typing import Any

import mujoco
import numpy as np

from linkwright.stages.robot.check import Check, Finding
from linkwright.stages.robot.model.mjcf_extras import NO_EXTRAS
from linkwright.stages.robot.model.robot import Loop, Value
from linkwright.stages.robot.motion.dof_ranges import ranges
from linkwright.stages.robot.motion.loops import MAX_CLOSED_GAP, gap
from linkwright.stages.robot.text.plural import count
from linkwright.stages.validate.compiled import CompiledModel
from linkwright.stages.validate.findings import few, named, shown
from linkwright.stages.validate.model.coordinates import link_pose, saved_values, set_values
from linkwright.stages.validate.model.equalities import bodies, ends, solver_differences
from linkwright.stages.validate.read.compiled import read_compiled
from linkwright.stages.validate.same.loops import compare_loops

POSES = 9
"""Number of poses at which a URDF's loops are checked."""

CONNECT, WELD = int(mujoco.mjtEq.mjEQ_CONNECT), int(mujoco.mjtEq.mjEQ_WELD)
EQUALITIES_BY_TYPE = {"revolute": (CONNECT, 2), "ball": (CONNECT, 1)}
"""Type of loop → its equalities (kind, number). Loops of other types have a single weld."""


def check(compiled: CompiledModel) -> Iterator[Check]:
    """Compares the equalities of an MJCF, and the frames that they join. For a URDF, measures the loops that
    it closes by relations, and compares its frames of loops."""
    if compiled.urdf:
        if compiled.written.urdf_form.closed:
            yield _closed_by_relations(compiled)
        yield from compare_loops(read_compiled(compiled), "frames of loops")
        return
    robot, model = compiled.robot, compiled.model
    closures = Counter(
        (int(kind), bodies(model, index))
        for index, kind in enumerate(model.eq_type[: model.neq - compiled.surplus.equalities])
        if int(kind) in (CONNECT, WELD)
    )
    expected: Counter[tuple[int, frozenset[int]]] = Counter()
    for loop in robot.loops:
        kind, number = EQUALITIES_BY_TYPE.get(loop.type, (WELD, 1))
        expected[kind, frozenset(ends(model, loop))] += number
    wrong = sum((closures - expected).values()) + sum((expected - closures).values())
    detail = f"{count(len(robot.loops), 'loop')}, each closed between its links by the equalities of its type"
    findings = few(_equality_findings(compiled)) if wrong else ()
    yield compiled.within("loops", float(wrong), 0.0, detail, findings)
    if robot.loops and not wrong:
        yield from compare_loops(read_compiled(compiled), "frames of loops")
        yield _stiffness_check(compiled)


def _equality_findings(compiled: CompiledModel) -> Iterator[Finding]:
    """Yields the loops with too few equalities, and the equalities that close no loop."""
    model, matched = compiled.model, []
    indices = range(model.neq - compiled.surplus.equalities)
    equalities = [index for index in indices if int(model.eq_type[index]) in (CONNECT, WELD)]
    for loop in compiled.robot.loops:
        kind, number = EQUALITIES_BY_TYPE.get(loop.type, (WELD, 1))
        between = frozenset(ends(model, loop))
        matches = [
            index
            for index in equalities
            if int(model.eq_type[index]) == kind and between == bodies(model, index)
        ]
        matched += matches
        if len(matches) != number:
            element = named("weld" if kind == WELD else "connect", loop.name)
            message = f"{len(matches)} of the {number} that close {loop.link_a} and {loop.link_b} are there"
            yield Finding(element, "site1, site2", message)
    for index in equalities:
        if index not in matched:
            element = named(_kind(model, index), model.equality(index).name)
            names = " and ".join(model.body(body).name for body in sorted(bodies(model, index)))
            message = f"is between {names}, where the robot has no loop that it closes"
            yield Finding(element, "site1, site2", message)


def _stiffness_check(compiled: CompiledModel) -> Check:
    """Checks that the equalities of loops are active, and as stiff as the robot's."""
    robot, model, findings = compiled.robot, compiled.model, []
    source_attributes = (robot.mjcf or NO_EXTRAS).attributes_of("equality")
    for index, loop in _closing_equalities(compiled):
        element = named(_kind(model, index), model.equality(index).name)
        if not model.eq_active0[index] and not compiled.sets("active"):
            findings.append(Finding(element, "active", f"is false: the loop {loop.name} is open"))
        findings += solver_differences(
            compiled, index, element, loop.solref, source_attributes.get(loop.name)
        )
    detail = (
        f"{count(len(robot.loops), 'loop')}, held by equalities that are active and as stiff as they must be"
    )
    if findings:
        detail = f"held too loosely: {', '.join(dict.fromkeys(finding.element for finding in findings))}"
    return compiled.within("loops are held", float(len(findings)), 0.0, detail, few(findings))


def _closing_equalities(compiled: CompiledModel) -> Iterator[tuple[int, Loop]]:
    """Yields the equalities between the bodies of loops, each with its loop."""
    model = compiled.model
    pairs = {frozenset(ends(model, loop)): loop for loop in compiled.robot.loops}
    for index in range(model.neq - compiled.surplus.equalities):
        if int(model.eq_type[index]) in (CONNECT, WELD) and bodies(model, index) in pairs:
            yield index, pairs[bodies(model, index)]


def _kind(model: Any, index: int) -> str:
    return "weld" if int(model.eq_type[index]) == WELD else "connect"


def _closed_by_relations(compiled: CompiledModel) -> Check:
    """Checks the gaps of the loops that the URDF closes, with all drivers at the same share of their ranges
    and all followers where the relations put them."""
    robot, model = compiled.robot, compiled.model
    data = mujoco.MjData(model)
    limits = ranges(robot)
    closed = [loop for loop in robot.loops if loop.name in compiled.written.urdf_form.closed]
    worst, worst_loop = 0.0, ""
    for share in np.linspace(0.0, 1.0, POSES):
        q = saved_values(robot)
        for relation in robot.relations:
            q[relation.driver] = _between(limits[relation.driver], q[relation.driver], float(share))
        for relation in robot.relations:
            driver = q[relation.driver]
            assert not isinstance(driver, tuple)
            q[relation.follower] = relation.multiplier * driver + relation.offset
        set_values(model, data, robot, q, urdf=True)
        poses = {link.name: link_pose(model, data, robot, link.name) for link in robot.links}
        for loop in closed:
            loop_gap = gap(loop, poses)
            # A gap of NaN is the worst, and stays it.
            if not loop_gap <= worst:
                worst, worst_loop = loop_gap, loop.name
    allowed = max(MAX_CLOSED_GAP, *(2 * loop.residual for loop in closed))
    detail = f"loops that mimic joints close, over the range of their drivers [m, rad]; worst: {worst_loop}"
    findings = [
        Finding(
            named("joint", relation.follower), "mimic", f"{worst_loop} is open by {shown(worst)} m or rad"
        )
        for relation in robot.relations
    ]
    return compiled.within("loops", worst, allowed, detail, few(findings))


def _between(ends: tuple[float, float], near: Value, share: float) -> Value:
    """Returns the value at a share (0 to 1) of a range. An end without a limit is 0.5 rad or m from
    `near`."""
    assert not isinstance(near, tuple)
    low, high = (
        end if math.isfinite(end) else near + side for end, side in zip(ends, (-0.5, 0.5), strict=True)
    )
    return low + share * (high - low)
