"""Meshes that poison: each ends in a collider, a diagnostic or an error, by every maker, within bounds of
processor time; and so does each way in which a decomposition fails."""

import resource
from collections.abc import Callable
from functools import partial
from typing import Any

import mujoco
import numpy as np
import pytest

from linkwright.stages.export import export
from linkwright.stages.mesh import COLLIDERS, make_geometry
from linkwright.stages.mesh.collide import side_by_side
from linkwright.stages.mesh.collide.improvement import BOUNDS, TASKS, helper
from linkwright.stages.robot.errors import ProtocolError
from linkwright.stages.robot.model.geometry import Geometry
from linkwright.stages.robot.system.guest import Bounds
from tests.support.building import plan_of
from tests.support.physics import VISUAL, robot_of_meshes
from tests.support.poison import POISONED, RING, Mesh, torus

SECONDS = 60.0
"""CPU seconds for one part, by whatever maker: an open one takes the ladder about 25, a million faces 20."""

ENDS = {
    "one triangle": {"W-FLAT"},
    "no volume": {"W-FLAT"},
    "needle": {"W-NO-MESH"},
    "empty": {"W-NO-MESH"},
    "tangle": {"W-COLLIDER"},
    "far": {"W-COM-OUTSIDE"},
}
"""What the ladder says, beside what may be."""

MAY = {"W-COLLIDER", "W-COM-OUTSIDE", "I-DECIMATED", "W-VISUAL-FACES"}

RINGS = ("not manifold", "inverted", "half inverted", "doubled", "two shells", "far")
"""Those around whose middle there is nothing."""

QUICK = ("one triangle", "no volume", "needle", "empty", "NaN", "tangle")
"""Those of which little is made."""


def cpu() -> float:
    """Seconds of this process and of the guests that have ended."""
    used = (resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    return sum(one.ru_utime + one.ru_stime for one in used)


def made(mesh: Mesh, collider: str, memo: Any = None, **section: Any) -> tuple[Geometry, mujoco.MjModel]:
    """The geometry of one part, and the MJCF with it, compiled. `tolerance`: the ladder of each part."""
    robot, bundle = robot_of_meshes({"Part": mesh})
    if collider == "tolerance":
        collider, section = "ladder", {"colliders": {"*": "ladder"}, **section}
    plan = plan_of(mesh={"collider": collider, **section}, contact={"self": "auto"}, ground={"kind": "none"})
    geometry = make_geometry(robot, bundle, plan, memo or (lambda kind, key, make: make()))
    files = export(robot, geometry, plan).files
    assets = {name: data for name, data in files.items() if not name.endswith(".xml")}
    return geometry, mujoco.MjSpec.from_string(files["robot.xml"].decode(), assets=assets).compile()


def said(geometry: Geometry) -> set[str]:
    return {problem.code for problem in geometry.diagnostics}


def touched(model: mujoco.MjModel, place: np.ndarray) -> bool:
    """Whether a ray down through a place meets a collider within 2 m."""
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    groups = np.ones(6, dtype=np.uint8)
    groups[VISUAL] = 0
    met = np.zeros(1, dtype=np.int32)
    down = np.array([0.0, 0, -1])
    above = place + np.array([0.0, 0, 1])
    return bool(mujoco.mj_ray(model, data, above, down, groups, 1, -1, met) >= 0)


def cases() -> list[Any]:
    quick = dict.fromkeys(("ladder", "tolerance", "coacd", "spheres"), QUICK)
    return [
        pytest.param(name, collider, marks=[] if name in quick.get(collider, POISONED) else pytest.mark.slow)
        for collider in (*COLLIDERS, "tolerance")
        for name in POISONED
    ]


@pytest.mark.slow
@pytest.mark.parametrize(("name", "collider"), cases())
def test_a_poisoned_mesh_ends_in_a_collider_or_a_diagnostic(name: str, collider: str) -> None:
    mesh = POISONED[name]()
    before = cpu()
    if name == "NaN":
        with pytest.raises(ProtocolError, match="part Part"):
            made(mesh, collider)
        return
    geometry, model = made(mesh, collider)
    assert cpu() - before < SECONDS
    solid = geometry.of("base", "collision")
    assert solid or said(geometry) or collider == "visual"
    if collider == "tolerance":
        assert said(geometry) >= ENDS.get(name, set())
        assert said(geometry) <= ENDS.get(name, set()) | MAY
        assert bool(solid) == (ENDS.get(name, set()) <= MAY)
    if solid and collider in ("tolerance", "coacd") and name in RINGS:
        middle = np.array([1e4 if name == "far" else 0.0, 0, 0])
        assert not touched(model, middle)
        assert touched(model, middle - np.array([0.025, 0, 0]))


# The ladder begins with primitives and hulls.
@pytest.mark.parametrize("collider", sorted({*COLLIDERS, "tolerance"} - {"primitives", "hull"}))
@pytest.mark.slow
def test_a_million_faces_take_less_than_a_minute(collider: str) -> None:
    before = cpu()
    geometry, model = made(torus(), collider)
    assert cpu() - before < SECONDS
    assert "I-DECIMATED" in said(geometry)
    if collider in ("tolerance", "coacd"):
        assert [one.meets for one in geometry.colliders] == [True]
        assert not touched(model, np.zeros(3))
        assert touched(model, np.array([0.03, 0, 0]))


@pytest.mark.slow
def test_a_quarter_of_a_million_rough_faces_end_too() -> None:
    """Off by a tenth of a millimetre everywhere, as a scan is."""
    before = cpu()
    geometry, _ = made(torus(1e-4, count=500), "tolerance")
    assert cpu() - before < 4 * SECONDS
    assert geometry.of("base", "collision")


@pytest.fixture
def guest(tmp_path, monkeypatch) -> Callable[..., None]:
    """Puts another guest in the place of CoACD's, with these lines as its `answer(request)`; or other bounds
    around that one."""
    monkeypatch.syspath_prepend(tmp_path)

    def put(lines: str = "", bounds: Bounds = BOUNDS) -> None:
        body = "".join(f"    {line}\n" for line in lines.splitlines())
        (tmp_path / "stand_in.py").write_text(f"def answer(request):\n{body}")
        stand_in = partial(helper, module="stand_in" if lines else TASKS, bounds=bounds)
        monkeypatch.setattr(side_by_side, "helper", stand_in)

    return put


@pytest.mark.parametrize(
    ("lines", "bounds", "told"),
    [
        ("import time\ntime.sleep(1000)", Bounds(0.5, 1 << 30, 1000), "took longer than 0.5 s"),
        ("import os\nos.abort()", BOUNDS, "crashed (SIGABRT)"),
        (
            "import time\nheld = b'x' * (400 << 20)\ntime.sleep(1000)",
            Bounds(60, 210 << 20, 1000),
            "needed more than 0.22 GB of memory",
        ),
    ],
    ids=["hang", "crash", "hunger"],
)
def test_a_guest_that_hangs_crashes_or_hungers_leaves_the_hull(
    guest: Callable[..., None], lines: str, bounds: Bounds, told: str
) -> None:
    """And is asked again next time, when it may do better."""
    guest(lines, bounds)
    kept: dict[str, bytes] = {}

    def memo(kind: str, key: Any, make: Callable[[], bytes]) -> bytes:
        name = str((kind, key))
        if name not in kept:
            kept[name] = make()
        return kept[name]

    geometry, _ = made(RING, "coacd", memo)
    assert [one.rung for one in geometry.colliders] == ["hull"]
    (problem,) = (one for one in geometry.diagnostics if one.code == "W-COLLIDER")
    assert told in problem.message
    if "abort" in lines:
        guest()
        again, _ = made(RING, "coacd", memo)
        assert [one.rung for one in again.colliders] == ["pieces"]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("bounds", "told"),
    [
        (Bounds(2, 2 << 30, 1 << 26), "took longer than 2 s"),
        (Bounds(60, 300 << 20, 1 << 26), "needed more than 0.315 GB of memory"),
    ],
    ids=["hang", "hunger"],
)
def test_a_real_mesh_that_takes_too_much_leaves_the_hull(
    guest: Callable[..., None], bounds: Bounds, told: str
) -> None:
    """CoACD's own preprocessing on its finest grid: hundreds of megabytes and a minute."""
    guest(bounds=bounds)
    geometry, _ = made(RING, "coacd", coacd={"preprocess_mode": "on", "preprocess_resolution": 1000})
    assert [one.rung for one in geometry.colliders] == ["hull"]
    (problem,) = (one for one in geometry.diagnostics if one.code == "W-COLLIDER")
    assert told in problem.message
