"""Checks at sampled poses that the robot's colliders touch each other exactly where its visual shapes do."""

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

from linkwright.stages.robot.check import Check, CheckLevel, Finding, Table
from linkwright.stages.robot.text.plural import count
from linkwright.stages.validate.checks.contact.contact_filter import TAGS
from linkwright.stages.validate.compiled import CompiledModel
from linkwright.stages.validate.contact_errors import PairErrors, contact_errors
from linkwright.stages.validate.findings import few, named

MAX_POSES = 300
"""Largest number of poses sampled in the robot's range, in addition to `home`."""

MAX_LINK_POSES, MIN_POSES = 20_000, 4
"""Largest product of links and poses, to bound the time for large robots; and the smallest number of poses in
spite of it."""

MIN_SHARE, MIN_COUNT = 0.01, 3
"""A pair is reported if its contact is wrong in more than this share of the poses, and in at least this
number of poses."""

ERROR_SHARE = 0.2
"""A pair that is wrong in more than this share of the poses is an error: its colliders do not represent the
robot. It stays a warning if the user or the source chose its colliders, or if it is excluded."""

CHOSEN_REASONS = ("Source", "User")
"""Reasons of excludes that the source or the user chose: these links may pass through each other."""

HEADER = (
    "link",
    "other link",
    "false, % of poses",
    "largest distance in these poses, mm",
    "missed, % of poses",
    "depth of false contact at home, mm",
    "excluded",
)


def check(compiled: CompiledModel) -> Iterator[Check]:
    """Checks robots whose links collide with each other. Files to which the user's own XML adds contact
    elements are skipped. The table lists each pair that is wrong in at least one pose."""
    geometry = compiled.geometry
    if geometry is None or not geometry.self_contact:
        return
    if any(TAGS & {*change.sets, *change.added_tags} for change in compiled.written.amendments.changes):
        return
    poses = max(MIN_POSES, min(MAX_POSES, MAX_LINK_POSES // len(compiled.robot.links)))
    errors = contact_errors(compiled, poses)
    worst = sorted(errors.pairs, key=lambda pair: -max(pair.false_count, pair.missed_count))
    reported = [pair for pair in worst if _is_reported(pair, errors.pose_count)]
    is_error = any(
        _share(pair, errors.pose_count) > ERROR_SHARE and not _is_chosen(compiled, pair) for pair in reported
    )
    sample_text = f"{count(errors.body_count, 'link')} in {count(errors.pose_count, 'pose')} and at home"
    detail = f"{sample_text}: colliders touch exactly where visual shapes do"
    if reported:
        detail = (
            f"{count(len(reported), 'pair')} of links collide although their visual shapes are apart, or do "
            f"not collide although these touch ({sample_text})"
        )
    findings = few(_finding(compiled.model, pair, errors.pose_count) for pair in reported)
    level: CheckLevel = "error" if is_error else "warning"
    result = compiled.within("false contacts", float(len(reported)), 0.0, detail, findings, level)
    rows = tuple(_row(compiled.model, pair, errors.pose_count) for pair in worst)
    yield replace(result, table=Table(HEADER, rows) if rows else None)


def _is_reported(pair: PairErrors, poses: int) -> bool:
    """Tells whether a pair is reported: it falsely overlaps at home, or its contact is wrong in enough of the
    poses. Excludes that the source or the user chose are not reported."""
    wrong_poses = max(pair.false_count, pair.missed_count)
    return pair.reason not in CHOSEN_REASONS and (
        pair.home_depth > 0.0 or (wrong_poses >= MIN_COUNT and wrong_poses > MIN_SHARE * poses)
    )


def _share(pair: PairErrors, poses: int) -> float:
    """Returns the share of the poses in which the contact of a pair is wrong: false, or missed, if that is
    more."""
    return max(pair.false_count, pair.missed_count) / max(1, poses)


def _is_chosen(compiled: CompiledModel, pair: PairErrors) -> bool:
    """Tells whether the user or the source chose the colliders of either body, or the pair is excluded, which
    was reported when it was excluded."""
    geometry = compiled.geometry
    assert geometry is not None
    bodies = {compiled.model.body(body).name for body in pair.bodies}
    names = bodies | {link for link, (holder, _) in compiled.held.items() if holder in bodies}
    makers = {collider.maker for collider in geometry.colliders if collider.link in names}
    return geometry.by_source or pair.reason is not None or makers != {"ladder"}


def _finding(model: Any, pair: PairErrors, poses: int) -> Finding:
    first, second = (model.body(body).name for body in pair.bodies)
    texts = []
    if pair.false_count:
        distance = f"up to {_mm(pair.max_distance)} apart"
        texts.append(
            f"collide in {pair.false_count} of {poses} poses in which their visual shapes are {distance}"
        )
    if pair.missed_count:
        texts.append(f"pass through each other in {pair.missed_count} of {poses} poses")
    if pair.home_depth:
        texts.append(f"overlap by {_mm(pair.home_depth)} at home, where their visual shapes are apart")
    return Finding(named("body", first), "geom", f"{first} and {second} {', and '.join(texts)}")


def _row(model: Any, pair: PairErrors, poses: int) -> tuple[str | float | None, ...]:
    names = (model.body(body).name for body in pair.bodies)
    shares = [round(100.0 * number / max(1, poses), 1) for number in (pair.false_count, pair.missed_count)]
    lengths = [round(1e3 * length, 2) for length in (pair.max_distance, pair.home_depth)]
    return (*names, shares[0], lengths[0], shares[1], lengths[1], pair.reason or "")


def _mm(length: float) -> str:
    return f"{1e3 * length:.2g} mm"
