"""Real robots as USD: each is that of its MJCF and its URDF."""

from pathlib import Path

import numpy as np
import pytest

from linkwright.stages.export import export
from linkwright.stages.fetch.urdf.gather import gather
from linkwright.stages.graph import build_robot
from linkwright.stages.mesh import make_geometry
from tests.e2e.test_urdf_robots import FILES, ROBOTS
from tests.support.building import plan_of
from tests.support.usd import pxr
from tests.support.usd_parity import UsdParity


@pytest.mark.slow
@pytest.mark.skipif(not ROBOTS.exists(), reason="there are no shared data")
@pytest.mark.parametrize("name", FILES)
def test_a_real_robot_is_one_in_three_files(name: str, tmp_path: Path) -> None:
    assert pxr.Usd
    from linkwright.stages.validate.read.usd import check_file

    plan = plan_of(
        source={"kind": "urdf", "path": str(ROBOTS / FILES[name])},
        export={"urdf": {}, "mjcf": {}, "usd": {}},
        mesh={"visual": {"max_faces": 2_000_000}},
        actuators={"*": {"type": "position"}},
    )
    bundle, _ = gather(plan.source, {})
    robot = build_robot(bundle, plan)
    geometry = make_geometry(robot, bundle, plan, lambda kind, key, make: make())
    made = export(robot, geometry, plan)
    files = made.files
    UsdParity(robot, files, tmp_path).agree(np.random.default_rng(0))
    checks = list(check_file(tmp_path / f"{robot.name}.usda", made.written, quick=False))
    assert [check for check in checks if check.fails] == []
    assert len(checks) > 1
    assert files == export(robot, geometry, plan).files
