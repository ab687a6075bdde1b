"""The validators of ROS and of Gazebo accept what a build writes."""

from pathlib import Path

import pytest

from tests.support.building import plan_of, robot_of, write
from tests.support.command import called, environment
from tests.support.kit import Kit, four_bar
from tests.support.other_robots import AS_IT_IS, FILES, is_here, source_of
from tests.support.validators import check_urdf, ign_sdf

FORMATS = {"urdf": {}, "sdf": {}}
MOST = "mesh=visual", "validate=quick", "export=[urdf,sdf]", "output=out"


EVERY = ["sample", *(pytest.param(name, marks=pytest.mark.slow) for name in FILES)]


@pytest.fixture(scope="module", params=EVERY)
def built(
    request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory, shared_cache: Path
) -> tuple[Path, str]:
    """The folder of a built robot, and its name."""
    if not is_here(request.param):
        pytest.skip("needs the robots of others")
    folder = tmp_path_factory.mktemp(request.param)
    environ = environment(folder, seeded=False, LINKWRIGHT_CACHE=str(shared_cache))
    done = called(folder, *source_of(request.param), *MOST, *AS_IT_IS, environ=environ)
    assert done.returncode == 0, done.stdout + done.stderr
    (model,) = (folder / "out").glob("*.sdf")
    return folder / "out", model.stem


def test_check_urdf_accepts_the_urdf(built: tuple[Path, str]) -> None:
    folder, name = built
    assert check_urdf(folder / f"{name}.urdf") == ""


def test_ign_accepts_the_sdf(built: tuple[Path, str]) -> None:
    folder, name = built
    assert ign_sdf(folder / f"{name}.sdf") == ""


@pytest.fixture
def looped(kit: Kit, tmp_path: Path) -> Path:
    four_bar(kit, limits=True)
    plan = plan_of(export=FORMATS)
    write(robot_of(kit.document, plan), tmp_path, plan)
    return tmp_path


def test_check_urdf_accepts_the_urdf_of_a_loop(looped: Path) -> None:
    assert check_urdf(looped / "robot.urdf") == ""


def test_ign_accepts_the_sdf_of_a_loop(looped: Path) -> None:
    assert ign_sdf(looped / "robot.sdf") == ""


def test_the_tools_refuse_what_is_wrong(looped: Path) -> None:
    urdf, sdf = looped / "robot.urdf", looped / "robot.sdf"
    urdf.write_text(urdf.read_text().replace('<child link="coupler"', '<child link="nothing"'))
    sdf.write_text(sdf.read_text().replace("<child>coupler", "<child>nothing"))
    assert check_urdf(urdf)
    assert ign_sdf(sdf)
