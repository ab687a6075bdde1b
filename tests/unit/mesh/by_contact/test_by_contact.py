"""Colliders touch where links touch: a finger in a slot, in MuJoCo and in closed form."""

from collections.abc import Callable
from dataclasses import replace
from hashlib import sha256
from typing import Any

import mujoco
import numpy as np
import pytest
import trimesh

from linkwright.stages.export import export
from linkwright.stages.mesh import make_geometry
from linkwright.stages.robot.bundle import Bundle
from linkwright.stages.robot.errors import MeshError
from linkwright.stages.robot.model.geometry import Geometry
from linkwright.stages.robot.model.robot import Frame, Inertial, Limits, Link, MeshRef, Part, Robot, frozen
from tests.support.building import plan_of
from tests.support.robots import joint, robot_with
from tests.support.solids import bodies_of

DEPTH, WIDTH = 0.05, 0.02
"""Of the slot [m]."""

REACH = 0.06
"""How far the finger goes down from where its tip is at the slot's mouth: 10 mm into the bottom [m]."""


def slotted() -> trimesh.Trimesh:
    """A block of 60 by 20 by 60 mm with a slot from above, whose mouth is at z = 0."""
    boxes = [
        ((-0.03, -0.01, -0.06), (-WIDTH / 2, 0.01, 0)),
        ((WIDTH / 2, -0.01, -0.06), (0.03, 0.01, 0)),
        ((-0.03, -0.01, -0.06), (0.03, 0.01, -DEPTH)),
    ]
    return trimesh.boolean.union([trimesh.creation.box(bounds=one) for one in boxes], engine="manifold")


MESHES = {
    "Block": slotted(),
    "Finger": trimesh.creation.box(bounds=[(-0.005, -0.005, 0), (0.005, 0.005, 0.08)]),
}
REPLY = bodies_of(MESHES)
DIGEST = sha256(REPLY).hexdigest()
BUNDLE = Bundle("onshape", {}, "", {}, {DIGEST: REPLY})


def robot(*frames: Frame, turned: bool = False) -> Robot:
    """A post with the slot, and a finger that slides down into it; both hang on a base that is not seen, and
    something else, without which they would be neighbours."""
    joints = [
        joint("prismatic", "base", "finger", limits={"finger_joint": Limits(-REACH, 0.02)}),
        joint("revolute", "base", "post", limits={"post_joint": Limits(-1e-9, 1e-9)}),
        joint("prismatic", "base", "spare"),
    ]
    made = robot_with(joints[::-1] if turned else joints, root="base")
    body = Inertial(0.1, frozen([0.0, 0, 0]), frozen(np.eye(3) * 1e-5))
    here = frozen(np.eye(4))

    def with_part(link: Link) -> Link:
        name = {"finger": "Finger", "post": "Block"}.get(link.name)
        if name is None:
            return link
        return replace(link, parts=(Part((name,), name, name, MeshRef(DIGEST, name), here, here, body, 0.0),))

    return replace(made, links=tuple(map(with_part, made.links)), frames=frames)


def made(
    value: Robot, memo: Callable[[str, Any, Callable[[], bytes]], bytes] | None = None, **mesh: Any
) -> tuple[Geometry, Any]:
    plan = plan_of(mesh={"collider": "ladder", **mesh}, contact={"self": "auto"}, ground={"kind": "none"})
    return make_geometry(value, BUNDLE, plan, memo or (lambda kind, key, make: make())), plan


def touching(value: Robot, geometry: Geometry, plan: Any, heights: np.ndarray) -> np.ndarray:
    files = export(value, geometry, plan).files
    assets = {name: data for name, data in files.items() if not name.endswith(".xml")}
    model = mujoco.MjSpec.from_string(files[f"{value.name}.xml"].decode(), assets=assets).compile()
    data = mujoco.MjData(model)
    met = []
    for height in heights:
        data.joint("finger_joint").qpos = height
        mujoco.mj_forward(model, data)
        met.append(data.ncon > 0)
    return np.array(met)


def test_a_finger_enters_a_slot_and_meets_its_bottom():
    value = robot()
    geometry, plan = made(value)
    heights = np.linspace(-REACH, 0.02, 161)
    met = touching(value, geometry, plan, heights)
    # The bottom is at -DEPTH: no contact 2 mm above it, one 2 mm below.
    assert not met[heights > -DEPTH + 0.0021].any()
    assert met[heights < -DEPTH - 0.0001].all()
    assert not any(one.code == "W-FALSE-CONTACT" for one in geometry.diagnostics)


def test_the_report_says_why():
    geometry, _ = made(robot(), fine=[])
    by_link = {one.link: one for one in geometry.colliders}
    assert by_link["post"].rung == "pieces"
    assert 2 <= by_link["post"].pieces <= 4
    assert by_link["post"].reason.startswith(f"{by_link['post'].pieces} pieces against finger")
    assert by_link["finger"].rung == "box"
    assert by_link["finger"].reason == "false in at most 0.5 % of 512 poses"


def test_hulls_would_be_false():
    value = robot()
    plan = plan_of(mesh={"collider": "hull"}, contact={"self": "auto"}, ground={"kind": "none"})
    geometry = make_geometry(value, BUNDLE, plan, lambda kind, key, make: make())
    assert touching(value, geometry, plan, np.array([-0.03])).all()


def test_who_may_not_collide_is_not_cut():
    plan = plan_of(mesh={"collider": "ladder", "fine": []}, contact={"self": "none"}, ground={"kind": "none"})
    geometry = make_geometry(robot(), BUNDLE, plan, lambda kind, key, make: make())
    assert [one.pieces for one in geometry.colliders] == [1, 1]


def test_links_that_meet_the_world_follow_their_surface():
    """As ends of chains, by a frame's name, by a glob, or all of them."""
    geometry, _ = made(robot())
    by_link = {one.link: one for one in geometry.colliders}
    for one in by_link.values():
        assert one.measures is not None
        assert one.measures.protrusion_p95 <= one.tolerance
        assert "meets the world" in one.reason
    only, _ = made(robot(), fine=["post"])
    assert [one.link for one in only.colliders if one.tolerance] == ["post"]
    every, _ = made(robot(), fine="all")
    assert [one.link for one in every.colliders if one.tolerance] == ["finger", "post"]
    with pytest.raises(MeshError) as caught:
        made(robot(), fine=["claw*"])
    (problem,) = caught.value.problems
    assert (problem.code, problem.where) == ("E-GLOB", "mesh.fine")


def test_the_order_of_joints_changes_nothing():
    one, other = (made(value)[0] for value in (robot(), robot(turned=True)))

    def pieces(geometry: Geometry) -> dict[str, list[bytes]]:
        return {
            link: [geometry.files[shape.file] for shape in geometry.of(link, "collision") if shape.file]
            for link in ("finger", "post")
        }

    assert pieces(one) == pieces(other)


def test_all_is_kept_under_one_key_and_a_limit_is_part_of_it():
    kept: dict[str, bytes] = {}

    def memo(kind: str, key: Any, make: Callable[[], bytes]) -> bytes:
        name = repr((kind, key))
        if kind == "mesh.by_contact":
            kept.setdefault(name, b"")
        return make()

    first, _ = made(robot(), memo)
    again, _ = made(robot(), memo)
    assert len(kept) == 1
    assert first.colliders == again.colliders
    joints = [joint("prismatic", "base", "finger", limits={"finger_joint": Limits(0.0, 0.02)})]
    moved = robot_with(joints, root="base")
    value = replace(robot(), joints=(*moved.joints, *robot().joints[1:]))
    made(value, memo)
    assert len(kept) == 2


def test_what_the_user_gave_stays_and_is_kept_clear_of():
    """The finger is a sphere by hand, too thick for the slot; the post is cut for what is given."""
    geometry, _ = made(robot(), colliders={"finger": {"sphere": {"radius": 0.008}}}, fine=[])
    by_link = {one.link: one for one in geometry.colliders}
    assert by_link["finger"].rung == "sphere"
    assert by_link["finger"].reason == ""
    assert by_link["post"].reason


def test_a_mesh_that_stays_as_it_is_collides_as_its_hull():
    """An engine fills the slot, which nothing cuts: the pair is named."""
    geometry, _ = made(robot(), colliders={"post": "raw"}, fine=[])
    (false,) = [problem for problem in geometry.diagnostics if problem.code == "W-FALSE-CONTACT"]
    assert "finger" in false.message
    assert "post" in false.message
