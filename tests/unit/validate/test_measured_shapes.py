"""How far geoms reach and how far points are outside them, against MuJoCo's own distances between geoms."""

import mujoco
import numpy as np
import pytest

from linkwright.stages.validate.model.shapes import (
    area,
    directions,
    outside,
    reach,
    seen_and_solid,
    surface_points,
)
from linkwright.stages.validate.model.shapes import vertices as vertices_of

TETRAHEDRON = "0 0 0  .1 0 0  0 .2 0  0 0 .3"

KINDS = {
    "box": 'type="box" size=".1 .2 .3"',
    "sphere": 'type="sphere" size=".15"',
    "capsule": 'type="capsule" size=".12 .2"',
    "cylinder": 'type="cylinder" size=".1 .2"',
    "ellipsoid": 'type="ellipsoid" size=".1 .2 .3"',
    "mesh": 'type="mesh" mesh="some"',
}

PLACE = 'pos=".3 -.2 .1" quat=".5 .1 -.7 .4"'

FAR = 10.0


def model_of(kind: str) -> mujoco.MjModel:
    return mujoco.MjModel.from_xml_string(
        f"""<mujoco><asset><mesh name="some" vertex="{TETRAHEDRON}"/></asset><worldbody>
        <geom name="wall" type="plane" size="1 1 1" {PLACE}/>
        <geom name="point" type="sphere" size="1e-6" {PLACE}/>
        <body name="body"><joint/><geom name="it" {KINDS[kind]} {PLACE} mass="1"/></body>
        </worldbody></mujoco>"""
    )


@pytest.mark.parametrize("kind", KINDS)
def test_reach_is_the_distance_from_a_wall(kind):
    model = model_of(kind)
    data, wall, it = mujoco.MjData(model), model.geom("wall").id, model.geom("it").id
    along = directions(20)
    distances = reach(model, [it], along)
    for u, distance in zip(along, distances, strict=True):
        model.geom_pos[wall] = FAR * u
        mujoco.mju_quatZ2Vec(model.geom_quat[wall], -u)
        mujoco.mj_kinematics(model, data)
        assert distance == pytest.approx(
            FAR - mujoco.mj_geomDistance(model, data, wall, it, 2 * FAR, None), abs=1e-6
        )


@pytest.mark.parametrize("kind", KINDS)
def test_points_outside_are_as_far_as_a_small_sphere_or_nearer_and_never_outside_within(kind):
    model = model_of(kind)
    data, point, it = mujoco.MjData(model), model.geom("point").id, model.geom("it").id
    points = np.random.default_rng(5).uniform(-0.5, 0.7, (60, 3))
    distances = outside(model, [it], points)
    exact = kind not in ("mesh", "ellipsoid")
    if not exact and tuple(map(int, mujoco.__version__.split(".")[:2])) < (3, 4):
        pytest.skip("the oracle, mj_geomDistance, is off by millimetres in this MuJoCo")
    inside = 0
    for where, distance in zip(points, distances, strict=True):
        model.geom_pos[point] = where
        mujoco.mj_kinematics(model, data)
        true = max(0.0, mujoco.mj_geomDistance(model, data, point, it, FAR, None))
        inside += true == 0.0
        assert distance <= true + 1e-5
        assert (distance > 0) == (true > 1e-5) or abs(distance - true) < 1e-5
        if exact:
            assert distance == pytest.approx(true, abs=1e-5)
    assert 0 < inside < 60


def test_normals_of_a_hull_are_of_its_faces_whatever_the_engine_says_of_them():
    """MuJoCo before 4.0 takes a normal from three corners of a face, which may be one sliver."""
    model = model_of("mesh")
    it, points = model.geom("it").id, np.random.default_rng(6).uniform(-0.5, 0.7, (60, 3))
    distances = outside(model, [it], points)
    model.mesh_polynormal[:] = [0.0, 0.6, 0.8]
    assert distances.max() > 0.1
    assert np.array_equal(outside(model, [it], points), distances)


@pytest.mark.parametrize("kind", KINDS)
def test_surface_points_are_on_the_surface(kind):
    """Within, and yet nothing reaches further: where they are foremost, they are as far as the shape is."""
    model = model_of(kind)
    it = model.geom("it").id
    points = surface_points(model, [it], 1000)
    assert outside(model, [it], points).max() < 1e-6
    if kind != "mesh":  # of which the centres of faces are not foremost
        along = directions(500)
        near = (points @ along.T).max(axis=0)
        assert np.abs(near - reach(model, [it], along)).max() < 0.05
    assert len(surface_points(model, [it], 3)) == 3


def test_the_union_reaches_as_far_as_the_furthest_and_is_as_near_as_the_nearest():
    model = mujoco.MjModel.from_xml_string(
        '<mujoco><worldbody><body><joint/><geom size=".1" pos="1 0 0"/><geom size=".2" pos="-1 0 0"/></body>'
        "</worldbody></mujoco>"
    )
    assert reach(model, [0, 1], np.array([[1.0, 0, 0], [-1.0, 0, 0]])).tolist() == pytest.approx([1.1, 1.2])
    assert outside(model, [0, 1], np.zeros((1, 3))).tolist() == pytest.approx([0.8])


def test_the_area_of_a_mesh():
    """Three right triangles at the corner, and the one across from it."""
    model = model_of("mesh")
    a, b, c = np.array([0.1, 0, 0]), np.array([0, 0.2, 0]), np.array([0, 0, 0.3])
    across = np.linalg.norm(np.cross(b - a, c - a)) / 2
    assert area(model, model.geom("it").id) == pytest.approx((0.02 + 0.03 + 0.06) / 2 + across, rel=1e-6)
    assert len(vertices_of(model, model.geom("it").id)) == 4


def test_what_is_seen_is_told_from_what_collides():
    model = mujoco.MjModel.from_xml_string(
        '<mujoco><worldbody><geom type="plane" size="1 1 1"/><body><joint/><geom size=".1" contype="0" '
        'conaffinity="0"/><geom size=".2"/><geom size=".3" contype="0"/></body></worldbody></mujoco>'
    )
    assert seen_and_solid(model) == {1: ([1], [2, 3])}
