"""Boxes that meet, distances of meshes and depths of convex solids, by each engine that is installed."""

from itertools import combinations

import numpy as np
import pytest

from linkwright.stages.robot.contact import clearance
from linkwright.stages.robot.contact.meeting_boxes import meeting_boxes

CUBE = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
SQUARES = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
FACES = np.array([half for a, b, c, d in SQUARES for half in ((a, b, c), (a, c, d))])


@pytest.fixture(params=["coal", "fcl"])
def engine(request):
    pytest.importorskip(request.param)
    return {"coal": clearance._Coal, "fcl": clearance._Fcl}[request.param]()


def poses(*places, turn=None):
    stacked = np.tile(np.eye(4), (len(places), 1, 1))
    stacked[:, :3, 3] = places
    if turn is not None:
        stacked[:, :3, :3] = turn
    return stacked


def test_engine_is_coal_where_it_is_installed():
    pytest.importorskip("coal")
    assert isinstance(clearance.engine(), clearance._Coal)


@pytest.mark.parametrize("gap", [0.0005, 0.0019, 0.0021, 0.3])
def test_surfaces_are_near_within_the_margin(engine, gap):
    cube = engine.mesh(CUBE, FACES)
    (pose,) = engine.poses(poses([1 + gap, 0.1, 0.2]))
    assert engine.near(cube, cube, pose, 0.002) == (gap <= 0.002)


def test_mesh_inside_of_a_hollow_is_not_near(engine):
    outer, inner = engine.mesh(CUBE, FACES), engine.mesh(0.5 * CUBE, FACES)
    inside, across = engine.poses(poses([0, 0, 0], [0.26, 0, 0]))
    assert not engine.near(outer, inner, inside, 0.002)
    assert engine.near(outer, inner, across, 0.002)


@pytest.mark.parametrize("gap", [0.0005, 0.3])
def test_distance_of_surfaces_is_that_of_a_closed_form(engine, gap):
    cube = engine.mesh(CUBE, FACES)
    along, corner, cuts = engine.poses(poses([1 + gap, 0.1, 0.2], [1 + gap] * 3, [0.9, 0.1, 0.2]))
    assert engine.distance(cube, cube, along) == pytest.approx(gap, abs=1e-9)
    assert engine.distance(cube, cube, corner) == pytest.approx(gap * np.sqrt(3), abs=1e-9)
    assert engine.distance(cube, cube, cuts) <= 0


@pytest.mark.parametrize("shift", [0.4, 0.999, 1.0015, 1.5])
def test_depth_of_two_cubes_along_an_axis(engine, shift):
    cube = engine.convex(CUBE, FACES)
    (pose,) = engine.poses(poses([0.03, shift, -0.02]))
    assert engine.depth(cube, cube, pose) == pytest.approx(1 - shift, abs=1e-6)


def test_depth_of_an_edge_in_a_face(engine):
    """A cube that stands on its edge, 0.01 deep in the top of another."""
    half = np.sqrt(0.5)
    turn = np.array([[half, 0, half], [0, 1, 0], [-half, 0, half]])
    cube = engine.convex(CUBE, FACES)
    (pose,) = engine.poses(poses([0, 0, 0.5 + half - 0.01], turn=turn))
    assert engine.depth(cube, cube, pose) == pytest.approx(0.01, abs=1e-6)


@pytest.mark.parametrize("number", [0, 1, 2, 40])
def test_boxes_that_meet_are_those_of_each_pair(number):
    rng = np.random.default_rng(5)
    low = rng.uniform(size=(number, 3))
    high = low + rng.uniform(0.0, 0.4, size=(number, 3))
    every = [
        [first, other]
        for first, other in combinations(range(number), 2)
        if (low[first] <= high[other]).all() and (low[other] <= high[first]).all()
    ]
    assert meeting_boxes(low, high).tolist() == every
