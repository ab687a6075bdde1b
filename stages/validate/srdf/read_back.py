"""Runs the checks of an SRDF."""

from collections.abc import Iterator
from pathlib import Path

from linkwright.stages.formats.written import Written
from linkwright.stages.formats.xml import Malformed, parse
from linkwright.stages.robot.check import Check
from linkwright.stages.validate.findings import few
from linkwright.stages.validate.reading.documents import sentence
from linkwright.stages.validate.srdf.base import base_findings, passive_joint_findings
from linkwright.stages.validate.srdf.groups import end_effector_findings, group_findings
from linkwright.stages.validate.srdf.pairs import pair_findings
from linkwright.stages.validate.srdf.read_srdf import ReadSrdf
from linkwright.stages.validate.srdf.references import reference_findings
from linkwright.stages.validate.srdf.states import state_findings

CHECKS = {
    "names": (reference_findings, "every link, joint and group that it names exists"),
    "base": (base_findings, "the robot's name, and the joint by which it is in the world"),
    "groups": (group_findings, "chains to each frame, and a group of every joint"),
    "end effectors": (end_effector_findings, "each is what its parent link carries"),
    "poses": (state_findings, "each group at `home` and at the keyframes of the robot"),
    "passive joints": (passive_joint_findings, "those that nothing drives"),
    "disabled collisions": (
        pair_findings,
        "the pairs of links that the robot keeps from colliding, with the reasons",
    ),
}
"""Name of a check → its function, and the message without findings; in the order of the report."""


def check_file(path: Path, written: Written, *, quick: bool) -> Iterator[Check]:
    """Yields the results of `CHECKS`. It yields nothing if `quick`, or for a file that is not XML, which
    another check reports."""
    try:
        root = parse(path.read_bytes())
    except Malformed:
        return
    if quick:
        return
    read = ReadSrdf(root, written)
    for name, (function, passed) in CHECKS.items():
        findings = list(function(read))
        detail = sentence(tuple(findings)) if findings else passed
        yield Check(
            f"{path.name}: {name}", not findings, detail, float(len(findings)), 0.0, findings=few(findings)
        )
