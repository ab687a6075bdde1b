"""The points about bodies and their shapes."""

import re
from collections.abc import Iterator

import numpy as np

from linkwright.stages.robot.text.plural import count
from linkwright.stages.validate.model.poses import placed
from linkwright.stages.validate.model.shapes import MESH, directions, reach
from linkwright.stages.validate.readiness.finished import Aside, Finished

VISUAL, COLLISION = 2, 3
"""The groups of geoms that are seen and that collide."""

LIGHT = 1e-4
"""Bodies of less [kg] ask for small time steps."""

RATIO = 1000.0
BOX = 1.5
"""How many times a body's box its equivalent box of even density may be."""

PIECES = 16
HULL = 64

SPREAD = 1e-3
"""Of a body's box: how far its centre of mass may be outside its hull, which rounding moves."""


def roles(finished: Finished) -> Iterator[str]:
    model = finished.model
    for geom in (one for pair in finished.shapes.values() for one in pair[0]):
        if model.geom_group[geom] != VISUAL:
            yield "put what is only seen into group 2"
            break
    for geom in (one for pair in finished.shapes.values() for one in pair[1]):
        if model.geom_group[geom] != COLLISION:
            yield "put the colliders into group 3, apart from what is seen"
            break


def colliders(finished: Finished) -> Iterator[str]:
    for body, (_, solid) in finished.shapes.items():
        if not solid:
            yield f"give {finished.name_of('body', body)} a collider: mesh.colliders"


def inertias(finished: Finished) -> Iterator[str]:
    model = finished.model
    for index, name in finished.bodies:
        a, b, c = np.sort(model.body_inertia[index])
        if a <= 0 or a + b < c * (1 - 1e-9):
            yield f"the inertia of {name} belongs to no body: {a:.3g}, {b:.3g}, {c:.3g} kg m²"


def extents(finished: Finished) -> Iterator[str]:
    model, found = finished.model, False
    for body, pair in finished.shapes.items():
        geoms, mass = list(pair[0] or pair[1]), model.body_mass[body]
        if not body or not geoms or mass <= 0:
            continue
        found = True
        axes = placed(model.body_iquat[body], model.body_ipos[body])
        along = np.concatenate([axes[:3, :3].T, -axes[:3, :3].T])
        reaches = reach(model, geoms, along)
        sides = reaches[:3] + reaches[3:]
        moments = model.body_inertia[body]
        # Of a box of even density with sides s: I_x = m (s_y² + s_z²) / 12.
        equivalent = np.sqrt(np.maximum(6.0 * (moments.sum() - 2.0 * moments) / mass, 0.0))
        name = finished.name_of("body", body)
        size = float(np.linalg.norm(sides))
        if (np.sort(equivalent) > BOX * np.sort(sides) + SPREAD * size).any():
            lengths = ", ".join(f"{1e3 * one:.3g}" for one in equivalent)
            yield f"the inertia of {name} is that of a box of {lengths} mm, larger than what is seen of it"
        every = directions(64)
        centre = axes[:3, 3]
        if float((reach(model, geoms, every) - every @ centre).min()) < -SPREAD * size:
            yield f"the centre of mass of {name} is outside of what is seen of it"
    if not found:
        raise Aside("no body has both a mass and a shape")


def masses(finished: Finished) -> Iterator[str]:
    model = finished.model
    for index, name in finished.bodies:
        mass, above = model.body_mass[index], int(model.body_parentid[index])
        if above and model.body_mass[above] > RATIO * mass:
            yield f"{name} weighs less than a thousandth of what it hangs on"
        elif mass < LIGHT:
            yield f"{name} weighs {1e3 * mass:.3g} g: fuse it with its neighbour, or give it its mass"


def moving(finished: Finished) -> Iterator[str]:
    model = finished.model
    used = {int(body) for body in model.site_bodyid} | set(model.cam_bodyid.tolist())
    for index, name in finished.bodies:
        if model.body_parentid[index] and not model.body_jntnum[index] and index not in used:
            yield f"fuse {name}, which does not move against its parent: export.mjcf.fixed_joints"


def frames(finished: Finished) -> Iterator[str]:
    if not finished.robot.frames:
        raise Aside("the robot has no frames")
    model = finished.model
    there = {model.site(index).name for index in range(model.nsite)} | {name for _, name in finished.bodies}
    yield from (
        f"write the frame {one.name} as a site" for one in finished.robot.frames if one.name not in there
    )


def names(finished: Finished) -> Iterator[str]:
    model = finished.model
    counts = {"body": model.nbody, "joint": model.njnt, "actuator": model.nu, "site": model.nsite}
    counts |= {"sensor": model.nsensor}
    found = {kind: [finished.name_of(kind, one) for one in range(number)] for kind, number in counts.items()}
    for kind, every in found.items():
        bad = [name for name in every if not re.fullmatch(r"[A-Za-z0-9_]+", name)]
        if bad:
            yield f"name each {kind} in letters, digits and underscores: {', '.join(map(repr, bad[:3]))}"
    unnamed = [one for _, solid in finished.shapes.values() for one in solid if not model.geom(one).name]
    if unnamed:
        yield f"name {count(len(unnamed), 'collider')}"
    both = set(found["body"]) & set(found["joint"])
    if both:
        yield f"SDF takes no link and joint of one name: {', '.join(sorted(both))}"


def pieces(finished: Finished) -> Iterator[str]:
    model = finished.model
    solid = {body: pair[1] for body, pair in finished.shapes.items() if pair[1]}
    if not solid:
        raise Aside("nothing collides")
    for body, geoms in solid.items():
        if len(geoms) > PIECES:
            name = finished.name_of("body", body)
            yield f"{name} has {len(geoms)} colliders, more than {PIECES}: mesh.colliders"
    for geoms in solid.values():
        for geom in geoms:
            mesh = int(model.geom_dataid[geom]) if model.geom_type[geom] == MESH else -1
            if mesh >= 0 and model.mesh_vertnum[mesh] > HULL:
                name = model.mesh(mesh).name
                yield f"{name} has {model.mesh_vertnum[mesh]} vertices, more than {HULL}: mesh.max_vertices"
