"""A thin blade pressed along every seam between two pieces of a collider neither passes nor jams.

The blade is a wheel of half a millimetre. How deep its edge is in the part itself, whose mesh the model has
as the visual one, is found by rays.
"""

import itertools
from dataclasses import dataclass

import mujoco
import numpy as np
import pytest
import trimesh
from scipy.spatial import ConvexHull

from tests.physics.test_concave_parts import SHAPES, part
from tests.support.physics import COLLISION, VISUAL

RADIUS, THICKNESS = 0.003, 0.0005
PRESS = 1.0
"""How hard the blade is pressed, and drawn along [N]."""

NEAR = 2e-4
"""A point of the part that is as near to two pieces is on their seam [m]."""

SHORTEST = 0.004
START = 0.001
"""The blade is set down so far from the beginning of a seam [m]."""

EDGE = np.linspace(-1, 1, 9)
"""Rays from the wheel's middle, at these angles from straight down [rad]."""


@dataclass(frozen=True)
class Seam:
    """Between two pieces: where it begins, its direction, the part's normal there, its length [m]."""

    pieces: tuple[int, int]
    begin: np.ndarray
    along: np.ndarray
    normal: np.ndarray
    length: float


def planes(model, geom):
    """(k, 4): the planes of a box or a convex mesh, normals outwards."""
    size = model.geom_size[geom]
    if model.geom_type[geom] == mujoco.mjtGeom.mjGEOM_MESH:
        mesh = model.mesh(model.geom_dataid[geom])
        points = model.mesh_vert[int(mesh.vertadr[0]) :][: int(mesh.vertnum[0])]
    else:
        assert model.geom_type[geom] == mujoco.mjtGeom.mjGEOM_BOX
        points = np.array(list(itertools.product(*((-half, half) for half in size))))
    turn = np.zeros(9)
    mujoco.mju_quat2Mat(turn, model.geom_quat[geom])
    return ConvexHull(points @ turn.reshape(3, 3).T + model.geom_pos[geom]).equations


def seams(mesh, hulls):
    """Where two pieces meet on the part's surface, one for each side of the part."""
    points, faces = trimesh.sample.sample_surface(mesh, 40000, seed=1)
    normals = mesh.face_normals[faces]
    outside = np.array([(hull[:, :3] @ points.T + hull[:, 3:]).max(axis=0) for hull in hulls])
    for pair in itertools.combinations(range(len(hulls)), 2):
        both = np.flatnonzero((outside[list(pair)] < NEAR).all(axis=0))
        while len(both):
            alike = normals[both] @ normals[both[0]] > 0.9
            side, both = both[alike], both[~alike]
            normal = normals[side].mean(axis=0)
            normal /= np.linalg.norm(normal)
            middle = points[side].mean(axis=0)
            flat = points[side] - middle
            flat -= np.outer(flat @ normal, normal)
            along = np.linalg.svd(flat, full_matrices=False)[2][0]
            low, high = (flat @ along).min(), (flat @ along).max()
            if high - low > SHORTEST:
                yield Seam(pair, middle + low * along, along, normal, high - low)


def with_blade(spec):
    """A wheel that slides along its own x and z, through oil: it is set down at 20 mm/s."""
    spec.option.gravity = [0, 0, 0]
    spec.option.timestep = 0.0005
    blade = spec.worldbody.add_body(name="blade")
    slide = mujoco.mjtJoint.mjJNT_SLIDE
    blade.add_joint(name="along", type=slide, axis=[1, 0, 0], damping=10)
    blade.add_joint(name="down", type=slide, axis=[0, 0, -1], damping=50)
    blade.add_geom(
        type=mujoco.mjtGeom.mjGEOM_CYLINDER,
        size=[RADIUS, THICKNESS / 2, 0],
        quat=[np.sqrt(0.5), np.sqrt(0.5), 0, 0],
        mass=0.1,
        condim=1,
        priority=1,
        solref=[0.004, 1],
        group=COLLISION,
    )
    return spec.compile()


def drawn(model, seam):
    """How deep the blade's edge gets below the part's surface [m], and how far it gets along the seam, as a
    share of its length."""
    blade = model.body("blade").id
    across = np.cross(seam.normal, seam.along)
    axes = np.stack([seam.along, across, seam.normal], axis=1)
    mujoco.mju_mat2Quat(model.body_quat[blade], axes.ravel())
    model.body_pos[blade] = seam.begin + seam.normal * (RADIUS + 0.002)
    rays = np.outer(np.sin(EDGE), seam.along) - np.outer(np.cos(EDGE), seam.normal)
    only = np.zeros(6, dtype=np.uint8)
    only[VISUAL] = 1
    data = mujoco.MjData(model)
    data.joint("along").qpos = START
    deepest, met = -np.inf, np.zeros(1, dtype=np.int32)
    for step in range(2000):
        data.qfrc_applied[:] = PRESS * (step > 320), PRESS
        mujoco.mj_step(model, data)
        if data.joint("along").qpos[0] > seam.length - START:
            break
        for ray in rays:
            reach = mujoco.mj_ray(model, data, data.xpos[blade], ray, only, 1, blade, met)
            deepest = max(deepest, RADIUS - reach) if reach >= 0 else deepest
    return deepest, float(data.joint("along").qpos[0]) / (seam.length - START)


def fits(model, seam):
    """Whether the part itself leaves room for the blade on the seam: in its inner corners there is none."""
    only, met = np.zeros(6, dtype=np.uint8), np.zeros(1, dtype=np.int32)
    only[VISUAL] = 1
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    across = np.cross(seam.normal, seam.along)
    middle = seam.begin + seam.along * seam.length / 2 + seam.normal * NEAR
    blade = model.body("blade").id
    reach = [mujoco.mj_ray(model, data, middle, side, only, 1, blade, met) for side in (across, -across)]
    return all(distance < 0 or distance > THICKNESS for distance in reach)


def hulls_of(model):
    geoms = [geom for geom in range(model.ngeom) if model.geom_group[geom] == COLLISION]
    return [planes(model, geom) for geom in geoms if model.geom_bodyid[geom] != model.body("blade").id]


SLOW = [("ring", None, 20), ("square hole", 0.0005, 8), ("round hole", 0.0002, 20)]


@pytest.mark.parametrize(
    ("name", "tolerance", "least"),
    [("clamp", None, 4), *(pytest.param(*row, marks=pytest.mark.slow) for row in SLOW)],
)
def test_a_blade_neither_passes_nor_jams(name, tolerance, least):
    fixed = part(name, tolerance)
    (figures,) = fixed.geometry.colliders
    assert (figures.rung, figures.meets) == ("pieces", True)
    model = with_blade(fixed.spec())
    gaps = [seam for seam in seams(SHAPES[name](), hulls_of(model)) if fits(model, seam)]
    assert len(gaps) >= least
    for seam in gaps:
        depth, share = drawn(model, seam)
        assert depth < figures.tolerance, seam
        assert share >= 1, seam


@pytest.mark.parametrize(
    ("gap", "step", "passes", "jams"), [(0.001, 0, True, False), (0, 0.004, False, True)], ids=["gap", "step"]
)
def test_a_gap_or_a_step_would_be_found(gap, step, passes, jams):
    """Two blocks side by side, a millimetre apart; or with a wall at the end of the way."""
    spec = mujoco.MjSpec()
    box, size = mujoco.mjtGeom.mjGEOM_BOX, [0.01, 0.01, 0.01]
    for side in (-1, 1):
        spec.worldbody.add_geom(type=box, size=size, pos=[0, side * (0.01 + gap / 2), -0.01], group=COLLISION)
    if step:
        spec.worldbody.add_geom(type=box, size=[0.002, 0.01, step], pos=[0.004, 0, 0], group=COLLISION)
    spec.worldbody.add_geom(
        type=box, size=[0.01, 0.021, 0.01], pos=[0, 0, -0.01], group=VISUAL, contype=0, conaffinity=0
    )
    seam = Seam((0, 1), np.array([-0.01, 0, 0]), np.array([1.0, 0, 0]), np.array([0, 0, 1.0]), 0.02)
    depth, share = drawn(with_blade(spec), seam)
    assert (depth > 0.001) == passes
    assert (share < 1) == jams
