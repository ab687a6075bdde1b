"""The main flow of the graph stage."""

from collections.abc import Iterable
from dataclasses import replace

from stages.graph.added import with_added_frames, with_added_links
from stages.graph.keys import GraphKeys
from stages.graph.massing import check_links, with_given_masses
from stages.graph.mechanism import Coupling
from stages.graph.mobility import with_mobility
from stages.graph.notes import Notes
from stages.graph.onshape.drawing import read_drawing
from stages.graph.place import place
from stages.graph.properties import check_limits, tell_loops, with_properties
from stages.graph.relations import with_relations
from stages.graph.renames import renamed
from stages.graph.tree import spanning_tree
from stages.graph.zero import zeroed
from stages.robot.bundle import Bundle
from stages.robot.model import Limits, Robot


def assemble(bundle: Bundle, keys: GraphKeys) -> Robot:
    """Reads, names, roots and places; then passes over the robot. All problems are told at once."""
    notes = Notes()
    mechanism, keys = read_drawing(bundle, keys, notes)
    mechanism = renamed(mechanism, keys.names, notes)
    drawn = place(mechanism, spanning_tree(mechanism, keys, notes), keys, notes)
    robot = with_added_links(drawn, keys.links, notes)
    robot = with_properties(robot, keys.joints, notes)
    robot = with_relations(robot, mechanism.bonds, notes)
    unknown = _unknown(mechanism.couplings, drawn, robot)
    robot = check_limits(robot, unknown, notes, keys.joints)
    tell_loops(robot, unknown, notes)
    robot = with_given_masses(robot, keys.mass.links, notes)
    check_links(robot, notes)
    robot = with_added_frames(robot, keys.frames.add, notes)
    if keys.zero == "saved":
        robot = zeroed(robot, notes)
    robot = with_mobility(robot, notes)
    notes.settle()
    return replace(robot, diagnostics=tuple(notes.found))


def _unknown(couplings: Iterable[Coupling], drawn: Robot, robot: Robot) -> dict[str, str]:
    """Why limits are not known, by dof, of the dofs to which YAML gave none either."""
    before, after = _limits(drawn), _limits(robot)
    return {
        dof.name: coupling.unknown
        for coupling in couplings
        if coupling.unknown
        for dof in coupling.dofs
        if after.get(dof.name) == before.get(dof.name)
    }


def _limits(robot: Robot) -> dict[str, Limits]:
    loops = (dof for loop in robot.loops for dof in loop.dofs)
    return {dof.name: dof.limits for dof in (*robot.dofs, *loops)}
