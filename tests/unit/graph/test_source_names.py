"""Names of a URDF or an MJCF: the same in every file that we make of it, wherever its format allows them."""

import json
import re

import mujoco
import pytest
import yaml
from lxml import etree

from linkwright.stages.graph.tree import natural
from linkwright.stages.mesh import make_geometry
from linkwright.stages.mesh.files.names import file_names
from linkwright.stages.robot.text.globs import yaml_key
from tests.support.building import plan_of, write
from tests.support.checked import failures
from tests.support.exports import messages_of
from tests.support.mjcfs import body, model
from tests.support.mjcfs import robot_of as mjcf_robot
from tests.support.mjcfs import written as mjcf_file
from tests.support.pinocchio import pin
from tests.support.places import SHARED
from tests.support.reported import reports
from tests.support.urdfs import lost_names, urdf_bundle, urdf_robot
from tests.unit.graph.urdf.test_reader import BODY, joint, link, robot_text

ODD = ["joint_0.0", "LF-HAA", "left/hip", "upper arm", "Überarm", "a[0]", "x*", "世界", "l'r", "1.0", "null"]
"""Names that URDF and MJCF allow."""


def chain_of(names):
    """A URDF in which each name is a joint's and its child's."""
    links = ["base", *names]
    joints = (joint(name, parent, name) for parent, name in zip(links, names, strict=False))
    return robot_text(*(link(name) for name in links), *joints)


def named(folder, robot):
    """The names in the files of a robot, which pass every check, and whose names are not reported."""
    assert failures(folder, robot) == []
    urdf, mjcf = (etree.parse(folder / f"robot.{end}").getroot() for end in ("urdf", "xml"))
    nodes = {f"urdf {tag}": urdf.findall(tag) for tag in ("link", "joint")}
    nodes |= {f"mjcf {t}": mjcf.find("worldbody").iter(t) for t in ("body", "joint", "freejoint", "site")}
    nodes["mjcf equality"] = mjcf.iterfind("equality/*")
    return {kind: {element.get("name") for element in elements} for kind, elements in nodes.items()}


def table_of(folder):
    return json.loads((folder / "robot.json").read_text())


def test_links_and_joints_of_a_urdf_keep_any_name(tmp_path):
    robot = urdf_robot(chain_of(ODD))
    names = named(tmp_path, robot)
    assert names["urdf link"] == names["mjcf body"] == {"base", *ODD}
    assert names["urdf joint"] == names["mjcf joint"] == set(ODD)
    assert reports(robot, "W-NAME") == []
    assert set(pin.buildModelFromXML((tmp_path / "robot.urdf").read_text()).names) == {"universe", *ODD}


SO101 = SHARED / "data/robots/so101/Simulation/SO101/so101_new_calib.urdf"


@pytest.mark.skipif(not SO101.exists(), reason="there are no shared data")
def test_the_gripper_of_an_so101_stays_the_gripper(tmp_path):
    robot = urdf_robot(SO101.read_bytes())
    write(robot, tmp_path)
    assert "gripper" in {joint.name for joint in robot.joints}
    trees = [etree.parse(path).getroot() for path in (tmp_path / "robot.urdf", SO101)]
    for tag in ("link", "joint"):
        ours, theirs = ({element.get("name") for element in tree.findall(tag)} for tree in trees)
        assert ours == theirs
    assert reports(robot, "W-NAME") == []


def test_a_name_that_cannot_stay_is_mapped_and_reported(tmp_path):
    text = robot_text(
        *(link(name) for name in ("Base", "world", "tip&#10;1", "tip_1")),
        *(joint(name, "Base", name) for name in ("world", "tip_1")),
        joint("tip&#10;1", "world", "tip&#10;1"),
    )
    robot = urdf_robot(text)
    names = named(tmp_path, robot)
    assert names["mjcf body"] == {"Base", "world_link", "tip_1_2", "tip_1"}
    assert names["urdf joint"] == {"world", "tip_1_2", "tip_1"}
    unseen = "'tip\\n1' was renamed to 'tip_1_2': it holds invisible characters"
    assert sorted(messages_of(robot, "W-NAME")) == [
        *(f"the {kind} {unseen}" for kind in ("joint", "link")),
        "the link 'world' was renamed to 'world_link': it is reserved",
    ]
    table = table_of(tmp_path)
    assert {entry["name"]: entry["cad"]["name"] for entry in table["joints"]}["tip_1_2"] == "tip\n1"
    assert {entry["name"]: entry["cad"]["path"] for entry in table["links"]}["world_link"] == ["world"]


def test_names_of_ours_give_way_to_those_of_the_file(tmp_path):
    """The dofs of a planar joint, the links between them, the joints of frames, a floating base, mimics."""
    links = {"base", "slab", "slab_1", "base_free", "eye_fixed"}
    text = robot_text(
        *map(link, sorted(links)),
        link("eye", ""),
        joint("slab", "base", "slab", "planar", ""),
        joint("slab_x", "slab", "slab_1"),
        joint("eye_fixed", "slab", "eye_fixed"),
        joint("base_free", "slab", "base_free", inside='<mimic joint="slab_x"/>'),
        joint("see", "base", "eye", "fixed", ""),
    )
    robot = urdf_robot(text)
    names = named(tmp_path, robot)
    assert names["urdf link"] == links | {"eye", "slab_1_2", "slab_2"}
    joints = {"slab_x", "eye_fixed", "base_free", "slab_x_2", "slab_y", "slab_turn"}
    assert (names["mjcf joint"], names["urdf joint"]) == (joints, joints | {"see"})
    assert names["mjcf freejoint"] == {"base_free_2"}
    assert reports(robot, "W-NAME") == []


def test_joints_that_hold_links_without_a_body_keep_their_names(tmp_path):
    """A frame on a frame, one that carries a joint that moves, and one whose joint has the name of a link."""
    text = robot_text(
        *map(link, ("base", "arm", "eye")),
        *(link(name, "") for name in ("mount", "tool", "tip")),
        joint("turn", "mount", "arm"),
        *(
            joint(*ends, "fixed", "")
            for ends in (
                ("to_mount", "base", "mount"),
                ("arm", "arm", "tool"),
                ("tool_fixed", "tool", "tip"),
                ("mount_fixed", "tip", "eye"),
            )
        ),
    )
    names = named(tmp_path, urdf_robot(text))
    assert lost_names(text.encode(), (tmp_path / "robot.urdf").read_bytes()) == []
    assert names["urdf joint"] == {"to_mount", "turn", "arm", "tool_fixed", "mount_fixed"}
    holders = {frame["name"]: frame["joint"] for frame in table_of(tmp_path)["frames"]}
    assert holders == {"mount": "to_mount", "tool": "arm", "tip": "tool_fixed"}


SHARED = body(
    "Elbow",
    '<freejoint name="floating base"/><site name="Elbow"/>'
    + body("left/hand", '<joint name="Elbow"/><site name="left/hand"/>')
    + body("right.hand", '<joint name="turn"/><site name="pin" pos="0 0 .1"/>'),
)
TIES = """<equality><joint name="Elbow" joint1="turn" joint2="Elbow" polycoef="0 2 0 0 0"/>
  <connect name="turn" site1="pin" site2="left/hand"/></equality>"""


def test_things_of_an_mjcf_keep_their_names_by_kind(tmp_path):
    robot = mjcf_robot(mjcf_file(tmp_path, model(SHARED.replace("0 0 .1", "0 0 0"), TIES)))
    folder = tmp_path / "out"
    names = named(folder, robot)
    bodies, sites = {"Elbow", "left/hand", "right.hand"}, {"pin", "turn_a", "turn_b"}
    assert names == {
        "urdf link": bodies | sites | {"Elbow_frame", "left/hand_frame"},
        "urdf joint": names["urdf joint"],
        "mjcf body": bodies,
        "mjcf joint": {"Elbow", "turn"},
        "mjcf freejoint": {"floating base"},
        "mjcf site": {"Elbow", "left/hand", *sites},
        "mjcf equality": {"Elbow", "turn"},
    }
    assert reports(robot, "W-NAME") == []
    diagnostics = messages_of(write(robot, folder), "I-URDF-NAME")
    pairs = [["Elbow", "Elbow_frame"], ["left/hand", "left/hand_frame"]]
    assert [re.findall("'(.*?)'", message) for message in diagnostics] == pairs
    table = table_of(folder)
    assert table["base"]["joint"] == "floating base"
    assert {frame["name"]: frame["urdf"] for frame in table["frames"]} == dict([*pairs, ("pin", "pin")])
    assert [loop["urdf"] for loop in table["loops"]] == [["turn_a", "turn_b"]]
    assert named(tmp_path / "again", mjcf_robot(folder / "robot.xml")) == names


def test_unnamed_things_of_an_mjcf_get_names_of_their_own(tmp_path):
    inside = body("", "<joint/>") + body("body_2", '<joint name="body_2_2_joint"/>')
    robot = mjcf_robot(mjcf_file(tmp_path, model(body("base", inside)).replace('name=""', "")))
    assert {link.name for link in robot.links} == {"base", "body_2_2", "body_2"}
    assert {joint.name for joint in robot.joints} == {"body_2_2_joint_2", "body_2_2_joint"}


@pytest.mark.parametrize("name", ODD)
def test_the_key_that_a_hint_gives_means_that_name_alone(name):
    keys = yaml.safe_load(f"joints:\n  {yaml_key(name)}: {{limits: [-0.5, 0.5], damping: 7}}\n")["joints"]
    robot = urdf_robot(chain_of(ODD), plan_of(joints=keys))
    assert [dof.name for dof in robot.dofs if dof.dynamics.damping == 7] == [name]


def test_a_key_means_the_name_as_it_stands():
    keys = {"joints": {"a[0]": {"damping": 7}}, "mass": {"links": {"a[0]": {"mass": 5}}}}
    robot = urdf_robot(chain_of(["a[0]", "b"]), plan_of(**keys))
    assert [dof.dynamics.damping for dof in robot.dofs] == [7, None]
    assert robot.link("a[0]").inertial.mass == 5


def test_mesh_files_have_names_that_every_file_system_takes():
    links = ["a/b", "a_b", "A_B", "..", "con.0", "世界", "x" * 300, "x" * 300 + "y"]
    by_link = file_names(dict.fromkeys(links, (1, 1)))
    files = [file for visuals, colliders in by_link.values() for file in (*visuals, *colliders)]
    assert all(re.fullmatch(r"[A-Za-z0-9_]{1,240}\.stl", file) for file in files)
    assert len({file.casefold() for file in files}) == 2 * len(links)
    assert by_link["A_B"] == (["A_B.stl"], ["A_B_collision.stl"])


def test_links_with_odd_names_have_their_meshes(tmp_path):
    box = '<visual><geometry><box size="1 1 1"/></geometry></visual>'
    text = robot_text(link("a/b", BODY + box), link("a_b", BODY + box), joint("a/b", "a/b", "a_b"))
    robot = urdf_robot(text)
    meshes = make_geometry(robot, urdf_bundle(text.encode()), plan_of(), lambda kind, key, make: make())
    write(robot, tmp_path, geometry=meshes)
    compiled = mujoco.MjModel.from_xml_path(str(tmp_path / "robot.xml"))
    assert [compiled.body(number).name for number in range(1, compiled.nbody)] == ["a/b", "a_b"]
    assert compiled.ngeom == 4  # what is seen collides, since nothing else is declared


def test_any_name_has_a_place_among_others():
    names = ["a10", "a2", "a²", "1" * 5000, "٣", "", "a02b"]
    assert sorted(names, key=natural) == ["", "٣", "1" * 5000, "a2", "a02b", "a10", "a²"]
