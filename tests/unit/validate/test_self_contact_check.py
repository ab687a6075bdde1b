"""The check of the robot's contact with itself finds what touches at `home` and should not, or is unknown."""

from dataclasses import replace

import mujoco
import pytest

from linkwright.stages.robot.motion.start_pose import home
from linkwright.stages.validate.checks.contact import contact_filter
from tests.support.building import plan_of, write
from tests.support.checked import checked
from tests.support.exports import compiled, exported
from tests.support.robots import at, joint, robot_with
from tests.support.touching import ball, geometry_of, in_mujoco
from tests.unit.mesh.test_contacts import base_arm_hand, gripper

pytestmark = pytest.mark.usefixtures("no_score")


def closed_gripper():
    """Its racks always overlap, and its pads do at home, by 6 mm."""
    return gripper(-0.058)


def failures(robot, geometry, folder, *edits):
    """What the checks of each file say that fail; the files are written with `edits`, each of which is
    needed."""
    write(robot, folder, geometry=geometry)
    file = folder / f"{robot.name}.xml"
    text = file.read_text()
    for old, new in edits:
        assert old in text
        text = text.replace(old, new)
    file.write_text(text)
    checks = checked(folder, robot, plan_of(), geometry=geometry)
    own = [check for check in checks if check.name.endswith("contact with itself")]
    assert [check.name.split(":")[0] for check in own] == [file.name]
    assert all(check.passed == (check.value == 0) for check in own)
    assert len({check.detail for check in own}) == 1
    # What may collide, and how deep it starts, is judged by other checks too.
    alike = ("C-SELF-CONTACT", "C-EXCLUDE", "C-START")
    assert [check for check in checks if check.fails and check.code not in alike] == []
    return [check.detail for check in own if check.fails]


@pytest.mark.parametrize("self", ["auto", "all", "none"])
@pytest.mark.parametrize("made", [closed_gripper, gripper, base_arm_hand])
def test_what_was_exported_passes(self, made, tmp_path):
    robot = made()
    geometry = geometry_of(robot, self=self)
    assert failures(robot, geometry, tmp_path) == []


def test_ground_is_no_part_of_a_root_that_is_the_world(tmp_path):
    """The arm stands in it, and is excluded from contact with the world's own shapes alone."""
    bare = robot_with([joint("revolute", "world", "arm", place=at(0, 0, -0.1))], root="world")
    robot = replace(bare, links=tuple(replace(link, shapes=(ball(0.21),)) for link in bare.links))
    geometry = geometry_of(robot, self="all", exclude=[["world", "arm"]])
    write(robot, tmp_path, geometry=geometry)
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "scene.xml"))
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    assert [{model.geom(geom).name for geom in contact.geom} for contact in data.contact] == [
        {"floor", "arm_collision"}
    ]
    assert failures(robot, geometry, tmp_path) == []


def test_reported_pairs_are_counted_if_the_geometry_is_known(tmp_path):
    robot = closed_gripper()
    geometry = geometry_of(robot)
    write(robot, tmp_path, geometry=geometry)
    for options, details in (
        ({"geometry": geometry}, ["1 pair of links touches at home, as reported"]),
        ({}, []),
    ):
        checks = checked(tmp_path, robot, plan_of(), **options)
        assert [check.detail for check in checks if "contact with itself" in check.name] == details


EXCLUDED, UNKNOWN = "which are excluded from contact", "which was not reported"


def touching():
    return base_arm_hand(hand=ball(0.06))


def exclude(first, second):
    return f'<exclude body1="{first}" body2="{second}"/>'


@pytest.mark.parametrize(
    ("made", "self", "edit", "said"),
    [
        (touching, "auto", (exclude("base", "hand"), ""), f"base and hand, {EXCLUDED}"),
        (closed_gripper, "auto", (exclude("left", "right"), ""), f"left and right, {EXCLUDED}"),
        (touching, "none", ('conaffinity="2"', 'conaffinity="1"'), f"base and hand, {UNKNOWN}"),
    ],
)
def test_links_that_touch_and_should_not_fail(made, self, edit, said, tmp_path):
    robot = made()
    (detail, *_) = failures(robot, geometry_of(robot, self=self), tmp_path, edit)
    assert detail.startswith("touching at home: ")
    assert said in detail


RACKS = 'geom1="left_collision_0" geom2="right_collision_0"'


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("<pair ", '<pair friction="1 1 0 0 0" ', "friction"),
        ("<pair ", '<pair margin="0.002" ', "margin"),
        ("<contact>", f"<contact><pair {RACKS}/>", "geom1, geom2"),
        ('<pair geom1="left_collision_1" geom2="right_collision_1"/>', "", "body1, body2"),
    ],
)
def test_pairs_are_those_of_the_robot_with_its_properties(old, new, said, tmp_path):
    robot = closed_gripper()
    geometry = geometry_of(robot)
    write(robot, tmp_path, geometry=geometry)
    file = tmp_path / f"{robot.name}.xml"
    assert old in file.read_text()
    file.write_text(file.read_text().replace(old, new, 1))
    checks = checked(tmp_path, robot, plan_of(), geometry=geometry)
    findings = [finding for check in checks if check.code == "C-EXCLUDE" for finding in check.findings]
    assert {finding.attribute for finding in findings} == {said}


def test_pair_that_touches_and_is_not_reported_fails(tmp_path):
    robot = closed_gripper()
    geometry = geometry_of(robot)
    assert in_mujoco(compiled(exported(robot, geometry)), robot, home(robot)) == {("left", "right")}
    (said, *_) = failures(robot, replace(geometry, touching=()), tmp_path)
    assert said == "touching at home: left and right, which was not reported"


def test_mix_of_geoms_without_a_share():
    """As MuJoCo mixes them: two geoms whose `solmix` is 0 have equal shares."""
    balls = "".join(
        f'<body name="{name}"><freejoint/><geom size=".1" solmix="0" solref="{time} 1"/></body>'
        for name, time in (("a", 0.02), ("b", 0.04))
    )
    model = mujoco.MjModel.from_xml_string(f"<mujoco><worldbody>{balls}</worldbody></mujoco>")
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    mixed = contact_filter._mixed_properties(model, 0, 1)
    assert mixed["solref"] == pytest.approx(data.contact[0].solref)
    assert mixed["solimp"] == pytest.approx(data.contact[0].solimp)
