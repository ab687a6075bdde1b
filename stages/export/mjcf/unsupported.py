"""Reports what MJCF cannot express: the cone, effort and zero of ball joints, many classes of contacts; and
which links have no bodies."""

import math
from collections.abc import Iterator, Sequence

from linkwright.stages.export.mjcf.contact.filters import CLASSES
from linkwright.stages.formats.written import Written
from linkwright.stages.robot.errors import Diagnostic
from linkwright.stages.robot.model.robot import Value
from linkwright.stages.robot.motion.adjacency import Pair


def unsupported(written: Written, wide: Sequence[Pair] = ()) -> Iterator[Diagnostic]:
    """One diagnostic for each kind of loss. `wide`: see `Filters`."""
    robot = written.robot
    file = f"{robot.name}.xml"
    balls = [dof for dof in robot.dofs if dof.kind == "ball"]
    cones = [dof.name for dof in balls if dof.limits.upper is not None]
    if cones:
        yield Diagnostic(
            "W-BALL-CONE",
            "MuJoCo's range of a ball joint limits its twist too, which a cone does not, so the MJCF has "
            f"no limit for: {', '.join(cones)}",
            file,
            "enforce the cone in the controller: robot.json has its half angle",
        )
    efforts = [dof.name for dof in balls if dof.dynamics.effort is not None]
    if efforts:
        yield Diagnostic(
            "W-BALL-EFFORT",
            "MuJoCo limits the force of hinges and slides only, so the MJCF has no effort limit for: "
            + ", ".join(efforts),
            file,
            "limit the effort in the controller: robot.json has its value",
        )
    if balls:
        yield Diagnostic(
            "I-BALL-ZERO",
            "a ball joint's q = 0 is its pose at qpos0 in the MJCF, and its mate's zero in the URDF: "
            + ", ".join(f"{dof.name} ({_angle_from_zero(written.start[dof.name])})" for dof in balls),
            file,
            "robot.json has both, under zero of the dof",
        )
    if wide:
        yield Diagnostic(
            "W-WIDE-EXCLUDE",
            f"MuJoCo tells {CLASSES} classes of colliders of the world apart, and more are needed, so these "
            "links do not collide at all, where only some of their colliders should not: "
            + ", ".join(f"{one} and {other}" for one, other in wide),
            file,
            "links with fewer colliders, or others in contact.exclude, leave classes for these",
        )
    into = [f"{link} into {written.as_mjcf.held[link][0]}" for link in written.mjcf_form.fused]
    if into:
        yield Diagnostic(
            "I-MJCF-MERGED",
            f"links on fixed joints are sites of the bodies above them: {', '.join(into)}",
            file,
            "robot.json has the place of each, under fused; export.mjcf.fixed_joints=keep gives each a body",
        )


def _angle_from_zero(start: Value) -> str:
    """How far a ball joint at qpos0 is turned from its mate's zero."""
    assert isinstance(start, tuple)
    angle = math.degrees(2.0 * math.atan2(math.hypot(*start[1:]), abs(start[0])))
    return f"{angle:.4g} deg apart" if angle > 1e-9 else "the same"
