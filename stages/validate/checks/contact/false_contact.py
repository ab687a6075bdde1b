"""The robot's colliders touch each other where what is seen of them does, over poses within the limits."""

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

from linkwright.stages.robot.check import Check, CheckLevel, Finding, Table
from linkwright.stages.robot.text.plural import count
from linkwright.stages.validate.checks.contact.contact_filter import TAGS
from linkwright.stages.validate.compiled import CompiledModel
from linkwright.stages.validate.contact_errors import PairErrors, contact_errors
from linkwright.stages.validate.findings import few, named

POSES = 300
"""So many poses stand for the robot's range, beside `home`."""

PLACED, FEWEST = 20_000, 4
"""The most links times poses: of a larger robot fewer poses stand for the range."""

SHARE, LEAST = 0.01, 3
"""A pair is named that is wrong in a larger share of the poses, and in so many at least."""

PLAIN = 0.2
"""Where a pair is wrong in a larger share, the colliders are no image of the robot: an error, unless the
colliders or the exclude are the user's or the source's choice."""

GIVEN = ("Source", "User")
"""Excludes that are a choice: that such links pass through each other is meant."""

HEADER = (
    "link",
    "other link",
    "false, % of poses",
    "then apart by at most, mm",
    "missed, % of poses",
    "false at home, mm deep",
    "excluded",
)


def check(compiled: CompiledModel) -> Iterator[Check]:
    """Of a robot whose links collide with each other, as the build wrote it; a table has every pair that is
    wrong in any pose. What the user's own XML says of contact is the user's."""
    geometry = compiled.geometry
    if geometry is None or not geometry.self_contact:
        return
    if any(TAGS & {*one.sets, *one.added_tags} for one in compiled.written.amendments.changes):
        return
    poses = max(FEWEST, min(POSES, PLACED // len(compiled.robot.links)))
    found = contact_errors(compiled, poses)
    worst = sorted(found.pairs, key=lambda pair: -max(pair.false, pair.missed))
    wrong = [pair for pair in worst if _is_wrong(pair, found.poses)]
    plain = any(_share(pair, found.poses) > PLAIN and not _is_chosen(compiled, pair) for pair in wrong)
    looked = f"{count(found.bodies, 'link')} in {count(found.poses, 'pose')} and at home"
    detail = f"{looked}: they touch where what is seen of them does"
    if wrong:
        detail = f"{count(len(wrong), 'pair')} of links, of {looked}: contact is not that of what is seen"
    findings = few(_finding(compiled.model, pair, found.poses) for pair in wrong)
    level: CheckLevel = "error" if plain else "warning"
    result = compiled.within("false contacts", float(len(wrong)), 0.0, detail, findings, level)
    rows = tuple(_row(compiled.model, pair, found.poses) for pair in worst)
    yield replace(result, table=Table(HEADER, rows) if rows else None)


def _is_wrong(pair: PairErrors, poses: int) -> bool:
    most = max(pair.false, pair.missed)
    return pair.reason not in GIVEN and (pair.at_home > 0.0 or (most >= LEAST and most > SHARE * poses))


def _share(pair: PairErrors, poses: int) -> float:
    return max(pair.false, pair.missed) / max(1, poses)


def _is_chosen(compiled: CompiledModel, pair: PairErrors) -> bool:
    """Whether the colliders of one of the two are as the user or the source has them, or the exclude was
    reported when it was made."""
    geometry = compiled.geometry
    assert geometry is not None
    bodies = {compiled.model.body(body).name for body in pair.bodies}
    names = bodies | {link for link, (holder, _) in compiled.held.items() if holder in bodies}
    makers = {one.maker for one in geometry.colliders if one.link in names}
    return geometry.by_source or pair.reason is not None or makers != {"ladder"}


def _finding(model: Any, pair: PairErrors, poses: int) -> Finding:
    one, other = (model.body(body).name for body in pair.bodies)
    said = []
    if pair.false:
        said.append(f"collide in {pair.false} of {poses} poses where they are up to {_mm(pair.apart)} apart")
    if pair.missed:
        said.append(f"pass through each other in {pair.missed} of {poses} poses")
    if pair.at_home:
        said.append(f"are {_mm(pair.at_home)} in each other at home, where they stand apart")
    return Finding(named("body", one), "geom", f"{one} and {other} {', and '.join(said)}")


def _row(model: Any, pair: PairErrors, poses: int) -> tuple[str | float | None, ...]:
    names = (model.body(body).name for body in pair.bodies)
    shares = [round(100.0 * number / max(1, poses), 1) for number in (pair.false, pair.missed)]
    lengths = [round(1e3 * length, 2) for length in (pair.apart, pair.at_home)]
    return (*names, shares[0], lengths[0], shares[1], lengths[1], pair.reason or "")


def _mm(length: float) -> str:
    return f"{1e3 * length:.2g} mm"
