"""Hollow parts stay hollow in MuJoCo: a ball falls through a ring and rests in a bowl, a peg enters its
hole, a block its clamp."""

from functools import cache

import mujoco
import numpy as np
import pytest
import trimesh

from tests.fake_onshape import solids
from tests.support.physics import fixture, settled, with_dropped

SPHERE, BOX, CYLINDER = (
    mujoco.mjtGeom.mjGEOM_SPHERE,
    mujoco.mjtGeom.mjGEOM_BOX,
    mujoco.mjtGeom.mjGEOM_CYLINDER,
)
HOLE = 0.010
"""Half the width of the hole in the block, 30 mm high, whose top is at 15 mm [m]."""


def ring():
    return trimesh.creation.annulus(0.02, 0.03, 0.02, sections=24)


def clamp():
    """A C that opens upwards: 20 mm wide and 30 mm deep, its floor at z = 10 mm."""
    return trimesh.boolean.difference(
        [
            trimesh.creation.box(bounds=[(-0.02, -0.01, 0), (0.02, 0.01, 0.04)]),
            trimesh.creation.box(bounds=[(-0.01, -0.02, 0.01), (0.01, 0.02, 0.05)]),
        ],
        engine="manifold",
    )


def bowl():
    """Half a ball of 30 mm, hollow to 25 mm: inside it is deepest at z = −25 mm."""
    angles = np.linspace(0, np.pi / 2, 9)
    outer = [(0.03 * np.sin(t), -0.03 * np.cos(t)) for t in angles[1:]]
    inner = [(0.025 * np.sin(t), -0.025 * np.cos(t)) for t in angles[:0:-1]]
    solid = solids.revolve([(0, -0.03), *outer, *inner, (0, -0.025)], 24)
    return trimesh.Trimesh(solid.vertices, solid.triangles)


def block(hole):
    return trimesh.boolean.difference([trimesh.creation.box((0.05, 0.05, 0.03)), hole], engine="manifold")


SHAPES = {
    "ring": ring,
    "clamp": clamp,
    "bowl": bowl,
    "square hole": lambda: block(trimesh.creation.box((2 * HOLE, 2 * HOLE, 0.05))),
    "round hole": lambda: block(trimesh.creation.cylinder(HOLE, 0.05, sections=48)),
}


@cache
def part(name, tolerance=None):
    chosen = {"make": "ladder", "tolerance": tolerance}
    return fixture(SHAPES[name](), colliders={"Part": chosen})


def end(fixture, kind, size, start, seconds):
    """Where a body comes to that is let go at `start`."""
    _, data = settled(with_dropped(fixture.spec(), kind, size, start), seconds)
    return data.body("dropped").xpos.copy()


@pytest.mark.slow
def test_a_ball_falls_through_a_ring_if_it_is_smaller_than_the_hole():
    (figures,) = part("ring").geometry.colliders
    assert (figures.rung, figures.meets) == ("pieces", True)
    assert end(part("ring"), SPHERE, [0.017, 0, 0], [0, 0, 0.04], 0.4)[2] < -0.1
    assert end(part("ring"), SPHERE, [0.022, 0, 0], [0, 0, 0.04], 0.4)[2] > 0.01


def test_a_block_enters_a_clamp_and_stands_on_its_floor():
    (figures,) = part("clamp").geometry.colliders
    assert (figures.rung, figures.meets) == ("pieces", True)
    place = end(part("clamp"), BOX, [0.0085, 0.009, 0.0085], [0, 0, 0.055], 0.6)
    assert place[2] == pytest.approx(0.01 + 0.0085, abs=figures.tolerance or 0)
    assert end(part("clamp"), BOX, [0.0125, 0.009, 0.0085], [0, 0, 0.055], 0.6)[2] > 0.045


@pytest.mark.slow
def test_a_ball_rests_in_a_bowl():
    (figures,) = part("bowl").geometry.colliders
    assert figures.rung == "pieces"
    model, data = settled(with_dropped(part("bowl").spec(), SPHERE, [0.006, 0, 0], [0.008, 0, 0.01]), 2)
    assert np.abs(data.qvel).max() < 1e-3
    # As deep as in the bowl itself, but for what its sixteen pieces stand out.
    off = data.body("dropped").xpos - [0, 0, -0.025 + 0.006]
    assert -0.0005 < off[2] < figures.measures.protrusion_p95
    assert np.hypot(*off[:2]) < 0.006
    assert model.nbody == 3


@pytest.mark.parametrize(
    ("name", "tolerance", "kind", "size"),
    [
        ("square hole", 0.0005, BOX, [HOLE - 0.0005, HOLE - 0.0005, 0.015]),
        ("round hole", 0.0002, CYLINDER, [HOLE - 0.0005, 0.015, 0]),
    ],
)
@pytest.mark.slow
def test_a_peg_with_1_mm_of_play_enters_its_hole(name, tolerance, kind, size):
    """The tolerances are what such holes need: the default one, 1.2 mm here, is more than the play."""
    fixture = part(name, tolerance)
    (figures,) = fixture.geometry.colliders
    assert (figures.rung, figures.meets) == ("pieces", True)
    for aside in (0.0, 0.0003):
        # Its lower end has come out below.
        assert end(fixture, kind, size, [aside, 0, 0.032], 0.5)[2] < 0.0
    wide = [size[0] + 0.001, *size[1:]]
    assert end(fixture, kind, wide, [0, 0, 0.032], 0.5)[2] > 0.025
