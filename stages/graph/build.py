"""Runs the graph stage: reads the source, renames bodies, chooses the root, places the links, and then
applies the passes in order."""

from dataclasses import replace

from linkwright.stages.graph.mechanism import Mechanism, MechanismReader
from linkwright.stages.graph.passes.actuation import with_actuation
from linkwright.stages.graph.passes.added_links import with_added_frames, with_added_links
from linkwright.stages.graph.passes.keyframes import with_keyframes
from linkwright.stages.graph.passes.limits.joint_limits import with_limits_and_dynamics
from linkwright.stages.graph.passes.limits.limit_checks import with_checked_limits
from linkwright.stages.graph.passes.limits.placeholders import without_placeholders
from linkwright.stages.graph.passes.link_mass import check_links, with_given_masses, with_least_inertias
from linkwright.stages.graph.passes.mjcf_extras import with_bodies, with_mjcf
from linkwright.stages.graph.passes.mobility import with_mobility
from linkwright.stages.graph.passes.relations import with_relations
from linkwright.stages.graph.passes.rename import rename_mechanism
from linkwright.stages.graph.passes.semantics import with_semantics
from linkwright.stages.graph.passes.total_mass import scale_to_total_mass
from linkwright.stages.graph.passes.zero_pose import with_zero
from linkwright.stages.graph.robot_from_tree import place
from linkwright.stages.graph.section import GraphSections
from linkwright.stages.graph.tree import Tree, spanning_tree
from linkwright.stages.robot.bundle import Bundle
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.errors import AssemblyError
from linkwright.stages.robot.model.robot import Robot


def assemble(bundle: Bundle, keys: GraphSections, read: MechanismReader) -> Robot:
    """Returns the robot in a bundle; raises AssemblyError with all problems at once."""
    log = Diagnostics(optional=keys.optional)
    mechanism, keys = read(bundle, keys, log)
    mechanism = rename_mechanism(mechanism, keys.names, log)
    tree = _tree(mechanism, keys, log)
    robot = with_bodies(place(mechanism, tree, keys, log), mechanism)
    robot = with_added_links(robot, keys.links, log)
    robot = with_limits_and_dynamics(robot, keys.joints, log)
    robot = without_placeholders(robot, log) if mechanism.demands_limits else robot
    robot = with_relations(robot, mechanism.relations, log, keys.relations)
    robot = with_checked_limits(robot, mechanism, keys, log)
    robot = with_given_masses(robot, keys.mass.links, log)
    robot = scale_to_total_mass(robot, keys.mass.total, log)
    check_links(robot, log, mechanism.has_saved_pose)
    robot = with_least_inertias(robot, log)
    robot = with_added_frames(robot, keys.frames.add, log)
    robot = with_zero(robot, keys.zero, keys.joints, log)
    robot = with_mobility(robot, log)
    log.raise_errors()
    robot = with_keyframes(robot, keys.keyframes, log, mechanism.keyframes)
    log.raise_errors()
    robot = with_actuation(robot, mechanism, log)
    robot = with_semantics(robot, mechanism.semantics)
    robot = with_mjcf(robot, mechanism, keys, log)
    return replace(robot, diagnostics=tuple(log.notes))


def _tree(mechanism: Mechanism, keys: GraphSections, log: Diagnostics) -> Tree:
    """Returns the spanning tree. Without a tree no pass can run, so its error also lists the problems so
    far."""
    try:
        return spanning_tree(mechanism, keys, log)
    except AssemblyError as error:
        if not log.problems:
            raise
        message, hint = error.message, error.hint
        if not error.problems:
            # A hint is shown after the problems, but this hint is about the message alone.
            message, hint = f"{message} ({hint})", ""
        raise type(error)(message, error.where, hint, (*log.problems, *error.problems)) from error
