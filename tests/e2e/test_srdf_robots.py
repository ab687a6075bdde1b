"""The SRDF of the sample, and of the robots of others: by the rules of MoveIt, and as Pinocchio reads it."""

from contextlib import chdir
from itertools import combinations

import pytest

from tests.support.pages import code
from tests.support.srdf import InPinocchio, Srdf


def srdf(folder):
    (path,) = folder.glob("*.srdf")
    return Srdf(path.read_bytes(), path.with_suffix(".urdf").read_bytes())


def test_it_keeps_the_rules_of_moveit(built):
    assert srdf(built).problems() == []


def test_moveits_package_has_the_same_semantics(built):
    (path,) = (built / "ros2").glob("*_moveit_config/config/*.srdf")
    (urdf,) = (built / "ros2").glob(f"*_description/urdf/{path.stem}.urdf")
    package, own = Srdf(path.read_bytes(), urdf.read_bytes()), srdf(built)
    assert package.problems() == []
    assert [len(group) for group in package.groups.values()] == [len(group) for group in own.groups.values()]
    assert list(package.disabled.values()) == list(own.disabled.values())


def test_pinocchio_has_home_and_leaves_out_what_is_disabled(built):
    semantics, reader = srdf(built), InPinocchio(built)
    poses = [semantics.states(group)["home"] for group in semantics.groups]
    home = {joint: value for pose in poses for joint, value in pose.items()}
    states = reader.states()["home"]
    assert states
    assert max(abs(home[joint] - value) for joint, value in states.items()) < 1e-9
    solid = [link.get("name") for link in semantics.urdf.iterfind("link[collision]")]
    pairs = {frozenset(pair) for pair in combinations(solid, 2)}
    disabled = {frozenset(pair) for pair in semantics.disabled}
    active = reader.active()
    # By itself Pinocchio leaves out what is rigid in its tree.
    assert active <= pairs - disabled
    assert all(reader.is_rigid(*pair) for pair in pairs - disabled - active)


def test_the_page_shows_how_pinocchio_reads_it(built):
    pytest.importorskip("pinocchio")
    (path,) = built.glob("*.srdf")
    (text,), here = code("SRDF.md", "python"), {}
    with chdir(built):
        exec(text.replace("my_arm", path.stem), here)
    assert len(here["home"]) == here["model"].nq
    assert len(here["shapes"].collisionPairs) > 0


def test_what_never_touches_does_so_in_no_fresh_pose(built):
    """Poses are drawn from the URDF's limits, with mimics; open loops are left open."""
    never = {pair for pair, reason in srdf(built).disabled.items() if reason == "Never"}
    assert len(never) > 10 or "sample" not in built.parent.name
    assert InPinocchio(built).touching(never, 1000, 99) == set()
