"""The main flow of the graph stage."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace

from stages.formats.urdf.transmissions import with_joints
from stages.graph.globs import as_key, fits, listed
from stages.graph.keys import GraphKeys, JointKeys
from stages.graph.mechanism import Coupling, Mechanism
from stages.graph.passes.added_links import with_added_frames, with_added_links
from stages.graph.passes.joint_limits import check_limits, tell_loops, with_properties
from stages.graph.passes.link_mass import check_links, with_given_masses, with_least_inertias
from stages.graph.passes.mobility import with_mobility
from stages.graph.passes.relations import with_relations
from stages.graph.passes.rename import renamed
from stages.graph.passes.zero_pose import zeroed
from stages.graph.robot_from_tree import place
from stages.graph.tree import Tree, spanning_tree
from stages.robot.bundle import Bundle
from stages.robot.diagnostics import Diagnostics
from stages.robot.errors import AssemblyError
from stages.robot.model import Robot, Transmission

Reader = Callable[[Bundle, GraphKeys, Diagnostics], tuple[Mechanism, GraphKeys]]
"""From a bundle to a mechanism; the keys come back with what the source's own conventions imply."""


def _reader(kind: str) -> Reader:
    if kind == "urdf":
        from stages.graph.urdf.reader import read_urdf

        return read_urdf
    if kind == "mjcf":
        from stages.graph.mjcf.reader import read_mjcf

        return read_mjcf
    from stages.graph.onshape.reader import read_drawing

    return read_drawing


def assemble(bundle: Bundle, keys: GraphKeys) -> Robot:
    """Reads, names, roots and places; then passes over the robot. All problems are told at once."""
    log = Diagnostics()
    mechanism, keys = _reader(bundle.kind)(bundle, keys, log)
    mechanism = renamed(mechanism, keys.names, log)
    robot = place(mechanism, _tree(mechanism, keys, log), keys, log)
    if bundle.kind == "urdf" and keys.root.base == "auto" and not robot.base.fixed:
        what = "a URDF does not say whether its base stands still: it is taken as free"
        log.report("I-URDF-BASE", what, robot.root.name, "if it is fixed to the ground: root=fixed")
    robot = with_added_links(robot, keys.links, log)
    robot = with_properties(robot, keys.joints, log)
    robot = with_relations(robot, mechanism.bonds, log, keys.relations)
    unknown = _unknown(mechanism.couplings, keys.joints)
    _tell_doubts(mechanism.couplings, keys.joints, log)
    robot = check_limits(robot, unknown, log, keys.joints, keys.links, mechanism.posed)
    tell_loops(robot, unknown, log)
    robot = with_given_masses(robot, keys.mass.links, log)
    check_links(robot, log, mechanism.posed)
    robot = with_least_inertias(robot, log)
    robot = with_added_frames(robot, keys.frames.add, log)
    if keys.zero == "saved":
        robot = zeroed(robot, log)
    robot = with_mobility(robot, log)
    log.raise_errors()
    controls = _controls(mechanism, robot, log)
    robot = replace(robot, transmissions=_transmissions(mechanism, robot), controls=controls)
    return replace(robot, diagnostics=tuple(log.found))


def _tree(mechanism: Mechanism, keys: GraphKeys, log: Diagnostics) -> Tree:
    """The spanning tree. Nothing comes after what leaves none: its error tells all problems so far."""
    try:
        return spanning_tree(mechanism, keys, log)
    except AssemblyError as error:
        if not log.problems:
            raise
        message, hint = error.message, error.hint
        if not error.problems:
            # A hint comes after the problems: this one is about the message alone.
            message, hint = f"{message} ({hint})", ""
        raise type(error)(message, error.where, hint, (*log.problems, *error.problems)) from error


def _unknown(couplings: Iterable[Coupling], wanted: Mapping[str, JointKeys]) -> dict[str, str]:
    """Why limits are not known, by dof, of the dofs to which YAML gives none either."""
    return {
        name: coupling.unknown
        for coupling in couplings
        if coupling.unknown
        for name in _unsettled(coupling, wanted)
    }


def _tell_doubts(couplings: Iterable[Coupling], wanted: Mapping[str, JointKeys], log: Diagnostics) -> None:
    """What of the limits might be meant another way, where YAML does not give them all."""
    for coupling in couplings:
        for name in _unsettled(coupling, wanted)[:1]:
            settle = f"joints: {{{as_key(name)}: {{limits: [low, high]}}}}"
            for text in coupling.doubts:
                log.report("W-LIMIT-DOUBT", text, coupling.name, f"type it again on the mate, or {settle}")
            for text in coupling.half_open:
                log.report("I-LIMIT-OPEN", text, coupling.name, f"if a zero is meant, type it, or {settle}")


def _unsettled(coupling: Coupling, wanted: Mapping[str, JointKeys]) -> list[str]:
    """The dofs to which YAML gives no limits."""
    given = [glob for glob, keys in wanted.items() if keys.limits is not None]
    return [dof.name for dof in coupling.dofs if not any(fits(dof.name, glob) for glob in given)]


def _transmissions(mechanism: Mechanism, robot: Robot) -> tuple[Transmission, ...]:
    """What drives the joints, by the names that these have now."""
    dofs = {joint.mate.name: joint.dofs[0].name for joint in robot.joints if joint.mate and joint.dofs}
    return tuple(replace(one, joint=dofs[one.joint]) for one in mechanism.transmissions if one.joint in dofs)


def _controls(mechanism: Mechanism, robot: Robot, log: Diagnostics) -> tuple[str, ...]:
    """How the joints are driven, with the names that they have now; W-URDF-CONTROL for a joint that is gone,
    or that is several in a URDF."""
    names = {joint.mate.name: joint.name for joint in robot.joints if joint.mate and len(joint.dofs) < 2}
    found = []
    for text in mechanism.controls:
        changed, lost = with_joints(text, names)
        found += [changed] if changed else []
        if lost:
            what = f"a <transmission> or <ros2_control> names {listed(lost)}, which the robot does not have"
            hint = "name a joint that it has, or take it out"
            log.report("W-URDF-CONTROL", f"{what}: left out", listed(lost), hint)
    return tuple(found)
