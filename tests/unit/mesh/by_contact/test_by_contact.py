"""Colliders touch where links touch: a finger in a slot, in MuJoCo and in closed form."""

from dataclasses import replace
from hashlib import sha256

import mujoco
import numpy as np
import pytest
import trimesh

from linkwright.stages.mesh import make_geometry
from linkwright.stages.mesh.by_contact.meeting import with_jaws
from linkwright.stages.mesh.surfaces.convex_hull import convex_hull
from linkwright.stages.robot.bundle import Bundle
from linkwright.stages.robot.errors import MeshError
from linkwright.stages.robot.model.robot import Inertial, Limits, MeshRef, Part, frozen
from tests.support.building import plan_of
from tests.support.exports import compiled, exported
from tests.support.robots import at, joint, robot_with
from tests.support.solids import bodies_of, of_mesh
from tests.support.touching import Memory, no_memo

DEPTH, WIDTH = 0.05, 0.02
"""Depth and width of the slot [m]."""

REACH = 0.06
"""How far the finger goes down from where its tip is at the slot's mouth: 10 mm into the bottom [m]."""

WALLS = [
    ((-0.03, -0.01, -0.06), (-WIDTH / 2, 0.01, 0)),
    ((WIDTH / 2, -0.01, -0.06), (0.03, 0.01, 0)),
    ((-0.03, -0.01, -0.06), (0.03, 0.01, -DEPTH)),
]
"""A block of 60 by 20 by 60 mm with a slot from above, whose mouth is at z = 0."""

MESHES = {
    "post": trimesh.boolean.union([trimesh.creation.box(bounds=wall) for wall in WALLS], engine="manifold"),
    "finger": trimesh.creation.box(bounds=[(-0.005, -0.005, 0), (0.005, 0.005, 0.08)]),
}
REPLY = bodies_of(MESHES)
DIGEST = sha256(REPLY).hexdigest()
BUNDLE = Bundle("onshape", {}, "", {}, {DIGEST: REPLY})


def robot(order=1, lowest=-REACH):
    """A post with the slot, and a finger that slides down into it; both hang on a base that is not seen, and
    something else, without which they would be neighbours."""
    joints = [
        joint("prismatic", "base", "finger", limits={"finger_joint": Limits(lowest, 0.02)}),
        joint("revolute", "base", "post", limits={"post_joint": Limits(-1e-9, 1e-9)}),
        joint("prismatic", "base", "spare"),
    ]
    bare = robot_with(joints[::order], root="base")
    body = Inertial(0.1, frozen([0.0, 0, 0]), frozen(np.eye(3) * 1e-5))
    here = frozen(np.eye(4))
    parts = {
        name: (Part((name,), name, name, MeshRef(DIGEST, name), here, here, body, 0.0),) for name in MESHES
    }
    return replace(bare, links=tuple(replace(link, parts=parts.get(link.name, ())) for link in bare.links))


def made(value=None, memo=no_memo, contact="auto", **mesh):
    plan = plan_of(mesh={"collider": "ladder", **mesh}, contact={"self": contact}, ground={"kind": "none"})
    return make_geometry(robot() if value is None else value, BUNDLE, plan, memo)


def by_link(geometry):
    return {collider.link: collider for collider in geometry.colliders}


def touching(geometry, heights):
    model = compiled(exported(robot(), geometry, contact={"self": "auto"}, ground={"kind": "none"}))
    data = mujoco.MjData(model)
    met = []
    for height in heights:
        data.joint("finger_joint").qpos = height
        mujoco.mj_forward(model, data)
        met.append(data.ncon > 0)
    return np.array(met)


@pytest.fixture(scope="module")
def usual():
    return made()


def test_finger_enters_a_slot_and_meets_its_bottom(usual):
    heights = np.linspace(-REACH, 0.02, 161)
    met = touching(usual, heights)
    # The bottom is at -DEPTH: no contact 2 mm above it, but 2 mm below.
    assert not met[heights > -DEPTH + 0.0021].any()
    assert met[heights < -DEPTH - 0.0001].all()
    assert not any(diagnostic.code == "W-FALSE-CONTACT" for diagnostic in usual.diagnostics)
    assert touching(made(collider="hull"), np.array([-0.03])).all()


def test_report_says_why():
    post, finger = (by_link(made(fine=[]))[name] for name in ("post", "finger"))
    assert (post.rung, 2 <= post.pieces <= 4) == ("pieces", True)
    assert post.reason.startswith(f"{post.pieces} pieces against finger")
    assert (finger.rung, finger.reason) == ("box", "false in at most 0.5 % of 512 poses")


def test_links_that_may_not_collide_are_not_cut():
    assert [collider.pieces for collider in made(contact="none", fine=[]).colliders] == [1, 1]


def test_links_that_meet_the_world_follow_their_surface(usual):
    for collider in usual.colliders:
        assert collider.measures.protrusion_p95 <= collider.tolerance
        assert "meets the world" in collider.reason
    for fine, links in ((["post"], ["post"]), ("all", ["finger", "post"])):
        assert [collider.link for collider in made(fine=fine).colliders if collider.tolerance] == links
    with pytest.raises(MeshError) as caught:
        made(fine=["claw*"])
    assert [(row.code, row.where) for row in caught.value.problems] == [("E-GLOB", "mesh.fine")]


def test_order_of_joints_changes_nothing(usual):
    other = made(robot(order=-1))

    def pieces(geometry, link):
        return [geometry.files[shape.file] for shape in geometry.shapes_of(link, "collision") if shape.file]

    assert all(pieces(usual, link) == pieces(other, link) for link in MESHES)


def test_all_is_kept_under_one_key_and_a_limit_is_part_of_it(usual):
    memo = Memory()
    assert made(memo=memo).colliders == usual.colliders
    made(memo=memo, fine=[])
    made(robot(lowest=0.0), memo, fine=[])
    assert len(set(memo.keys_of("mesh.by_contact"))) == 3


def test_colliders_by_hand_stay_and_others_keep_clear_of_them():
    """The finger is a sphere by hand, too thick for the slot."""
    colliders = by_link(made(colliders={"finger": {"sphere": {"radius": 0.008}}}, fine=[]))
    assert (colliders["finger"].rung, colliders["finger"].reason) == ("sphere", "")
    assert colliders["post"].reason


def test_mesh_that_stays_as_it_is_collides_as_its_hull():
    """An engine fills the slot, which nothing cuts: the pair is named."""
    geometry = made(colliders={"post": "raw"}, fine=[])
    (false,) = [problem for problem in geometry.diagnostics if problem.code == "W-FALSE-CONTACT"]
    assert "finger" in false.message
    assert "post" in false.message


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
def test_parent_of_a_finger_is_an_end_and_that_of_a_foot_is_none(fixed, drops, more):
    robot = robot_with([joint("prismatic", "fork", "rod")], root="fork", fixed=fixed)
    assert jaws(robot, drops) == {"rod", *more}
