"""Properties of joints: what the user's YAML says of them, and whether their limits make sense."""

import math
from collections.abc import Mapping
from dataclasses import replace
from fnmatch import fnmatchcase

from stages.graph.joints import POSE_TOLERANCE
from stages.graph.keys import JointKeys
from stages.robot.errors import AssemblyError, Diagnostic
from stages.robot.model import Dynamics, Joint, Limits

LOCKED_PLAY = 1e-6
"""Half the range [rad or m] of a joint whose limits are equal: MuJoCo takes none for unlimited."""


def with_properties(joints: tuple[Joint, ...], wanted: Mapping[str, JointKeys]) -> tuple[Joint, ...]:
    """The joints with what `joints:` says about them: later entries win, field by field.

    A glob that matches no joint is an error that lists the joints. A saved angle is then taken by
    whole turns into the limits, where one turn fits.
    """
    lost = [glob for glob in wanted if glob != "*" and not any(fnmatchcase(j.name, glob) for j in joints)]
    if lost:
        msg = f"no joint matches {', '.join(map(repr, lost))}"
        hint = "joints are: " + ", ".join(joint.name for joint in joints)
        raise AssemblyError(msg, where="joints", hint=hint)
    return tuple(unwrapped(_with(joint, wanted)) for joint in joints)


def _with(joint: Joint, wanted: Mapping[str, JointKeys]) -> Joint:
    limits, dynamics = joint.limits, joint.dynamics
    for glob, keys in wanted.items():
        if not fnmatchcase(joint.name, glob):
            continue
        if keys.limits is not None:
            limits = Limits(*keys.limits)
        given = {key: getattr(keys, key) for key in Dynamics.__slots__}
        dynamics = replace(dynamics, **{key: value for key, value in given.items() if value is not None})
    return replace(joint, limits=limits, dynamics=dynamics)


def unwrapped(joint: Joint) -> Joint:
    """The joint with its saved value taken by whole turns into its limits, where one turn fits."""
    if joint.type != "revolute":
        return joint
    low, high = _ends(joint)
    turns = sorted(range(-3, 4), key=abs)
    fits = [joint.saved + math.tau * count for count in turns]
    saved = next((v for v in fits if low - POSE_TOLERANCE <= v <= high + POSE_TOLERANCE), joint.saved)
    return replace(joint, saved=saved)


def _ends(joint: Joint) -> tuple[float, float]:
    low = -math.inf if joint.limits.lower is None else joint.limits.lower
    high = math.inf if joint.limits.upper is None else joint.limits.upper
    return low, high


def check_limits(
    joints: tuple[Joint, ...],
    unknown: Mapping[str, str],
    found: list[Diagnostic],
    problems: list[Diagnostic],
) -> tuple[Joint, ...]:
    """Tells what limits lack or contradict; gives locked joints the little play that engines need.

    `unknown`: why limits that CAD has are not known, by joint.
    """
    return tuple(_checked(joint, unknown.get(joint.name), found, problems) for joint in joints)


def _checked(joint: Joint, unknown: str | None, found: list[Diagnostic], problems: list[Diagnostic]) -> Joint:
    low, high = _ends(joint)
    unit = "rad" if joint.type == "revolute" else "m"
    settle = f"joints: {{{joint.name}: {{limits: [low, high]}}}}  # {unit}"
    if low > high:
        text = f"the lower limit {low:.6g} is above the upper {high:.6g}"
        problems.append(Diagnostic("E-LIMIT", text, joint.name, f"mend the mate, or {settle}"))
        return joint
    if unknown:
        text = f"its limits in CAD are not known: {unknown}"
        found.append(Diagnostic("W-LIMIT", text, joint.name, f"set them on the mate, or {settle}"))
    elif math.isinf(low) and math.isinf(high):
        text = "the joint has no limits" + (": it turns freely" if joint.type == "revolute" else "")
        found.append(Diagnostic("W-LIMIT", text, joint.name, f"set them on the mate, or {settle}"))
    if not low - POSE_TOLERANCE <= joint.saved <= high + POSE_TOLERANCE:
        text = f"the saved pose has it at {joint.saved:.6g}, outside its limits [{low:.6g}, {high:.6g}]"
        hint = "move it back in Onshape, or mend the limits"
        found.append(Diagnostic("W-SAVED-POSE", text, joint.name, hint))
    if low == high:
        text = f"the joint is locked at {low:.6g}: it keeps a play of {LOCKED_PLAY:g} {unit} either way"
        found.append(Diagnostic("W-LIMIT-LOCKED", text, joint.name, "FASTEN the mate to make one link of it"))
        return replace(joint, limits=Limits(low - LOCKED_PLAY, high + LOCKED_PLAY))
    return joint
