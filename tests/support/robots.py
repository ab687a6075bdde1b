"""Robots made by hand: every type of joint and loop, without a document behind them."""

from dataclasses import replace

import numpy as np

from linkwright.stages.robot.dynamics.inertia import moved
from linkwright.stages.robot.model.poses import at_rest, from_parts, inverse, rotation_from_quat
from linkwright.stages.robot.model.robot import (
    Base,
    Dof,
    Dynamics,
    Inertial,
    Joint,
    Limits,
    Link,
    Loop,
    MateRef,
    Mobility,
    Part,
    Provenance,
    Robot,
    frozen,
)
from linkwright.stages.robot.motion.kinematics import link_poses, saved_configuration

X, Y, Z, NONE = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0), (0.0, 0.0, 0.0)

CHAINS = {
    "fixed": (),
    "revolute": (("", "turn", Z),),
    "prismatic": (("", "slide", Z),),
    "cylindrical": (("_slide", "slide", Z), ("_turn", "turn", Z)),
    "ball": (("", "ball", NONE),),
    "planar": (("_x", "slide", X), ("_y", "slide", Y), ("_turn", "turn", Z)),
    "pin_slot": (("_slide", "slide", X), ("_turn", "turn", Z)),
    "parallel": (("_x", "slide", X), ("_y", "slide", Y), ("_z", "slide", Z), ("_turn", "turn", Z)),
    "free": (("", "free", NONE),),
}
"""The dofs of a mate from its second entity to its first: suffix, kind, axis."""

EVERY = tuple(CHAINS)
LOOPS = tuple(kind for kind in CHAINS if kind != "free")
CARRIED = ("prismatic", "cylindrical", "planar", "pin_slot", "parallel")


def pose(rng, reach=0.3):
    """Some rigid transform (4, 4)."""
    return from_parts(rotation_from_quat(rng.normal(size=4)), rng.uniform(-reach, reach, 3))


def at(*xyz):
    """A shift (4, 4)."""
    return from_parts(np.eye(3), np.array(xyz, dtype=float))


def some_value(kind, rng, reach=1.5):
    """Some value of a dof: scalars within ±`reach`, quaternions of unit length."""
    if kind in ("turn", "slide"):
        return float(rng.uniform(-reach, reach))
    quat = rng.normal(size=4)
    place = rng.uniform(-reach, reach, 3) if kind == "free" else ()
    return tuple(float(x) for x in (*place, *(quat / np.linalg.norm(quat))))


def some_values(robot, rng):
    """Some value for each dof of the tree."""
    return {dof.name: some_value(dof.kind, rng) for dof in robot.dofs}


def dofs_of(
    name, kind, saved=None, *, backwards=False, mirrored=False, limits=None, dynamics=None, origins=()
):
    """A mate's dofs in the order of a tree's chain. `saved`: in the mate's own order; `limits`: by the
    dof's name; `origins`: of the second dof in the chain and those after it."""
    made = []
    for index, (suffix, freedom, axis) in enumerate(CHAINS[kind]):
        value = at_rest(freedom) if saved is None else saved[index]
        sign = -1.0 if mirrored and freedom == "slide" and axis == Z else 1.0
        if backwards:
            sign = -sign
            if freedom == "ball" and isinstance(value, tuple):
                value = (value[0], -value[1], -value[2], -value[3])
        made.append((name + suffix, freedom, frozen(np.array(axis) * sign + 0.0), value))
    if backwards:
        made.reverse()
    frames = [np.eye(4), *origins, *[np.eye(4)] * len(made)]
    limits, dynamics = limits or {}, dynamics or Dynamics()
    return tuple(
        Dof(label, freedom, axis, frozen(frame), limits.get(label, Limits()), dynamics, value)
        for (label, freedom, axis, value), frame in zip(made, frames, strict=False)
    )


def joint(kind, parent, child, saved=None, *, name=None, place=None, **mate):
    """A joint called `<child>_joint` unless named, at `place` in its parent (the identity); `mate`: as
    `dofs_of` has it."""
    name, where = name or f"{child}_joint", frozen(np.eye(4) if place is None else place)
    dofs, ref = dofs_of(name, kind, saved, **mate), MateRef((), name, name, kind.upper())
    return Joint(name, kind, parent, child, where, dofs, mate.get("backwards", False), ref)


def loop(kind, link_a, link_b, a_from_frame, b_from_frame, saved=None, *, name="loop", **more):
    """A mate that closes a loop: its first entity on `link_a`. `more`: `lever`, `solref` or `limits`."""
    lever, solref = more.pop("lever", 0.05), more.pop("solref", (0.004, 1.0))
    dofs, ref = dofs_of(name, kind, saved, **more), MateRef((), name, name, kind.upper())
    frames = frozen(a_from_frame), frozen(b_from_frame)
    return Loop(name, kind, link_a, link_b, *frames, dofs, lever, solref, 0.0, ref)


def solid(mass, com=(0.0, 0.0, 0.0), radius=0.1):
    """An uneven body: moments in the ratio 4 : 5 : 6, with products of inertia."""
    twist = rotation_from_quat(np.array([1.0, 0.2, -0.3, 0.4]))
    tensor = mass * radius**2 * twist @ np.diag([0.4, 0.5, 0.6]) @ twist.T
    return Inertial(mass, frozen(com), frozen((tensor + tensor.T) / 2))


def robot_with(
    joints=(),
    *,
    loops=(),
    relations=(),
    frames=(),
    root="base",
    fixed=True,
    world_from_root=None,
    inertials=None,
    given=None,
    shapes=None,
    name="robot",
):
    """A robot of these joints: a link for the root and for each child, of one part each.

    `inertials`: of links by name, in place of made-up ones; `given`: the user's, on top of the part's.
    A root called `world` has neither part nor mass.
    """
    names = [root, *(joint.child for joint in joints)]
    origin = np.eye(4) if world_from_root is None else world_from_root

    def assembled(links):
        coordinates = sum({"ball": 3, "free": 6}.get(d.kind, 1) for j in joints for d in j.dofs)
        return Robot(
            name=name,
            links=links,
            joints=tuple(joints),
            loops=tuple(loops),
            relations=tuple(relations),
            frames=tuple(frames),
            base=Base(fixed, "made so"),
            world_from_root=frozen(origin),
            mobility=Mobility(coordinates, coordinates, coordinates, ()),
            provenance=Provenance("d", "e", "m", ""),
        )

    massless = Inertial(0.0, frozen(np.zeros(3)), frozen(np.zeros((3, 3))))
    bare = assembled(tuple(Link(link, massless, (), ()) for link in names))
    poses = link_poses(bare, saved_configuration(bare))
    links = []
    for index, link in enumerate(names):
        if link == "world":
            links.append(Link(link, massless, (), ()))
            continue
        made_up = solid(1.0 + 0.1 * index, (0.02, -0.01 * index, 0.03))
        weight = (inertials or {}).get(link, made_up)
        tilt = rotation_from_quat(np.array([1.0, 0.1 * index, 0.2, 0.0]))
        part_pose = from_parts(tilt, np.array([0.01, 0.0, 0.02]))
        part = Part(
            path=(link,),
            name=link,
            part_id=link,
            mesh=None,
            link_from_part=frozen(part_pose),
            world_from_part=frozen(origin @ poses[link] @ part_pose),
            inertial=moved(weight, inverse(part_pose)),
            volume=weight.mass / 1000.0,
        )
        own = (given or {}).get(link)
        links.append(Link(link, own or weight, (part,), (link,), own, (shapes or {}).get(link, ())))
    return assembled(tuple(links))


def robot_around(kind, rng, root, backwards):
    """A joint of this type with origins of its own for its dofs, below a hinge (a free one below nothing) and
    above a slide that is mirrored."""
    origins = [pose(rng) for _ in range(3)]
    rows = [joint(kind, root, "one", place=pose(rng), backwards=backwards, origins=origins)]
    if kind != "free":
        rows.insert(0, joint("revolute", root, "zero", place=pose(rng)))
        rows[1] = replace(rows[1], parent="zero")
    rows.append(joint("prismatic", "one", "two", place=pose(rng), mirrored=True))
    return robot_with(rows, root=root)
