"""Reports what an SRDF cannot express: one diagnostic for each kind of loss."""

from collections.abc import Iterator

from linkwright.stages.export.urdf.srdf.disabled import MOST_LINKS
from linkwright.stages.export.urdf.srdf.model import SrdfPlan
from linkwright.stages.robot.errors import Diagnostic
from linkwright.stages.robot.model.geometry import Geometry
from linkwright.stages.robot.model.robot import Robot


def unsupported(robot: Robot, geometry: Geometry, plan: SrdfPlan) -> Iterator[Diagnostic]:
    """A diagnostic for each kind of loss that this robot has."""
    file = f"{robot.name}.srdf"
    if not geometry.self_contact and any(shape.role == "collision" for shape in geometry.shapes):
        yield Diagnostic(
            "I-SRDF-SELF",
            "the links do not collide with each other (contact.self: none), so it is not known which pairs "
            "always or never touch: MoveIt checks all that no joint joins",
            file,
            "contact.self=auto finds them",
        )
    if not plan.disabled.worked_out:
        yield Diagnostic(
            "I-SRDF-MANY",
            f"more than {MOST_LINKS} links collide, so it is not worked out which of them never meet: MoveIt "
            "checks all pairs that no joint joins",
            file,
        )
    if plan.disabled.partly:
        pairs = "; ".join(f"{one} and {other}" for one, other in plan.disabled.partly)
        yield Diagnostic(
            "I-SRDF-PARTLY",
            "an SRDF knows only whole links, so these do not collide at all, where only some of their "
            f"colliders touch in every pose: {pairs}",
            file,
            "the MJCF leaves out single colliders",
        )
    apart = {pair for pair, _ in plan.disabled.pairs}
    touching = [one for one in geometry.touching if (one.link_a, one.link_b) not in apart]
    if touching:
        pairs = "; ".join(f"{one.link_a} and {one.link_b}" for one in touching)
        yield Diagnostic(
            "I-SRDF-TOUCH",
            f"these touch at home, where MoveIt refuses to plan from: {pairs}",
            file,
            "choose another pose (`keyframes: {home: ...}`), or exclude them (`contact: {exclude: ...}`)",
        )
    free = [joint.name for joint in robot.joints if joint.type == "free"]
    if free:
        yield Diagnostic(
            "I-SRDF-FREE",
            f"no group moves a joint of six degrees of freedom, and no pose has its value: {', '.join(free)}",
            file,
            "MoveIt takes the poses of these links from what publishes their states",
        )
    if plan.loops:
        yield Diagnostic(
            "I-SRDF-LOOP",
            f"MoveIt knows no closed loops and plans as if these were open: {', '.join(plan.loops)}",
            file,
            "joints in them that nothing drives are passive joints, whose states must be published",
        )
