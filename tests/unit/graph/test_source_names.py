"""Names of a URDF or an MJCF: the same in every file that we make of it, wherever its format allows them."""

import json
import re
from pathlib import Path

import mujoco
import pytest
import yaml
from lxml import etree

from linkwright.stages.graph.tree import natural
from linkwright.stages.mesh import make_geometry
from linkwright.stages.mesh.files.names import file_names
from linkwright.stages.robot.text.globs import as_key
from tests.support.building import plan_of, write
from tests.support.checked import checked
from tests.support.mjcfs import body, model
from tests.support.mjcfs import robot_of as mjcf_robot
from tests.support.mjcfs import written as mjcf_file
from tests.support.pinocchio import pin
from tests.support.places import SHARED
from tests.support.urdfs import lost_names, urdf_bundle, urdf_robot
from tests.unit.graph.urdf.test_reader import BODY, codes, joint, link, robot_text

ODD = ["joint_0.0", "LF-HAA", "left/hip", "upper arm", "Überarm", "a[0]", "x*", "世界", "l'r", "1.0", "null"]
"""Names that URDF and MJCF allow."""


def chain_of(names: list[str]) -> str:
    """A URDF in which each name is a joint's and its child's."""
    links = ["base", *names]
    joints = (joint(name, parent, name) for parent, name in zip(links, names, strict=False))
    return robot_text(*(link(name) for name in links), *joints)


def named(folder: Path, robot) -> dict[str, set[str]]:
    """The names in the files of a robot, which pass every check."""
    exported = write(robot, folder)
    assert not [check for check in checked(folder, robot, plan_of()) if check.fails]
    urdf, mjcf = (etree.fromstring(exported.files[f"robot.{end}"]) for end in ("urdf", "xml"))
    found = {f"urdf {tag}": {one.get("name") for one in urdf.findall(tag)} for tag in ("link", "joint")}
    for tag in ("body", "joint", "freejoint", "site"):
        found[f"mjcf {tag}"] = {one.get("name") for one in mjcf.find("worldbody").iter(tag)}
    found["mjcf equality"] = {one.get("name") for one in mjcf.iterfind("equality/*")}
    return found


def test_links_and_joints_of_a_urdf_keep_any_name_and_may_share_it(tmp_path: Path) -> None:
    robot = urdf_robot(chain_of(ODD))
    found = named(tmp_path, robot)
    assert found["urdf link"] == found["mjcf body"] == {"base", *ODD}
    assert found["urdf joint"] == found["mjcf joint"] == set(ODD)
    assert "W-NAME" not in codes(robot)
    assert set(pin.buildModelFromXML((tmp_path / "robot.urdf").read_text()).names) == {"universe", *ODD}


SO101 = SHARED / "data/robots/so101/Simulation/SO101/so101_new_calib.urdf"


@pytest.mark.skipif(not SO101.exists(), reason="there are no shared data")
def test_the_gripper_of_an_so101_stays_the_gripper(tmp_path: Path) -> None:
    robot = urdf_robot(SO101.read_bytes())
    write(robot, tmp_path)
    found, wanted = (etree.parse(path) for path in (tmp_path / "robot.urdf", SO101))
    assert "gripper" in {one.name for one in robot.joints}
    for tag in ("link", "joint"):
        names, theirs = ({one.get("name") for one in tree.getroot().findall(tag)} for tree in (found, wanted))
        assert names == theirs
    assert "W-NAME" not in codes(robot)


def test_a_name_that_cannot_stay_is_mapped_and_reported(tmp_path: Path) -> None:
    text = robot_text(
        *(link(name) for name in ("Base", "world", "tip&#10;1", "tip_1")),
        joint("world", "Base", "world"),
        joint("tip&#10;1", "world", "tip&#10;1"),
        joint("tip_1", "Base", "tip_1"),
    )
    robot = urdf_robot(text)
    found = named(tmp_path, robot)
    assert found["mjcf body"] == {"Base", "world_link", "tip_1_2", "tip_1"}
    assert found["urdf joint"] == {"world", "tip_1_2", "tip_1"}
    told = [one.message for one in robot.diagnostics if one.code == "W-NAME"]
    assert sorted(told) == [
        "the joint 'tip\\n1' was renamed to 'tip_1_2': it holds invisible characters",
        "the link 'tip\\n1' was renamed to 'tip_1_2': it holds invisible characters",
        "the link 'world' was renamed to 'world_link': it is reserved",
    ]
    table = json.loads((tmp_path / "robot.json").read_text())
    assert {one["name"]: one["cad"]["name"] for one in table["joints"]}["tip_1_2"] == "tip\n1"
    assert {one["name"]: one["cad"]["path"] for one in table["links"]}["world_link"] == ["world"]


def test_what_we_call_things_gives_way_to_what_the_file_calls_them(tmp_path: Path) -> None:
    """The dofs of a planar joint, the links between them, the joints of frames, a floating base, mimics."""
    text = robot_text(
        *(link(name) for name in ("base", "slab", "slab_1", "base_free", "eye_fixed")),
        link("eye", ""),
        joint("slab", "base", "slab", "planar", ""),
        joint("slab_x", "slab", "slab_1"),
        joint("eye_fixed", "slab", "eye_fixed"),
        joint("base_free", "slab", "base_free", inside='<mimic joint="slab_x"/>'),
        joint("see", "base", "eye", "fixed", ""),
    )
    robot = urdf_robot(text)
    found = named(tmp_path, robot)
    assert found["urdf link"] == {
        "base",
        "slab",
        "slab_1",
        "base_free",
        "eye_fixed",
        "eye",
        "slab_1_2",
        "slab_2",
    }
    turns = {"slab_x_2", "slab_y", "slab_turn"}
    assert found["mjcf joint"] == {"slab_x", "eye_fixed", "base_free"} | turns
    assert found["urdf joint"] == {"slab_x", "eye_fixed", "base_free", "see"} | turns
    assert found["mjcf freejoint"] == {"base_free_2"}
    assert "W-NAME" not in codes(robot)


def test_joints_that_hold_links_without_a_body_keep_their_names(tmp_path: Path) -> None:
    """A frame on a frame, one that carries a joint that moves, and one whose joint has the name of a link."""
    text = robot_text(
        *(link(name) for name in ("base", "arm", "eye")),
        *(link(name, "") for name in ("mount", "tool", "tip")),
        joint("to_mount", "base", "mount", "fixed", ""),
        joint("turn", "mount", "arm"),
        joint("arm", "arm", "tool", "fixed", ""),
        joint("tool_fixed", "tool", "tip", "fixed", ""),
        joint("mount_fixed", "tip", "eye", "fixed", ""),
    )
    robot = urdf_robot(text)
    found = named(tmp_path, robot)
    assert lost_names(text.encode(), (tmp_path / "robot.urdf").read_bytes()) == []
    assert found["urdf joint"] == {"to_mount", "turn", "arm", "tool_fixed", "mount_fixed"}
    table = json.loads((tmp_path / "robot.json").read_text())
    holders = {frame["name"]: frame["joint"] for frame in table["frames"]}
    assert holders == {"mount": "to_mount", "tool": "arm", "tip": "tool_fixed"}


SHARED = body(
    "Elbow",
    '<freejoint name="floating base"/><site name="Elbow"/>'
    + body("left/hand", '<joint name="Elbow"/><site name="left/hand"/>')
    + body("right.hand", '<joint name="turn"/><site name="pin" pos="0 0 .1"/>'),
)
TIES = """<equality><joint name="Elbow" joint1="turn" joint2="Elbow" polycoef="0 2 0 0 0"/>
  <connect name="turn" site1="pin" site2="left/hand"/></equality>"""


def test_things_of_an_mjcf_keep_their_names_by_kind(tmp_path: Path) -> None:
    robot = mjcf_robot(mjcf_file(tmp_path, model(SHARED.replace("0 0 .1", "0 0 0"), TIES)))
    found = named(tmp_path / "out", robot)
    assert found["mjcf body"] == found["urdf link"] - {
        "Elbow_frame",
        "left/hand_frame",
        "pin",
        "turn_a",
        "turn_b",
    }
    assert found["mjcf body"] == {"Elbow", "left/hand", "right.hand"}
    assert found["mjcf joint"] == {"Elbow", "turn"}
    assert found["mjcf freejoint"] == {"floating base"}
    assert found["mjcf site"] == {"Elbow", "left/hand", "pin", "turn_a", "turn_b"}
    assert found["mjcf equality"] == {"Elbow", "turn"}
    assert "W-NAME" not in codes(robot)
    told = [one for one in write(robot, tmp_path / "out").diagnostics if one.code == "I-URDF-NAME"]
    assert [re.findall("'(.*?)'", one.message) for one in told] == [
        ["Elbow", "Elbow_frame"],
        ["left/hand", "left/hand_frame"],
    ]
    table = json.loads((tmp_path / "out" / "robot.json").read_text())
    assert table["base"]["joint"] == "floating base"
    urdfs = {one["name"]: one["urdf"] for one in table["frames"]}
    assert urdfs == {"Elbow": "Elbow_frame", "left/hand": "left/hand_frame", "pin": "pin"}
    assert [one["urdf"] for one in table["loops"]] == [["turn_a", "turn_b"]]
    again = mjcf_robot(tmp_path / "out" / "robot.xml")
    assert named(tmp_path / "again", again) == found


def test_what_an_mjcf_does_not_name_gets_a_name_that_nothing_has(tmp_path: Path) -> None:
    inside = body("", "<joint/>") + body("body_2", '<joint name="body_2_2_joint"/>')
    robot = mjcf_robot(mjcf_file(tmp_path, model(body("base", inside)).replace('name=""', "")))
    assert {one.name for one in robot.links} == {"base", "body_2_2", "body_2"}
    assert {one.name for one in robot.joints} == {"body_2_2_joint_2", "body_2_2_joint"}


@pytest.mark.parametrize("name", ODD)
def test_the_key_that_a_hint_gives_means_that_name_alone(name: str) -> None:
    keys = yaml.safe_load(f"joints:\n  {as_key(name)}: {{limits: [-0.5, 0.5], damping: 7}}\n")["joints"]
    robot = urdf_robot(chain_of(ODD), plan_of(joints=keys))
    assert [dof.name for dof in robot.dofs if dof.dynamics.damping == 7] == [name]


def test_a_key_means_the_name_as_it_stands() -> None:
    robot = urdf_robot(
        chain_of(["a[0]", "b"]), plan_of(joints={"a[0]": {"damping": 7}}, mass__links={"a[0]": {"mass": 5}})
    )
    assert [dof.dynamics.damping for dof in robot.dofs] == [7, None]
    assert robot.link("a[0]").inertial.mass == 5


def test_mesh_files_have_names_that_every_file_system_takes() -> None:
    links = ["a/b", "a_b", "A_B", "..", "con.0", "世界", "x" * 300, "x" * 300 + "y"]
    found = file_names(dict.fromkeys(links, (1, 1)))
    files = [file for visuals, colliders in found.values() for file in (*visuals, *colliders)]
    assert all(re.fullmatch(r"[A-Za-z0-9_]{1,240}\.stl", file) for file in files)
    assert len({file.casefold() for file in files}) == 2 * len(links)
    assert found["A_B"] == (["A_B.stl"], ["A_B_collision.stl"])


def test_links_with_odd_names_have_their_meshes(tmp_path: Path) -> None:
    box = '<visual><geometry><box size="1 1 1"/></geometry></visual>'
    text = robot_text(link("a/b", BODY + box), link("a_b", BODY + box), joint("a/b", "a/b", "a_b"))
    bundle = urdf_bundle(text.encode())
    robot = urdf_robot(text)
    geometry = make_geometry(robot, bundle, plan_of(), lambda kind, key, make: make())
    write(robot, tmp_path, geometry=geometry)
    compiled = mujoco.MjModel.from_xml_path(str(tmp_path / "robot.xml"))
    assert [compiled.body(number).name for number in range(1, compiled.nbody)] == ["a/b", "a_b"]
    assert compiled.ngeom == 4  # what is seen collides, since nothing else is declared


def test_any_name_has_a_place_among_others() -> None:
    names = ["a10", "a2", "a²", "1" * 5000, "٣", "", "a02b"]
    assert sorted(names, key=natural) == ["", "٣", "1" * 5000, "a2", "a02b", "a10", "a²"]
