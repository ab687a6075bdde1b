"""The SRDF of the sample, and of the robots of others: by the rules of MoveIt, and as Pinocchio reads it."""

import re
from contextlib import chdir
from itertools import combinations
from pathlib import Path

import pytest

from tests.support.command import called, environment
from tests.support.other_robots import AS_IT_IS, FILES, is_here, source_of
from tests.support.places import PROJECT
from tests.support.srdf import InPinocchio, Srdf

EVERY = ["sample", *(pytest.param(name, marks=pytest.mark.slow) for name in FILES)]
KEYS = "mesh=hull", "validate=quick", "export=[urdf,ros2]", "output=out", "actuators=position"


@pytest.fixture(scope="module", params=EVERY)
def built(
    request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory, shared_cache: Path
) -> tuple[Path, str]:
    """The folder of a built robot, and its name."""
    if not is_here(request.param):
        pytest.skip("needs the robots of others")
    folder = tmp_path_factory.mktemp(request.param)
    environ = environment(folder, seeded=False, LINKWRIGHT_CACHE=str(shared_cache))
    done = called(folder, *source_of(request.param), *KEYS, *AS_IT_IS, environ=environ)
    assert done.returncode == 0, done.stdout + done.stderr
    (model,) = (folder / "out").glob("*.urdf")
    return folder / "out", model.stem


def srdf(folder: Path, name: str) -> Srdf:
    return Srdf((folder / f"{name}.srdf").read_bytes(), (folder / f"{name}.urdf").read_bytes())


def test_it_keeps_the_rules_of_moveit(built: tuple[Path, str]) -> None:
    assert srdf(*built).problems() == []


def test_moveits_package_has_the_same_semantics(built: tuple[Path, str]) -> None:
    folder, name = built
    (path,) = (folder / "ros2").glob(f"*_moveit_config/config/{name}.srdf")
    (urdf,) = (folder / "ros2").glob(f"*_description/urdf/{name}.urdf")
    found, own = Srdf(path.read_bytes(), urdf.read_bytes()), srdf(folder, name)
    assert found.problems() == []
    assert [len(joints) for joints in found.groups.values()] == [len(one) for one in own.groups.values()]
    assert list(found.disabled.values()) == list(own.disabled.values())


def test_pinocchio_has_home_and_leaves_out_what_is_disabled(built: tuple[Path, str]) -> None:
    folder, name = built
    found, reader = srdf(folder, name), InPinocchio(folder, name)
    home = {key: value for group in found.groups for key, value in found.states(group)["home"].items()}
    states = reader.states()["home"]
    assert states
    assert max(abs(home[joint] - value) for joint, value in states.items()) < 1e-9
    solid = sorted(one.get("name") for one in found.urdf.findall("link") if one.find("collision") is not None)
    every = {frozenset(pair) for pair in combinations(solid, 2)}
    disabled = {frozenset(pair) for pair in found.disabled}
    active = reader.active()
    # By itself Pinocchio leaves out what is rigid in its tree.
    assert active <= every - disabled
    assert all(reader.is_rigid(*pair) for pair in every - disabled - active)


def test_the_page_shows_how_pinocchio_reads_it(built: tuple[Path, str]) -> None:
    pytest.importorskip("pinocchio")
    folder, name = built
    page = (PROJECT / "pipeline/reference/formats/SRDF.md").read_text(encoding="utf-8")
    (code,) = re.findall(r"```python\n(.*?)```", page, re.DOTALL)
    here: dict[str, object] = {}
    with chdir(folder):
        exec(code.replace("my_arm", name), here)
    assert len(here["home"]) == here["model"].nq
    assert len(here["shapes"].collisionPairs) > 0


def test_what_never_touches_does_so_in_no_fresh_pose(built: tuple[Path, str]) -> None:
    """Poses are drawn from the URDF's limits, with mimics; open loops are left open."""
    folder, name = built
    found = srdf(folder, name)
    never = {pair for pair, reason in found.disabled.items() if reason == "Never"}
    if name == "sample":
        assert len(never) > 10
    assert InPinocchio(folder, name).touching(never, 1000, 99) == set()
