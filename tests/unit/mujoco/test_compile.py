"""Compiled models, and why there are none."""

from pathlib import Path

import pytest

from linkwright.stages.mujoco.compile import NotCompiled, compiled_file, compiled_text

WRONG = b'<mujoco><worldbody><geom type="mesh" mesh="lost"/></worldbody></mujoco>'
FLOATING = """<robot name="r"><link name="base"/><link name="box"><inertial><mass value="1"/>
<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="loose" type="floating"><origin xyz="0 0 0.5"/><parent link="base"/><child link="box"/></joint>
</robot>"""


def test_what_mujoco_refuses_is_one_error_with_its_reason() -> None:
    with pytest.raises(NotCompiled, match="lost"):
        compiled_text(WRONG, {})


def test_the_reason_does_not_name_the_folder(tmp_path: Path) -> None:
    path = tmp_path / "robot.xml"
    path.write_text('<mujoco><asset><mesh file="lost.stl"/></asset></mujoco>')
    with pytest.raises(NotCompiled) as caught:
        compiled_file(path)
    assert "lost.stl" in str(caught.value)
    assert str(tmp_path) not in str(caught.value)


def test_a_floating_joint_of_a_urdf_floats(tmp_path: Path) -> None:
    """MuJoCo itself refuses one below another link than the world."""
    path = tmp_path / "robot.urdf"
    path.write_text(FLOATING)
    model = compiled_file(path)
    assert (model.njnt, model.nv) == (1, 6)
    assert model.qpos0[:3].tolist() == [0, 0, 0.5]
