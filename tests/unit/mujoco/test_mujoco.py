"""MuJoCo's models: compiled or refused, their included files, and their states at keyframes."""

import mujoco
import numpy as np
import pytest

from linkwright.stages.formats.mjcf.controls import control_count
from linkwright.stages.formats.variants import Variants
from linkwright.stages.formats.xml import parse, to_bytes
from linkwright.stages.mujoco.compile import NotCompiled, compiled_file, compiled_text
from linkwright.stages.mujoco.fields import general_attributes
from linkwright.stages.mujoco.includes import replace_includes
from linkwright.stages.mujoco.names import OBJ, actuator_count, controls_of, count_of
from linkwright.stages.mujoco.state import at_keyframe, keyframe_index
from linkwright.stages.mujoco.variants import misfit, names_in, places
from linkwright.stages.validate.simulate.noise import control_ranges

WRONG = b'<mujoco><worldbody><geom type="mesh" mesh="lost"/></worldbody></mujoco>'
FLOATING = """<robot name="r"><link name="base"/><link name="box"><inertial><mass value="1"/>
<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="loose" type="floating"><origin xyz="0 0 0.5"/><parent link="base"/><child link="box"/></joint>
</robot>"""


TWO_CONTROLS = """<mujoco><worldbody><body><joint name="j"/><geom size="1"/>
<body pos="3 0 0"><joint name="k"/><geom size="1"/></body></body></worldbody>
<actuator><pid name="p" joint="j" kp="1"/>
<position name="q" joint="k" kp="7" ctrlrange="-0.7 0.7"/></actuator></mujoco>"""
NEEDS_PID = pytest.mark.skipif(
    not hasattr(mujoco.MjModel, "nactuator"), reason="in this MuJoCo an actuator has a single control"
)


@NEEDS_PID
def test_actuator_after_one_of_several_controls_has_its_range():
    model = mujoco.MjModel.from_xml_string(TWO_CONTROLS)
    assert (model.nu, actuator_count(model), count_of(model, OBJ.mjOBJ_ACTUATOR)) == (3, 2, 2)
    assert [controls_of(model, index) for index in range(2)] == [range(2), range(2, 3)]
    assert dict(general_attributes(model, 1))["ctrlrange"] == "-0.7 0.7"
    assert "ctrlrange" not in dict(general_attributes(model, 0))
    assert control_ranges(model).tolist() == [[-1, 1], [-1, 1], [-0.7, 0.7]]


@NEEDS_PID
@pytest.mark.parametrize(
    ("tag", "inputs", "count"),
    [("pid", None, 2), ("pid", "pos", 1), ("pid", "pos vel ff", 3), ("motor", None, 1),
     ("orientation", None, 3), ("orientation", "expmap", 3), ("orientation", "quat", 4),
     ("dcmotor", None, 1), ("dcmotor", "none", 0), ("dcmotor", "pos voltage", 2)],
)  # fmt: skip
def test_controls_are_counted_as_mujoco_does(tag, inputs, count):
    if not hasattr(mujoco.mjtTrn, "mjTRN_SO3") and tag == "orientation":
        pytest.skip("this MuJoCo has no orientation servo")
    own = {"pid": 'kp="1"', "orientation": 'kp="1"', "dcmotor": 'motorconst=".1" resistance="2"'}.get(tag, "")
    text = f'<{tag} joint="{"b" if tag == "orientation" else "j"}" {own}'
    text += f' input="{inputs}"/>' if inputs else "/>"
    joints = [
        f'<body><joint {joint}/><geom size="1"/></body>' for joint in ('name="j"', 'name="b" type="ball"')
    ]
    file = f"<mujoco><worldbody>{''.join(joints)}</worldbody><actuator>{text}</actuator></mujoco>"
    assert mujoco.MjModel.from_xml_string(file).nu == count == control_count(tag, inputs)


def test_model_that_mujoco_refuses_is_an_error_with_its_reason():
    with pytest.raises(NotCompiled, match="lost"):
        compiled_text(WRONG, {})


def test_reason_does_not_name_the_folder(tmp_path):
    path = tmp_path / "robot.xml"
    path.write_text('<mujoco><asset><mesh file="lost.stl"/></asset></mujoco>')
    with pytest.raises(NotCompiled) as caught:
        compiled_file(path)
    assert "lost.stl" in str(caught.value)
    assert str(tmp_path) not in str(caught.value)


def test_floating_joint_of_a_urdf_floats(tmp_path):
    """MuJoCo itself refuses one below another link than the world."""
    path = tmp_path / "robot.urdf"
    path.write_text(FLOATING)
    model = compiled_file(path)
    assert (model.njnt, model.nv) == (1, 6)
    assert model.qpos0[:3].tolist() == [0, 0, 0.5]


FILES = {
    "scene.xml": '<mujoco><worldbody><body name="a"><geom size="1"/></body></worldbody>'
    '<include file="parts/b.xml"/><include file="e.xml"/>'
    '<worldbody><body name="f"><geom size="1"/></body></worldbody></mujoco>',
    "parts/b.xml": '<mujoco><worldbody><body name="b"><geom size="1"/><include file="parts/c.xml"/></body>'
    '<body name="d"><geom size="1"/></body></worldbody></mujoco>',
    "parts/c.xml": '<mujoco><body name="c"><geom size="1"/></body></mujoco>',
    "e.xml": '<mujoco><worldbody><body name="e"><geom size="1"/></body></worldbody></mujoco>',
}
"""Paths count from the folder of the first file."""


def bodies(model):
    return [model.body(index).name for index in range(1, model.nbody)]


def test_document_without_includes_is_what_mujoco_reads(tmp_path):
    for name, text in FILES.items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(text)
    root = parse(FILES["scene.xml"].encode())
    replace_includes(root, lambda include: parse(FILES[include.get("file")].encode()))
    names = bodies(compiled_text(to_bytes(root), {}))
    assert names == bodies(compiled_file(tmp_path / "scene.xml")) == list("abcdef")


def test_file_that_is_not_read_includes_nothing():
    root = parse(FILES["scene.xml"].encode())
    replace_includes(root, lambda _: None)
    assert list(root.iter("include")) == []
    assert bodies(compiled_text(to_bytes(root), {})) == ["a", "f"]


TEXT = b"""<mujoco><worldbody><body><joint name="j"/><geom size="1"/></body></worldbody>
<actuator><position joint="j"/></actuator>
<keyframe><key name="up" qpos="1"/><key name="home" qpos="0.5" ctrl="0.25"/></keyframe></mujoco>"""


def test_state_is_that_of_the_keyframe_and_else_qpos0():
    model = compiled_text(TEXT, {})
    assert [keyframe_index(model, name) for name in ("up", "home", "lost")] == [0, 1, -1]
    assert [at_keyframe(model, name).qpos[0] for name in ("up", "home", "lost")] == [1, 0.5, 0]
    assert at_keyframe(model).ctrl[0] == 0.25


@pytest.mark.parametrize(("field", "values", "expected"), [
    ("body_mass", np.ones((3, 2)), ""),
    ("body_mass", np.ones((0, 2)), ""),
    ("body_mass", np.ones((3, 9)), "body_mass"),
    ("body_mass", np.ones(3), "body_mass"),
    ("geom_friction", np.ones((3, 1, 3)), ""),
    ("geom_friction", np.ones(3), "geom_friction"),
    ("nbody", np.ones((3, 2)), "nbody"),
    ("lost", np.ones((3, 2)), "lost"),
])  # fmt: skip
def test_variants_fit_if_each_array_has_the_shape_of_its_field(field, values, expected):
    model = mujoco.MjModel.from_xml_string(
        '<mujoco><worldbody><body><joint/><geom size="1"/></body></worldbody></mujoco>'
    )
    variants = Variants(0, "", names_in(model), model.geom_bodyid.copy(), places(model), {field: values})
    assert misfit(model, variants) == expected
