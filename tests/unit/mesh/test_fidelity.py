"""The measurement that colliders are held against from outside, in closed form."""

import mujoco
import numpy as np
import pytest
import trimesh

from tests.support.fidelity import Fidelity, Hull, Round, fidelity, pieces_of, solid_angles

HERE = np.eye(4)


def measured(part: trimesh.Trimesh, pieces: list, tolerance: float) -> Fidelity:
    return fidelity([part], pieces, [tolerance], points=3000)


def cube(*size: float, at: tuple[float, float, float] = (0, 0, 0)) -> Hull:
    return Hull(np.array(np.meshgrid(*[(-0.5, 0.5)] * 3)).reshape(3, -1).T * size + at)


def test_a_box_around_a_box_stands_out_by_its_margin() -> None:
    found = measured(trimesh.creation.box((0.1, 0.1, 0.1)), [cube(0.102, 0.102, 0.102)], 0.0005)
    assert found.protrusion_p95 == pytest.approx(2, rel=1e-6)  # 3.9 % of it are beyond an edge
    assert 2 < found.protrusion_max <= 2 * 3**0.5 + 1e-9
    assert found.bareness_max == 0
    assert found.miss == found.protrusion_p95


def test_a_box_that_is_too_small_leaves_the_part_bare() -> None:
    found = measured(trimesh.creation.box((0.1, 0.06, 0.04)), [cube(0.096, 0.056, 0.036)], 0.001)
    assert found.protrusion_max == 0
    assert found.bareness_max == pytest.approx(2 * 3**0.5, rel=1e-6)  # at the corners


def test_the_hull_of_a_ring_stands_out_by_the_radius_of_its_hole() -> None:
    ring = trimesh.creation.annulus(r_min=0.02, r_max=0.05, height=0.01, sections=128)
    found = measured(ring, [Hull(np.asarray(ring.vertices))], 0.001)
    assert found.protrusion_max == pytest.approx(20, rel=0.05)
    # Of the two discs and the rim, which are 2 π R (R + h), the points nearer to the axis than d.
    near = (0.05 * 0.05 * (0.05 + 0.01)) ** 0.5
    assert found.protrusion_p95 == pytest.approx(20 - near * 1e3, rel=0.03)


def test_of_several_parts_each_has_its_own_tolerance() -> None:
    """Two cubes beside each other, each in a box that is 1 mm larger all around."""
    cubes = [trimesh.creation.box((0.05, 0.05, 0.05)) for _ in range(2)]
    cubes[1].apply_translation((0.2, 0, 0))
    pieces = [cube(0.052, 0.052, 0.052, at=(x, 0, 0)) for x in (0, 0.2)]
    even = fidelity(cubes, pieces, [0.001, 0.001], points=3000)
    assert 2**0.5 - 0.1 < even.protrusion_max < 3**0.5 + 0.01
    uneven = fidelity(cubes, pieces, [0.001, 0.0005], points=3000)
    assert 2 * 2**0.5 - 0.2 < uneven.protrusion_max < 2 * 3**0.5 + 0.02
    gone = fidelity(cubes, pieces[:1], [0.001, 0.001], points=3000)
    assert gone.bareness_max == pytest.approx(1e3 * (0.2 + 0.025 - 0.026), rel=1e-3)


def test_a_seam_is_no_surface() -> None:
    part = trimesh.creation.box((0.1, 0.06, 0.04))
    halves = [cube(0.05, 0.06, 0.04, at=(x, 0, 0)) for x in (-0.025, 0.025)]
    found = measured(part, halves, 0.001)
    assert found.miss == pytest.approx(0, abs=0.25)  # what is nearer is not looked at closely


def test_what_is_open_has_an_inside_by_its_winding_number() -> None:
    part = trimesh.creation.box((0.1, 0.06, 0.04))
    part.update_faces(np.arange(12) != 5)
    found = measured(part, [cube(0.05, 0.03, 0.02)], 0.001)
    assert found.protrusion_max == 0


def test_solid_angles_of_a_closed_surface_are_4_pi_inside_and_nothing_outside() -> None:
    ball = trimesh.creation.icosphere(2)
    found = solid_angles(np.array([[0, 0, 0], [0.3, 0.2, -0.4], [2.0, 0, 0]]), np.asarray(ball.triangles))
    np.testing.assert_allclose(found, [4 * np.pi, 4 * np.pi, 0], atol=1e-9)


@pytest.mark.parametrize(
    ("ends", "part"),
    [
        (False, trimesh.creation.cylinder(0.02, 0.06, sections=256)),
        (True, trimesh.creation.capsule(0.06, 0.02, count=[64, 64])),
    ],
)
def test_what_is_round_is_measured_exactly(ends: bool, part: trimesh.Trimesh) -> None:
    part.apply_translation(-part.bounds.mean(axis=0))
    same = measured(part, [Round(HERE, 0.02, 0.03, ends)], 0.001)
    assert same.miss < 0.25
    larger = measured(part, [Round(HERE, 0.022, 0.032 - 0.002 * ends, ends)], 0.001)
    assert 2 * 0.99 < larger.protrusion_p95 < larger.protrusion_max < 2 * 2**0.5 + 0.01  # at the rims
    assert larger.protrusion_p95 < 2.3
    assert larger.bareness_max == 0
    smaller = measured(part, [Round(HERE, 0.018, 0.03, ends)], 0.001)
    assert smaller.bareness_max == pytest.approx(2, rel=0.05)


def test_the_geoms_of_a_model_are_read_with_their_poses() -> None:
    model = mujoco.MjModel.from_xml_string(
        """<mujoco><worldbody><geom type="plane" size="1 1 1"/><body name="a" pos="1 2 3">
        <geom type="box" size=".01 .02 .03" pos=".1 0 0" euler="0 0 90"/>
        <geom type="sphere" size=".01" pos="0 .2 0"/>
        <geom type="capsule" size=".01 .02" pos="0 0 .3"/>
        <geom type="cylinder" size=".01 .02" contype="0" conaffinity="0"/>
        </body></worldbody></mujoco>"""
    )
    (body, pieces) = next(iter(pieces_of(model).items()))
    assert body == "a"
    box, ball, pill = pieces
    places = np.array([[0.13, 0, 0], [0.1, 0.03, 0], [0, 0.22, 0], [0, 0, 0.35]])
    np.testing.assert_allclose(box.distance(places)[:2], [0.01, 0.02], atol=1e-7)
    np.testing.assert_allclose(ball.distance(places)[2], 0.01, atol=1e-9)
    np.testing.assert_allclose(pill.distance(places)[3], 0.02, atol=1e-9)
