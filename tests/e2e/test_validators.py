"""The validators of ROS and of Gazebo accept what a build writes."""

import pytest

from tests.support.building import plan_of, robot_of, write
from tests.support.kit import four_bar
from tests.support.validators import check_urdf, ign_sdf


@pytest.mark.parametrize(("check", "suffix"), [(check_urdf, "urdf"), (ign_sdf, "sdf")])
def test_a_validator_accepts_the_file(built, check, suffix):
    (path,) = built.glob(f"*.{suffix}")
    assert check(path) == ""


def test_validators_accept_a_loop_and_refuse_a_link_that_is_not_there(kit, tmp_path):
    four_bar(kit, limits=True)
    plan = plan_of(export={"urdf": {}, "sdf": {}})
    write(robot_of(kit.document, plan), tmp_path, plan)
    urdf, sdf = tmp_path / "robot.urdf", tmp_path / "robot.sdf"
    assert check_urdf(urdf) == ign_sdf(sdf) == ""
    urdf.write_text(urdf.read_text().replace('<child link="coupler"', '<child link="nothing"'))
    sdf.write_text(sdf.read_text().replace("<child>coupler", "<child>nothing"))
    assert check_urdf(urdf)
    assert ign_sdf(sdf)
