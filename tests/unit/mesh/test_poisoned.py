"""Meshes that poison: each ends in a collider, a diagnostic or an error, by every maker, within bounds of
processor time; and so does each way in which a decomposition fails."""

import resource
from functools import partial

import mujoco
import numpy as np
import pytest

from linkwright.stages.export import export
from linkwright.stages.mesh import COLLIDERS, make_geometry
from linkwright.stages.mesh.collide import side_by_side
from linkwright.stages.mesh.collide.improvement import BOUNDS, TASKS, helper
from linkwright.stages.robot.errors import ProtocolError
from linkwright.stages.robot.system.guest import Bounds
from tests.support.building import plan_of
from tests.support.exports import compiled
from tests.support.physics import VISUAL, robot_of_meshes
from tests.support.poison import POISONED, RING, torus
from tests.support.touching import Memory, no_memo

SECONDS = 60.0
"""CPU seconds for one part, by whatever maker: an open part takes the ladder about 25, a million faces 20."""

ENDS = {
    "one triangle": {"W-FLAT"},
    "no volume": {"W-FLAT"},
    "needle": {"W-NO-MESH"},
    "empty": {"W-NO-MESH"},
    "tangle": {"W-COLLIDER"},
    "far": {"W-COM-OUTSIDE"},
}
"""What the ladder reports, beside what may be."""

MAY = {"W-COLLIDER", "W-COM-OUTSIDE", "I-DECIMATED", "W-VISUAL-FACES"}

RINGS = ("not manifold", "inverted", "half inverted", "doubled", "two shells", "far")
"""Those around whose middle there is nothing."""


def cpu():
    """Seconds of this process and of the guests that have ended."""
    used = (resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    return sum(usage.ru_utime + usage.ru_stime for usage in used)


def made(mesh, collider, memo=no_memo, **section):
    """The geometry of one part, and the MJCF with it, compiled. `tolerance`: the ladder of each part."""
    robot, bundle = robot_of_meshes({"Part": mesh})
    if collider == "tolerance":
        collider, section = "ladder", {"colliders": {"*": "ladder"}, **section}
    plan = plan_of(mesh={"collider": collider, **section}, contact={"self": "auto"}, ground={"kind": "none"})
    geometry = make_geometry(robot, bundle, plan, memo)
    return geometry, compiled(export(robot, geometry, plan))


def codes(geometry):
    return {problem.code for problem in geometry.diagnostics}


def touched(model, x):
    """Whether a ray down through a place meets a collider within 2 m."""
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    groups = np.array([group != VISUAL for group in range(6)], dtype=np.uint8)
    above, down, met = np.array([x, 0, 1.0]), np.array([0, 0, -1.0]), np.zeros(1, dtype=np.int32)
    return mujoco.mj_ray(model, data, above, down, groups, 1, -1, met) >= 0


@pytest.mark.slow
@pytest.mark.parametrize("collider", [*COLLIDERS, "tolerance"])
@pytest.mark.parametrize("name", POISONED)
def test_poisoned_mesh_ends_in_a_collider_or_a_diagnostic(name, collider):
    mesh = POISONED[name]()
    before = cpu()
    if name == "NaN":
        with pytest.raises(ProtocolError, match="part Part"):
            made(mesh, collider)
        return
    geometry, model = made(mesh, collider)
    assert cpu() - before < SECONDS
    solid = geometry.shapes_of("base", "collision")
    assert solid or codes(geometry) or collider == "visual"
    if collider == "tolerance":
        ends = ENDS.get(name, set())
        assert ends <= codes(geometry) <= ends | MAY
        assert bool(solid) == (ends <= MAY)
    if solid and collider in ("tolerance", "coacd") and name in RINGS:
        middle = 1e4 if name == "far" else 0.0
        assert not touched(model, middle)
        assert touched(model, middle - 0.025)


# The ladder begins with primitives and hulls.
@pytest.mark.parametrize("collider", sorted({*COLLIDERS, "tolerance"} - {"primitives", "hull"}))
@pytest.mark.slow
def test_million_faces_take_less_than_a_minute(collider):
    before = cpu()
    geometry, model = made(torus(), collider)
    assert cpu() - before < SECONDS
    assert "I-DECIMATED" in codes(geometry)
    if collider in ("tolerance", "coacd"):
        assert [collider.meets for collider in geometry.colliders] == [True]
        assert (touched(model, 0.0), touched(model, 0.03)) == (False, True)


@pytest.mark.slow
def test_quarter_of_a_million_rough_faces_end_too():
    before = cpu()
    geometry, _ = made(torus(1e-4, count=500), "tolerance")
    assert cpu() - before < 4 * SECONDS
    assert geometry.shapes_of("base", "collision")


@pytest.fixture
def guest(tmp_path, monkeypatch):
    """Puts another guest in place of CoACD's, with these lines as its `answer(request)`; or other bounds
    around it."""
    monkeypatch.syspath_prepend(tmp_path)

    def put(lines="", bounds=BOUNDS):
        body = "".join(f"    {line}\n" for line in lines.splitlines())
        (tmp_path / "stand_in.py").write_text(f"def answer(request):\n{body}")
        stand_in = partial(helper, module="stand_in" if lines else TASKS, bounds=bounds)
        monkeypatch.setattr(side_by_side, "helper", stand_in)

    return put


def assert_hull(geometry, message):
    assert [collider.rung for collider in geometry.colliders] == ["hull"]
    (problem,) = (diagnostic for diagnostic in geometry.diagnostics if diagnostic.code == "W-COLLIDER")
    assert message in problem.message


@pytest.mark.parametrize(
    ("lines", "bounds", "message"),
    [
        ("import time\ntime.sleep(1000)", Bounds(0.5, 1 << 30, 1000), "took longer than 0.5 s"),
        pytest.param("import os\nos.abort()", BOUNDS, "crashed (SIGABRT)", marks=pytest.mark.slow),
    ],
    ids=["hang", "crash"],
)
def test_guest_that_hangs_or_crashes_leaves_the_hull(guest, lines, bounds, message):
    guest(lines, bounds)
    memo = Memory()
    assert_hull(made(RING, "coacd", memo)[0], message)
    if "abort" in lines:
        guest()
        again, _ = made(RING, "coacd", memo)
        assert [collider.rung for collider in again.colliders] == ["pieces"]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("bounds", "message"),
    [
        (Bounds(2, 2 << 30, 1 << 26), "took longer than 2 s"),
        (Bounds(60, 300 << 20, 1 << 26), "needed more than 0.315 GB of memory"),
    ],
    ids=["hang", "hunger"],
)
def test_real_mesh_that_takes_too_much_leaves_the_hull(guest, bounds, message):
    """CoACD's own preprocessing on its finest grid: hundreds of megabytes and a minute."""
    guest(bounds=bounds)
    fine = {"preprocess_mode": "on", "preprocess_resolution": 1000}
    assert_hull(made(RING, "coacd", coacd=fine)[0], message)
