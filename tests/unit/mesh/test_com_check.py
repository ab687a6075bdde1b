"""A centre of mass outside the material is reported, and only then."""

import math
from dataclasses import replace

import numpy as np
import pytest

from linkwright.stages.mesh import tessellation
from linkwright.stages.mesh.com_check import outside
from linkwright.stages.mesh.surfaces.pieces import around
from linkwright.stages.robot.model.robot import Inertial, Primitive, frozen
from tests.unit.mesh.test_mesh import FLAT, INERTIAL, Memory, at, geometry, link_of, of_links, part

CUBE = np.array([[x, y, z] for x in (0.0, 1.0) for y in (0.0, 1.0) for z in (0.0, 1.0)])


def with_com(*com, mass=1.0):
    return Inertial(mass, frozen(com), frozen(np.eye(3)))


def reported(*links, memo=None):
    """Link → the message of W-COM-OUTSIDE."""
    found = geometry(of_links(*links), memo).diagnostics
    return {d.where: d.message for d in found if d.code == "W-COM-OUTSIDE"}


@pytest.mark.parametrize(
    ("com", "apart"),
    [
        ((0.5, 0.5, 0.5), None),
        ((1.0, 1.0, 1.0), None),
        ((0.5, 0.5, 1 + 1e-6), None),
        ((0.5, 0.5, 1 + 1e-5), "1e-05 m"),
        ((0.5, -0.25, 0.5), "0.25 m"),
    ],
)
@pytest.mark.parametrize("where", [at(), at(3, -2, 1), at(1, mirror=True)])
def test_a_part_that_weighs_where_it_is_not_is_named(com, apart, where):
    found = reported(link_of("base", part("A", where, inertial=with_com(*com))))
    if apart is None:
        assert found == {}
    else:
        assert f"lies {apart} or more outside" in found["base"]
        assert found["base"].endswith("for: A <1>")


def test_only_the_culprits_are_named_and_links_that_balance_are_not():
    astray = part("A", at(5), "Motor <1>", inertial=with_com(0.5, 0.5, 40, mass=9.0))
    found = reported(
        link_of("base", part("A"), astray), link_of("arm", part("B")), link_of("leaf", part("P"))
    )
    assert list(found) == ["base"]
    assert found["base"].endswith("for: Motor <1>")


def test_a_part_astray_within_a_large_link_is_nothing_to_tell():
    assert reported(link_of("base", part("A"), part("A", at(5), inertial=with_com(-1, 0.5, 0.5)))) == {}


def test_what_is_only_seen_holds_the_centre_of_mass_too():
    ghost = replace(
        part("A", at(5), "Cover <1>", inertial=with_com(0.5, 0.5, 0.5, mass=99.0)), collides=False
    )
    assert reported(link_of("base", part("A"), ghost)) == {}


def test_a_flat_link_must_balance_within_its_plane():
    def leaf(com):
        return link_of("leaf", part("P", inertial=with_com(*com)))

    assert reported(leaf(FLAT.com)) == reported(leaf((1, 1, 0))) == {}
    assert "0.5 m or more" in reported(leaf((0.5, 0.5, 0.5)))["leaf"]
    assert "0.2 m or more" in reported(leaf((0.5, 1.2, 0)))["leaf"]


def test_parts_without_triangles_leave_the_rest_to_judge():
    unseen = part("X", reply=None, inertial=with_com(50, 0, 0))
    astray = part("A", inertial=with_com(0.5, 0.5, 7))
    assert reported(link_of("base", part("A"), unseen)) == {}
    assert reported(link_of("base", unseen)) == {}
    assert reported(link_of("base", astray, unseen))["base"].endswith("for: A <1>")
    assert reported(link_of("base", part("A"), part("gone", inertial=with_com(9, 9, 9)))) == {}
    weightless = part("X", reply=None, inertial=with_com(0, 0, 0, mass=0.0))
    assert list(reported(link_of("base", astray, weightless))) == ["base"]


def test_a_centre_of_mass_that_was_given_is_compared_with_parts_and_shapes():
    ball = Primitive("sphere", (0.5,), at(4))
    given = with_com(4.4, 0, 0)
    assert "were given" in reported(link_of("base", part("A"), given=given))["base"]
    assert reported(link_of("base", part("A"), given=given, shapes=(ball,))) == {}
    assert reported(link_of("tool", given=given, shapes=(ball,))) == {}
    assert "lies 0.39" in reported(link_of("tool", given=with_com(4.9, 0, 0), shapes=(ball,)))["tool"]
    assert reported(link_of("tool", given=given)) == {}
    # What was given may lie in what is not seen, and it stands for what the parts say.
    astray = part("A", inertial=with_com(0.5, 0.5, 7))
    assert reported(link_of("base", astray, part("X", reply=None), given=given)) == {}
    assert reported(link_of("base", astray, given=INERTIAL)) == {}


def test_it_is_reported_again_from_what_was_kept_and_by_todays_mass(monkeypatch):
    memo = Memory()
    good, bad = (link_of("base", part("A", inertial=body)) for body in (INERTIAL, with_com(2, 2, 2)))
    assert reported(good, memo=memo) == {}
    assert list(reported(bad, memo=memo)) == list(reported(bad, memo=memo)) == ["base"]
    assert memo.made == 3
    # A link that balances needs no triangles to say so.
    monkeypatch.setattr(tessellation, "read", None)
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
def test_the_distance_from_a_hull(points, point, distance):
    turned = np.array([[0.36, 0.48, -0.8], [-0.8, 0.6, 0.0], [0.48, 0.64, 0.6]])
    found = outside(points @ turned.T + 3, turned @ np.array(point) + 3)
    assert found == pytest.approx(distance, abs=1e-6)


@pytest.mark.parametrize("kind", ["box", "sphere", "cylinder", "capsule"])
def test_the_points_around_a_primitive_hold_it_closely(kind):
    size = {"box": (0.4, 0.6, 1.0), "sphere": (0.3,)}.get(kind, (0.3, 1.0))
    shape = Primitive(kind, size, at(2, mirror=False))
    points = around(shape) - [2, 0, 0]
    rng = np.random.default_rng(5)
    for direction in rng.normal(size=(300, 3)):
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


def test_of_many_points_those_beyond_the_hull_of_some_are_looked_at_among_all():
    """Inside and out, on a ball of which every fifth point is looked at first."""
    points = np.random.default_rng(1).normal(size=(50_000, 3))
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    assert outside(points, np.array([0.9, 0, 0])) == 0
    assert outside(points, np.array([0, 0.9995, 0])) == 0
    assert outside(points, np.array([0, 0, 1.5])) == pytest.approx(0.5, abs=1e-3)
