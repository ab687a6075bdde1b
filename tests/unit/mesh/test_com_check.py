"""A centre of mass outside the material is reported, and only then."""

import math
from dataclasses import replace

import numpy as np
import pytest

from linkwright.stages.mesh import part_mesh
from linkwright.stages.mesh.com_check import distance_outside_hull
from linkwright.stages.mesh.surfaces.pieces import enclosing_points
from linkwright.stages.robot.model.robot import Inertial, Primitive, frozen
from tests.support.touching import Memory
from tests.unit.mesh.test_mesh import FLAT, INERTIAL, at, geometry, link_of, of_links, part

CUBE = np.array([[x, y, z] for x in (0.0, 1.0) for y in (0.0, 1.0) for z in (0.0, 1.0)])


def with_com(*com, mass=1.0):
    return Inertial(mass, frozen(com), frozen(np.eye(3)))


def reported(*links, memo=None):
    """Link → the message of W-COM-OUTSIDE."""
    diagnostics = geometry(of_links(*links), memo).diagnostics
    return {row.where: row.message for row in diagnostics if row.code == "W-COM-OUTSIDE"}


@pytest.mark.parametrize(
    ("com", "distance"),
    [
        ((0.5, 0.5, 0.5), None),
        ((1.0, 1.0, 1.0), None),
        ((0.5, 0.5, 1 + 1e-6), None),
        ((0.5, 0.5, 1 + 1e-5), "1e-05 m"),
        ((0.5, -0.25, 0.5), "0.25 m"),
    ],
)
@pytest.mark.parametrize("where", [at(), at(3, -2, 1), at(1, mirror=True)])
def test_part_whose_centre_of_mass_is_outside_is_named(com, distance, where):
    message = reported(link_of("base", part("A", where, inertial=with_com(*com)))).get("base", "")
    assert (f"lies {distance} or more outside" in message) == (distance is not None)
    assert message.endswith("for: A <1>") or not message


BALL = (Primitive("sphere", (0.5,), at(4)),)
UNSEEN = part("X", reply=None, inertial=with_com(50, 0, 0))
ASTRAY = part("A", inertial=with_com(0.5, 0.5, 7))
FAR_MOTOR = part("A", at(5), "Motor <1>", inertial=with_com(0.5, 0.5, 40, mass=9.0))
COVER = part("A", at(5), "Cover <1>", inertial=with_com(0.5, 0.5, 0.5, mass=99.0))
BY_USER = with_com(4.4, 0, 0)


def leaf(*com):
    return link_of("base", part("P", inertial=with_com(*com)))


@pytest.mark.parametrize(
    ("link", "message"),
    [
        (link_of("base", part("A"), FAR_MOTOR), "for: Motor <1>"),
        # Astray within a large link.
        (link_of("base", part("A"), part("A", at(5), inertial=with_com(-1, 0.5, 0.5))), None),
        # A part that is only seen holds the centre of mass too.
        (link_of("base", part("A"), replace(COVER, collides=False)), None),
        # A flat link must balance within its plane.
        (leaf(*FLAT.com), None),
        (leaf(1, 1, 0), None),
        (leaf(0.5, 0.5, 0.5), "0.5 m or more"),
        (leaf(0.5, 1.2, 0), "0.2 m or more"),
        # Parts without triangles leave the rest to judge.
        (link_of("base", part("A"), UNSEEN), None),
        (link_of("base", UNSEEN), None),
        (link_of("base", ASTRAY, UNSEEN), "for: A <1>"),
        (link_of("base", part("A"), part("gone", inertial=with_com(9, 9, 9))), None),
        (link_of("base", ASTRAY, part("X", reply=None, inertial=with_com(0, 0, 0, mass=0.0))), "A <1>"),
        # A centre of mass by the user is compared with parts and shapes.
        (link_of("base", part("A"), inertial=BY_USER), "were given"),
        (link_of("base", part("A"), inertial=BY_USER, shapes=BALL), None),
        (link_of("base", inertial=BY_USER, shapes=BALL), None),
        (link_of("base", inertial=with_com(4.9, 0, 0), shapes=BALL), "lies 0.39"),
        (link_of("base", inertial=BY_USER), None),
        # It may be in a part that is not seen, and it replaces what the parts say.
        (link_of("base", ASTRAY, part("X", reply=None), inertial=BY_USER), None),
        (link_of("base", ASTRAY, inertial=INERTIAL), None),
    ],
)
def test_links_out_of_balance_are_reported(link, message):
    messages = reported(link, link_of("arm", part("B")))
    assert set(messages) == ({"base"} if message else set())
    assert message is None or message in messages["base"]


def test_report_comes_from_the_cache_and_by_the_mass_of_today(monkeypatch):
    memo = Memory()
    good, bad = (link_of("base", part("A", inertial=body)) for body in (INERTIAL, with_com(2, 2, 2)))
    assert reported(good, memo=memo) == {}
    assert list(reported(bad, memo=memo)) == list(reported(bad, memo=memo)) == ["base"]
    assert memo.made == 3
    # A link that balances needs no triangles to say so.
    monkeypatch.setattr(part_mesh, "decode_meshes", None)
    assert reported(good, memo=memo) == {}


@pytest.mark.parametrize(
    ("points", "point", "distance"),
    [
        (CUBE, (0.5, 0.5, 0.5), 0.0),
        (CUBE, (0.5, 0.5, 1.5), 0.5),
        (CUBE[[0, 3, 5, 6]], (0.9, 0.9, 0.9), 0.7 / math.sqrt(3)),
        (CUBE * [1, 1, 0], (0.2, 0.3, 0.1), 0.1),
        (CUBE * [1, 1, 1e-7], (1.2, 0.3, 0), 0.2),
        (CUBE * [1, 0, 0], (0.5, 0.3, 0), 0.3),
        (CUBE * [1, 0, 0], (0.5, 0, 0), 0.0),
        (CUBE * 0, (0, 0, 0.25), 0.25),
    ],
)
def test_distance_from_a_hull(points, point, distance):
    turned = np.array([[0.36, 0.48, -0.8], [-0.8, 0.6, 0.0], [0.48, 0.64, 0.6]])
    distances = distance_outside_hull(points @ turned.T + 3, turned @ np.array(point) + 3)
    assert distances == pytest.approx(distance, abs=1e-6)


def test_distance_from_a_hull_of_many_points_is_by_all_of_them():
    """Inside and out, on a ball of which every fifth point is tried first."""
    points = np.random.default_rng(1).normal(size=(50_000, 3))
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    assert (
        distance_outside_hull(points, np.array([0.9, 0, 0]))
        == distance_outside_hull(points, np.array([0, 0.9995, 0]))
        == 0
    )
    assert distance_outside_hull(points, np.array([0, 0, 1.5])) == pytest.approx(0.5, abs=1e-3)


@pytest.mark.parametrize("kind", ["box", "sphere", "cylinder", "capsule"])
def test_points_around_a_primitive_hold_it_closely(kind):
    size = {"box": (0.4, 0.6, 1.0), "sphere": (0.3,)}.get(kind, (0.3, 1.0))
    points = enclosing_points(Primitive(kind, size, at(2))) - [2, 0, 0]
    for direction in np.random.default_rng(5).normal(size=(300, 3)):
        direction /= np.linalg.norm(direction)
        reach = support(kind, size, direction)
        assert reach * (1 - 1e-12) <= (points @ direction).max() <= reach * 1.006


def support(kind, size, direction):
    """How far a shape reaches in a direction, in closed form."""
    if kind == "box":
        return float(np.abs(direction) @ size) / 2
    if kind == "sphere":
        return size[0]
    along = abs(direction[2]) * size[1] / 2
    return along + size[0] * (1.0 if kind == "capsule" else math.hypot(*direction[:2]))
