"""Judges the points about bodies and their shapes."""

import re
from collections.abc import Iterator

import numpy as np

from linkwright.stages.mujoco.names import actuator_count
from linkwright.stages.robot.text.plural import count
from linkwright.stages.validate.model.poses import placed
from linkwright.stages.validate.model.shapes import MESH, directions, reach
from linkwright.stages.validate.readiness.finished import FinishedRobot, NotApplicable

VISUAL, COLLISION = 2, 3
"""The groups of visual geoms and of colliders in MuJoCo's viewer."""

MIN_MASS = 1e-4
"""Mass [kg] below which bodies need small time steps."""

MAX_MASS_RATIO = 1000.0
"""Largest ratio of the masses of two bodies that a joint connects."""

MAX_BOX_RATIO = 1.5
"""Largest ratio of the sides of a body's equivalent box, of even density, to the sides of its own box."""

MAX_PIECES = 16
"""Largest number of colliders of a body."""

MAX_HULL_VERTICES = 64
"""Largest number of vertices of a colliding mesh."""

HULL_TOLERANCE = 1e-3
"""Tolerance for rounding, as a share of the size of a body's box."""


def roles(finished: FinishedRobot) -> Iterator[str]:
    """Judges whether visual geoms and colliders are in groups of their own."""
    model = finished.model
    for geom in (geom for pair in finished.geoms_by_body.values() for geom in pair[0]):
        if model.geom_group[geom] != VISUAL:
            yield "put the visual geoms into group 2"
            break
    for geom in (geom for pair in finished.geoms_by_body.values() for geom in pair[1]):
        if model.geom_group[geom] != COLLISION:
            yield "put the colliders into group 3, apart from the visual geoms"
            break


def colliders(finished: FinishedRobot) -> Iterator[str]:
    """Judges whether each body with a shape has a collider."""
    for body, (_, solid) in finished.geoms_by_body.items():
        if not solid:
            yield f"give {finished.name_of('body', body)} a collider: mesh.colliders"


def inertias(finished: FinishedRobot) -> Iterator[str]:
    """Judges whether principal moments are above 0 and fulfil the triangle inequality."""
    model = finished.model
    for index, name in finished.bodies:
        a, b, c = np.sort(model.body_inertia[index])
        if not (a > 0 and a + b >= c * (1 - 1e-9)):
            yield f"the inertia of {name} is impossible for a body: {a:.3g}, {b:.3g}, {c:.3g} kg m²"


def extents(finished: FinishedRobot) -> Iterator[str]:
    """Judges whether inertias and centres of mass fit the shapes of their bodies."""
    model, judged = finished.model, False
    for body, pair in finished.geoms_by_body.items():
        geoms, mass = list(pair[0] or pair[1]), model.body_mass[body]
        if not body or not geoms or mass <= 0:
            continue
        judged = True
        axes = placed(model.body_iquat[body], model.body_ipos[body])
        along = np.concatenate([axes[:3, :3].T, -axes[:3, :3].T])
        reaches = reach(model, geoms, along)
        sides = reaches[:3] + reaches[3:]
        moments = model.body_inertia[body]
        # Of a box of even density with sides s: I_x = m (s_y² + s_z²) / 12.
        equivalent = np.sqrt(np.maximum(6.0 * (moments.sum() - 2.0 * moments) / mass, 0.0))
        name = finished.name_of("body", body)
        size = float(np.linalg.norm(sides))
        if (np.sort(equivalent) > MAX_BOX_RATIO * np.sort(sides) + HULL_TOLERANCE * size).any():
            lengths = ", ".join(f"{1e3 * side:.3g}" for side in equivalent)
            yield f"the inertia of {name} is that of a box of {lengths} mm, larger than its visual shapes"
        along_sphere = directions(64)
        centre = axes[:3, 3]
        if float((reach(model, geoms, along_sphere) - along_sphere @ centre).min()) < -HULL_TOLERANCE * size:
            yield f"the centre of mass of {name} is outside of its visual shapes"
    if not judged:
        raise NotApplicable("no body has both a mass and a shape")


def masses(finished: FinishedRobot) -> Iterator[str]:
    """Judges whether bodies are heavy enough for stable time steps, alone and beside their parents."""
    model = finished.model
    for index, name in finished.bodies:
        mass, above = model.body_mass[index], int(model.body_parentid[index])
        # The world has no mass.
        if above and model.body_mass[above] > MAX_MASS_RATIO * mass:
            yield f"{name} weighs less than a thousandth of its parent"
        elif mass < MIN_MASS:
            yield f"{name} weighs {1e3 * mass:.3g} g: fuse it with its neighbour, or give it its mass"


def moving(finished: FinishedRobot) -> Iterator[str]:
    """Judges whether each body moves against its parent, or carries a site or a camera."""
    model = finished.model
    used_bodies = {int(body) for body in model.site_bodyid} | set(model.cam_bodyid.tolist())
    for index, name in finished.bodies:
        if model.body_parentid[index] and not model.body_jntnum[index] and index not in used_bodies:
            yield f"fuse {name}, which does not move against its parent: export.mjcf.fixed_joints"


def frames(finished: FinishedRobot) -> Iterator[str]:
    """Judges whether each frame of the robot is a site or a body."""
    if not finished.robot.frames:
        raise NotApplicable("the robot has no frames")
    model = finished.model
    existing = {model.site(index).name for index in range(model.nsite)} | {
        name for _, name in finished.bodies
    }
    yield from (
        f"write the frame {frame.name} as a site"
        for frame in finished.robot.frames
        if frame.name not in existing
    )


def names(finished: FinishedRobot) -> Iterator[str]:
    """Judges whether names are plain, colliders have names, and no body has a joint's name."""
    model = finished.model
    counts = {
        "body": model.nbody,
        "joint": model.njnt,
        "actuator": actuator_count(model),
        "site": model.nsite,
    }
    counts |= {"sensor": model.nsensor}
    names_by_kind = {
        kind: [finished.name_of(kind, index) for index in range(number)] for kind, number in counts.items()
    }
    for kind, names_of_kind in names_by_kind.items():
        illegal_names = [name for name in names_of_kind if not re.fullmatch(r"[A-Za-z0-9_]+", name)]
        if illegal_names:
            examples = ", ".join(map(repr, illegal_names[:3]))
            yield f"name each {kind} in letters, digits and underscores: {examples}"
    unnamed = [
        geom for _, solid in finished.geoms_by_body.values() for geom in solid if not model.geom(geom).name
    ]
    if unnamed:
        yield f"name {count(len(unnamed), 'collider')}"
    shared_names = set(names_by_kind["body"]) & set(names_by_kind["joint"])
    if shared_names:
        yield f"SDF takes no link and joint of one name: {', '.join(sorted(shared_names))}"


def pieces(finished: FinishedRobot) -> Iterator[str]:
    """Judges whether bodies have few colliders, and colliding meshes few vertices."""
    model = finished.model
    solid = {body: pair[1] for body, pair in finished.geoms_by_body.items() if pair[1]}
    if not solid:
        raise NotApplicable("nothing collides")
    for body, geoms in solid.items():
        if len(geoms) > MAX_PIECES:
            name = finished.name_of("body", body)
            yield f"{name} has {len(geoms)} colliders, more than {MAX_PIECES}: mesh.colliders"
    for geoms in solid.values():
        for geom in geoms:
            mesh = int(model.geom_dataid[geom]) if model.geom_type[geom] == MESH else -1
            if mesh >= 0 and model.mesh_vertnum[mesh] > MAX_HULL_VERTICES:
                name = model.mesh(mesh).name
                vertices = model.mesh_vertnum[mesh]
                yield f"{name} has {vertices} vertices, more than {MAX_HULL_VERTICES}: mesh.max_vertices"
