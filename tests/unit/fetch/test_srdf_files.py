"""The SRDF of a URDF source: where it is looked for, and what becomes of a text that is not readable."""

import pytest

from linkwright.stages.fetch import preflight
from linkwright.stages.fetch.urdf.gather import gather
from linkwright.stages.fetch.urdf.section import UrdfSourceSection
from linkwright.stages.fetch.urdf.source import UrdfSource
from linkwright.stages.robot.bundle import FileBundle
from linkwright.stages.robot.errors import ConfigError, SourceError
from tests.support.building import plan_of
from tests.support.users import put

URDF = '<robot name="arm"><link name="a"/></robot>'


def srdf(group):
    return f'<robot name="arm"><group name="{group}"><link name="a"/></group></robot>'


def gathered(path, **keys):
    """The text of the SRDF and its name, each "" without one."""
    bundle, log = gather(UrdfSourceSection(path=str(path), **keys), {})
    assert isinstance(bundle, FileBundle)
    digest = bundle.requests.get("robot.srdf")
    return bundle.body(digest).decode() if digest else "", bundle.options.get("srdf", ""), log


@pytest.mark.parametrize(
    ("place", "name"),
    [
        ("pkg/urdf/robot.srdf", "robot.srdf"),
        ("pkg/srdf/robot.srdf", "../srdf/robot.srdf"),
        ("pkg/urdf/arm.srdf", "arm.srdf"),
        ("pkg/srdf/arm.srdf", "../srdf/arm.srdf"),
    ],
)
def test_an_srdf_is_found_by_its_name_beside_the_urdf(tmp_path, place, name):
    put(tmp_path, {"pkg/urdf/robot.urdf": URDF, place: srdf("g")})
    assert gathered(tmp_path / "pkg/urdf/robot.urdf") == (srdf("g"), name, ())


def test_the_srdf_of_the_files_name_is_read(tmp_path):
    put(
        tmp_path / "a",
        {"urdf/robot.urdf": URDF, "urdf/arm.srdf": srdf("arm"), "srdf/robot.srdf": srdf("robot")},
    )
    assert gathered(tmp_path / "a/urdf/robot.urdf")[0] == srdf("robot"), (
        "the file's name wins over the robot's"
    )
    assert gathered(tmp_path / "a/urdf/robot.urdf", srdf="none") == ("", "", ())
    put(tmp_path / "b", {"robot.urdf": URDF, "other.srdf": srdf("g")})
    assert gathered(tmp_path / "b/robot.urdf")[0] == "", "another name is not read unless it is named"
    assert gathered(tmp_path / "b/robot.urdf", srdf=str(tmp_path / "b/other.srdf"))[0] == srdf("g")


@pytest.mark.parametrize("text", ["<robot", "<urdf/>", ""])
def test_an_unreadable_srdf_is_an_error_only_if_it_is_named(tmp_path, text):
    put(tmp_path, {"robot.urdf": URDF, "robot.srdf": text, "given.srdf": text})
    content, _, log = gathered(tmp_path / "robot.urdf")
    assert content == ""
    assert [(problem.code, problem.where) for problem in log] == [("W-SRDF", "robot.srdf")]
    with pytest.raises(SourceError) as caught:
        gathered(tmp_path / "robot.urdf", srdf=str(tmp_path / "given.srdf"))
    assert "given.srdf" in (caught.value.where or "")


@pytest.mark.parametrize("name", ["missing.srdf", "robot.srdf.xacro"])
def test_a_named_srdf_must_be_a_plain_file(tmp_path, name):
    put(tmp_path, {"robot.urdf": URDF, "robot.srdf.xacro": srdf("g")})
    source = {"kind": "urdf", "path": str(tmp_path / "robot.urdf"), "srdf": str(tmp_path / name)}
    with pytest.raises(ConfigError) as caught:
        preflight(plan_of(source=source), {})
    assert caught.value.where == "source.srdf"


def test_a_changed_srdf_is_another_source(tmp_path):
    source = UrdfSource(UrdfSourceSection(path=str(tmp_path / "robot.urdf")))
    put(tmp_path, {"robot.urdf": URDF})
    identities = [str(source.pinned({}))]
    for text in (srdf("g"), srdf("h")):
        put(tmp_path, {"robot.srdf": text})
        identities.append(str(source.pinned({})))
    assert len(set(identities)) == 3


def test_paths_of_this_computer_are_not_kept_from_an_srdf(tmp_path):
    text = f'<robot name="arm"><group name="{tmp_path}/g"><link name="a"/></group></robot>'
    put(tmp_path, {"robot.urdf": URDF, "robot.srdf": text})
    assert str(tmp_path) not in gathered(tmp_path / "robot.urdf")[0]
