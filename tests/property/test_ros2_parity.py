"""Random documents: the ROS 2 package has the robot of the URDF beside it, and its parts agree."""

import tempfile
from pathlib import Path

import pytest
from hypothesis import strategies as st

from linkwright.stages.export import export
from linkwright.stages.robot.motion.start_pose import home
from tests.fake_onshape.document import Document
from tests.support.building import NO_MESHES, plan_of, robot_of
from tests.support.drawn import any_document, each
from tests.support.ros2 import check_control, check_manifest, home_of, packed, same_robot, same_text

KINDS = ("position", "motor")


def agree(document: Document, seed: int):
    keys = {"export": {"urdf": {}, "ros2": {}}, "actuators": {"*": KINDS[seed % 2]}}
    free = robot_of(document).root.name != "world" and seed % 3 == 1
    plan = plan_of(root={"base": "free" if free else "fixed"}, **keys)
    robot = robot_of(document, plan)
    files = export(robot, NO_MESHES, plan).files
    urdf = files["robot.urdf"]
    with tempfile.TemporaryDirectory() as folder:
        package = packed(files, Path(folder))
        check_manifest(package)
        for prefix in ("", "arm_"):
            expanded = package.expanded(prefix=prefix)
            same_text(package.plain, expanded, prefix)
            same_robot(urdf, expanded, prefix)
        controllers = package.controllers()
        if controllers:
            check_control(package, package.expanded(), controllers)
            values = home_of(package.expanded())
            at_home = home(robot)
            for name, value in values.items():
                if name in at_home:
                    assert abs(value - at_home[name]) < 1e-9, name


@pytest.mark.parametrize(("loops", "count"), [(True, 3), pytest.param(None, 15, marks=pytest.mark.slow)])
def test_the_package_is_the_document(loops, count):
    each(agree, count, any_document(loops=loops), st.integers(0, 5))
