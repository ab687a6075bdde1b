"""Reports what URDF cannot express: one diagnostic for each kind of loss."""

from collections.abc import Callable, Iterator

from linkwright.stages.export.urdf.lowering import lower, unset
from linkwright.stages.formats.numbers import number
from linkwright.stages.formats.urdf.form import UrdfForm
from linkwright.stages.formats.urdf.names import urdf_names, urdf_steps
from linkwright.stages.formats.written import Written
from linkwright.stages.robot.dynamics.fusing import Holders
from linkwright.stages.robot.dynamics.inertia import NEXT_TO_NOTHING
from linkwright.stages.robot.errors import Diagnostic
from linkwright.stages.robot.model.geometry import Geometry
from linkwright.stages.robot.model.robot import Robot
from linkwright.stages.robot.motion.linear_coupling import LinearCoupling


def unsupported(written: Written) -> Iterator[Diagnostic]:
    """A diagnostic for each kind of loss that this robot has, in the order of the table; and of what the
    form of its URDF changes."""
    file = f"{written.robot.name}.urdf"
    for loss in LOSSES:
        yield from loss(written.as_urdf.robot, file)
    yield from _loops(written.robot, written.urdf_form, file)
    yield from _merged(written.as_urdf.held, file)
    yield from _contacts(written.shapes, file)


def _several_dofs(robot: Robot, file: str) -> Iterator[Diagnostic]:
    several = [
        f"{item.joint.name} ({item.joint.type}: {', '.join(part.name for part in item.joints)})"
        for item in lower(robot, [joint for joint in robot.joints if urdf_steps(joint) > 1])
    ]
    if several:
        yield Diagnostic(
            "I-URDF-LOWERED",
            "a URDF joint has one degree of freedom, so each of these is several joints, with links of "
            f"{number(NEXT_TO_NOTHING)} kg between them: " + "; ".join(several),
            file,
            "the MJCF needs no such links; robot.json lists them under lowered",
        )


def _cones(robot: Robot, file: str) -> Iterator[Diagnostic]:
    cones = [dof.name for dof in robot.dofs if dof.kind == "ball" and dof.limits.upper is not None]
    if cones:
        yield Diagnostic(
            "W-BALL-CONE",
            f"URDF cannot limit the tilt of a ball joint, so these tilt freely: {', '.join(cones)}",
            file,
            "enforce the cone in the controller: robot.json has its half angle",
        )


def _floating(robot: Robot, file: str) -> Iterator[Diagnostic]:
    floating = [joint.name for joint in robot.joints if joint.type == "free"]
    if floating:
        yield Diagnostic(
            "I-URDF-FREE",
            f"many URDF readers ignore joints of type floating, or fix them: {', '.join(floating)}",
            file,
            "use the MJCF where these links must move; of a URDF, MuJoCo accepts a floating joint only "
            "below a root link named world",
        )


def _loops(robot: Robot, form: UrdfForm, file: str) -> Iterator[Diagnostic]:
    if not robot.loops:
        return
    names = [loop.name for loop in robot.loops if loop.name not in form.closed]
    said = ["URDF has no loops"]
    if form.closed:
        said.append(f"closed by <mimic> joints alone: {', '.join(form.closed)}")
    if form.mimics:
        said.append(f"exact along the loops: {'; '.join(map(_line, form.mimics))}")
    if names:
        said.append(f"open, with a frame on either side (<name>_a, <name>_b): {', '.join(names)}")
    nearly = [f"{_line(one)}, off by up to {one.error:.2g}" for one in form.couplings if not one.exact]
    if nearly:
        said.append(f"not linear, so the best line is no <mimic>: {'; '.join(nearly)}")
    hint = "the MJCF closes them; robot.json has them under loops, and what follows what under couplings"
    yield Diagnostic("I-URDF-LOOP", ". ".join(said), file, hint)


def _line(one: LinearCoupling) -> str:
    """A coupling as an equation."""
    offset = "" if abs(one.offset) < 1e-6 else f" {'-' if one.offset < 0 else '+'} {abs(one.offset):.6g}"
    return f"{one.follower} = {one.multiplier:.6g} {one.driver}{offset}"


def _armatures(robot: Robot, file: str) -> Iterator[Diagnostic]:
    rotors = [dof.name for dof in robot.dofs if dof.dynamics.armature]
    if rotors:
        yield Diagnostic(
            "I-URDF-ARMATURE",
            f"URDF has no armature (rotor inertia), so it is left out of these joints: {', '.join(rotors)}",
            file,
            "use the MJCF, or armature in robot.json",
        )


def _unset(robot: Robot, file: str) -> Iterator[Diagnostic]:
    missing = {dof.name: unset(dof) for dof in robot.dofs if unset(dof)}
    if missing:
        yield Diagnostic(
            "I-URDF-UNSET",
            "URDF requires limits, efforts and velocities that are not set, so defaults were written "
            "(effort 100, velocity 10, ±1 m, ±2π rad): "
            + "; ".join(f"{name}: {', '.join(keys)}" for name, keys in missing.items()),
            file,
            'set them: joints: {"*": {effort: ..., velocity: ...}}',
        )


def _frame_names(robot: Robot, file: str) -> Iterator[Diagnostic]:
    for frame, name in urdf_names(robot).frames.items():
        if name != frame:
            yield Diagnostic(
                "I-URDF-NAME",
                f"the frame {frame!r} is named {name!r} in the URDF, since a link has its name",
                file,
                "the MJCF keeps the name; robot.json has the URDF's name, under urdf",
            )


def _merged(held: Holders, file: str) -> Iterator[Diagnostic]:
    into = [f"{link} into {holder}" for link, (holder, _) in held.items() if link != holder]
    if into:
        yield Diagnostic(
            "I-URDF-MERGED",
            f"links on fixed joints are merged: {', '.join(into)}",
            file,
            "robot.json has the place of each, under merged; to keep a link there, put a frame on it",
        )


def _contacts(geometry: Geometry, file: str) -> Iterator[Diagnostic]:
    lost = {
        shape.link: list(shape.contact.given())
        for shape in geometry.shapes
        if shape.contact is not None and shape.role == "collision"
    }
    if lost:
        yield Diagnostic(
            "I-URDF-CONTACT",
            "URDF has no properties of contact, so these are left out: "
            + "; ".join(f"{link}: {', '.join(keys)}" for link, keys in lost.items()),
            file,
            "use the MJCF",
        )


LOSSES: tuple[Callable[[Robot, str], Iterator[Diagnostic]], ...] = (
    _several_dofs,
    _cones,
    _floating,
    _armatures,
    _unset,
    _frame_names,
)
