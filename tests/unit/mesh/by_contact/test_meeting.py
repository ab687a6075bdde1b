"""Which links meet the world."""

import numpy as np
import pytest
import trimesh

from linkwright.stages.mesh.by_contact.meeting import with_jaws
from linkwright.stages.mesh.surfaces.convex_hull import convex_hull
from tests.support.robots import at, joint, robot_with
from tests.support.solids import of_mesh

FORK = of_mesh(
    trimesh.util.concatenate(
        [trimesh.creation.box(bounds=[(x, -0.01, -0.1), (x + 0.01, 0.01, 0.0)]) for x in (-0.03, 0.02)]
    )
)
"""Two prongs, 40 mm apart, that point downwards."""

ROD = of_mesh(trimesh.creation.box(bounds=[(-0.005, -0.005, -0.06), (0.005, 0.005, 0.0)]))


def jaws(robot, drops):
    """With the rod this far [m] down, between the prongs or beyond them."""
    surfaces = {"fork": FORK, "rod": ROD}
    poses = {"fork": np.stack([np.eye(4)] * len(drops)), "rod": np.stack([at(0, 0, -drop) for drop in drops])}
    hulls = {"fork": convex_hull(FORK.vertices)}
    return with_jaws(robot, ["rod"], surfaces, hulls, poses, {"fork": 0.002, "rod": 0.002})


@pytest.mark.parametrize(
    ("fixed", "drops", "more"),
    [
        (True, [0.02, 0.03, 0.04], {"fork"}),
        (True, [0.2, 0.21, 0.22], set()),  # it moves below the prongs
        (False, [0.02, 0.03, 0.04], {"fork"}),  # a free robot stands on the prongs
        (False, [0.08, 0.03, 0.04], set()),  # it stands on the rod, which is a foot
    ],
)
def test_the_parent_of_a_finger_is_an_end_and_that_of_a_foot_is_none(fixed, drops, more):
    robot = robot_with([joint("prismatic", "fork", "rod")], root="fork", fixed=fixed)
    assert jaws(robot, drops) == {"rod", *more}
