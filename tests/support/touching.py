"""Which links of a robot touch: of boxes and spheres in closed form, and of an MJCF by MuJoCo."""

from itertools import combinations, product

import mujoco
import numpy as np

from linkwright.stages.mesh import make_geometry
from linkwright.stages.robot import codec
from linkwright.stages.robot.bundle import Bundle
from linkwright.stages.robot.model.robot import Primitive, frozen
from linkwright.stages.robot.motion.kinematics import link_poses
from linkwright.stages.validate.model.coordinates import set_values
from tests.support.building import plan_of


def box(x, y, z, pose=None):
    """A box of these lengths."""
    return Primitive("box", (x, y, z), frozen(np.eye(4) if pose is None else pose))


def ball(radius, pose=None):
    return Primitive("sphere", (radius,), frozen(np.eye(4) if pose is None else pose))


NO_FILES = Bundle("sample", {}, "", {}, {})


def no_memo(kind, key, make):
    return make()


class Memory:
    """A memo that keeps what was made, and tells what it was asked: `keys`, as text, by kind."""

    def __init__(self):
        self.kept, self.made, self.keys = {}, 0, []

    def __call__(self, kind, key, make):
        name = kind, codec.dump(key)
        self.keys.append(name)
        if name not in self.kept:
            self.made += 1
            self.kept[name] = make()
        return self.kept[name]

    def keys_of(self, kind):
        return [key for asked, key in self.keys if asked == kind]


def geometry_of(robot, memo=no_memo, **contact):
    """The geometry of a robot of primitives alone; `self` is auto unless said."""
    return make_geometry(robot, NO_FILES, plan_of(contact={"self": "auto", **contact}), memo)


def in_mujoco(model, robot, q):
    """The pairs of links that are in contact at the values `q` of the tree's dofs and of the loops' own."""
    data = mujoco.MjData(model)
    set_values(model, data, robot, q, urdf=False)
    mujoco.mj_collision(model, data)
    return contacts(model, data, robot)


def geoms_in_mujoco(model, robot, q):
    """The pairs of colliders that are in contact at these values."""
    data = mujoco.MjData(model)
    set_values(model, data, robot, q, urdf=False)
    mujoco.mj_collision(model, data)
    return geom_contacts(model, data, robot)


def contacts(model, data, robot):
    """The pairs of links in contact now, in the order of the links."""
    return {(first, other) for (first, _), (other, _) in geom_contacts(model, data, robot)}


def geom_contacts(model, data, robot):
    """The pairs of colliders in contact now, in the order of the links."""
    place = {link.name: index for index, link in enumerate(robot.links)}
    touching = set()
    for contact in data.contact[: data.ncon]:
        touching.add(
            tuple(sorted((geom_of(model, geom) for geom in contact.geom), key=lambda named: place[named[0]]))
        )
    return touching


def geom_of(model, geom):
    """The link of a collider of the model, and its position there."""
    link, _, position = model.geom(geom).name.rpartition("_collision")
    return link, int(position.removeprefix("_") or 0)


def excluded(robot, excludes):
    """The pairs of shapes that do not collide; of links of primitives alone, which all collide."""
    pairs = set()
    for exclude in excludes:
        a, b = exclude.link_a, exclude.link_b
        every = product(range(len(robot.link(a).shapes)), range(len(robot.link(b).shapes)))
        pairs |= {((a, i), (b, j)) for i, j in exclude.geoms or every}
    return pairs


def apart(robot, q):
    """The distance of each two links with shapes at `q`: negative by the depth where they overlap; where
    boxes are apart only a lower bound of it."""
    distances = {}
    for ((first, _), (other, _)), off in geoms_apart(robot, q).items():
        distances[first, other] = min(off, distances.get((first, other), np.inf))
    return distances


def geoms_apart(robot, q):
    """The same of each two shapes of different links."""
    poses = link_poses(robot, q)
    distances = {}
    for first, other in combinations(robot.links, 2):
        for (i, a), (j, b) in product(enumerate(first.shapes), enumerate(other.shapes)):
            places = poses[first.name] @ a.link_from_shape, poses[other.name] @ b.link_from_shape
            distances[(first.name, i), (other.name, j)] = _between(a, places[0], b, places[1])
    return distances


def _between(a, at, b, bt):
    if a.kind == b.kind == "sphere":
        return float(np.linalg.norm(at[:3, 3] - bt[:3, 3])) - a.size[0] - b.size[0]
    if "sphere" in (a.kind, b.kind):
        return _ball_and_box(a, at, b, bt) if a.kind == "sphere" else _ball_and_box(b, bt, a, at)
    return _boxes(a, at, b, bt)


def _ball_and_box(ball, at, box, bt):
    local = bt[:3, :3].T @ (at[:3, 3] - bt[:3, 3])
    beyond = np.abs(local) - np.array(box.size) / 2
    outside = float(np.linalg.norm(np.maximum(beyond, 0)))
    return (outside if outside else float(beyond.max())) - ball.size[0]


def _boxes(a, at, b, bt):
    """By the separating axes of two boxes (Gottschalk, Lin and Manocha, 1996): normals, and products of
    edges."""
    rotations = at[:3, :3], bt[:3, :3]
    edges = np.cross(rotations[0].T[:, None], rotations[1].T[None]).reshape(-1, 3)
    lengths = np.linalg.norm(edges, axis=1)
    crossing = lengths > 1e-9
    axes = np.concatenate([rotations[0].T, rotations[1].T, edges[crossing] / lengths[crossing, None]])
    reach = sum(
        np.abs(axes @ turned) @ np.array(shape.size) / 2
        for shape, turned in zip((a, b), rotations, strict=True)
    )
    return float((np.abs(axes @ (at[:3, 3] - bt[:3, 3])) - reach).max())
