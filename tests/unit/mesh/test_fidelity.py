"""The measurement that colliders are held against from outside, in closed form."""

import mujoco
import numpy as np
import pytest
import trimesh

from tests.support.fidelity import Hull, Round, fidelity, pieces_of, solid_angles

pytestmark = pytest.mark.slow
CUBE = np.array(np.meshgrid(*[(-0.5, 0.5)] * 3)).reshape(3, -1).T


def measured(part, pieces, tolerance=0.001):
    return fidelity([part], pieces, [tolerance], points=3000)


def cube(*size, at=(0, 0, 0)):
    return Hull(CUBE * size + at)


def plate():
    return trimesh.creation.box((0.1, 0.06, 0.04))


def test_box_around_a_box_stands_out_by_its_margin():
    measures = measured(trimesh.creation.box((0.1, 0.1, 0.1)), [cube(0.102, 0.102, 0.102)], 0.0005)
    assert measures.protrusion_p95 == pytest.approx(2, rel=1e-6)  # 3.9 % of it are beyond an edge
    assert 2 < measures.protrusion_max <= 2 * 3**0.5 + 1e-9
    assert (measures.bareness_max, measures.miss) == (0, measures.protrusion_p95)


def test_box_that_is_too_small_leaves_the_part_bare():
    measures = measured(plate(), [cube(0.096, 0.056, 0.036)])
    assert measures.protrusion_max == 0
    assert measures.bareness_max == pytest.approx(2 * 3**0.5, rel=1e-6)  # at the corners


def test_hull_of_a_ring_stands_out_by_the_radius_of_its_hole():
    ring = trimesh.creation.annulus(r_min=0.02, r_max=0.05, height=0.01, sections=128)
    measures = measured(ring, [Hull(np.asarray(ring.vertices))])
    assert measures.protrusion_max == pytest.approx(20, rel=0.05)
    # Of the two discs and the rim, which are 2 π R (R + h), the points nearer to the axis than d.
    near = (0.05 * 0.05 * (0.05 + 0.01)) ** 0.5
    assert measures.protrusion_p95 == pytest.approx(20 - near * 1e3, rel=0.03)


def test_each_of_several_parts_has_its_own_tolerance():
    cubes = [trimesh.creation.box((0.05, 0.05, 0.05)).apply_translation((x, 0, 0)) for x in (0, 0.2)]
    pieces = [cube(0.052, 0.052, 0.052, at=(x, 0, 0)) for x in (0, 0.2)]
    for tolerance, times in ((0.001, 1), (0.0005, 2)):
        measures = fidelity(cubes, pieces, [0.001, tolerance], points=3000)
        assert times * (2**0.5 - 0.1) < measures.protrusion_max < times * (3**0.5 + 0.01)
    gone = fidelity(cubes, pieces[:1], [0.001, 0.001], points=3000)
    assert gone.bareness_max == pytest.approx(1e3 * (0.2 + 0.025 - 0.026), rel=1e-3)


def test_seam_is_no_surface_and_an_open_part_has_an_inside():
    measures = measured(plate(), [cube(0.05, 0.06, 0.04, at=(x, 0, 0)) for x in (-0.025, 0.025)])
    assert measures.miss == pytest.approx(0, abs=0.25)  # nearer distances are not measured closely
    holed = plate()
    holed.update_faces(np.arange(12) != 5)
    assert measured(holed, [cube(0.05, 0.03, 0.02)]).protrusion_max == 0
    ball = trimesh.creation.icosphere(2)
    angles = solid_angles(np.array([[0, 0, 0], [0.3, 0.2, -0.4], [2.0, 0, 0]]), np.asarray(ball.triangles))
    np.testing.assert_allclose(angles, [4 * np.pi, 4 * np.pi, 0], atol=1e-9)


@pytest.mark.parametrize("ends", [False, True])
def test_round_parts_are_measured_exactly(ends):
    create = trimesh.creation
    part = create.capsule(0.06, 0.02, count=[48, 48]) if ends else create.cylinder(0.02, 0.06, sections=128)
    part.apply_translation(-part.bounds.mean(axis=0))

    def against(radius, half):
        return measured(part, [Round(np.eye(4), radius, half, ends)])

    assert against(0.02, 0.03).miss < 0.25
    larger = against(0.022, 0.032 - 0.002 * ends)
    assert 2 * 0.99 < larger.protrusion_p95 < larger.protrusion_max < 2 * 2**0.5 + 0.01  # at the rims
    assert larger.protrusion_p95 < 2.3
    assert larger.bareness_max == 0
    assert against(0.018, 0.03).bareness_max == pytest.approx(2, rel=0.05)


def test_geoms_of_a_model_are_read_with_their_poses():
    model = mujoco.MjModel.from_xml_string(
        """<mujoco><worldbody><geom type="plane" size="1 1 1"/><body name="a" pos="1 2 3">
        <geom type="box" size=".01 .02 .03" pos=".1 0 0" euler="0 0 90"/>
        <geom type="sphere" size=".01" pos="0 .2 0"/>
        <geom type="capsule" size=".01 .02" pos="0 0 .3"/>
        <geom type="cylinder" size=".01 .02" contype="0" conaffinity="0"/>
        </body></worldbody></mujoco>"""
    )
    ((body, (box, ball, pill)),) = pieces_of(model).items()
    assert body == "a"
    places = np.array([[0.13, 0, 0], [0.1, 0.03, 0], [0, 0.22, 0], [0, 0, 0.35]])
    distances = [*box.distance(places)[:2], ball.distance(places)[2], pill.distance(places)[3]]
    np.testing.assert_allclose(distances, [0.01, 0.02, 0.01, 0.02], atol=1e-7)
