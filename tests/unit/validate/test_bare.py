"""Checks of a bare URDF or MJCF: each fault is found with its element and attribute, and no other."""

import pytest

from linkwright.stages.validate.bare.run import check_bare
from linkwright.stages.validate.files.run import check_folder
from tests.support.faults import BARE
from tests.support.faults.arm import problems, replace_last, write_arm
from tests.support.other_robots import FILES, is_here


@pytest.fixture
def folder(tmp_path):
    return write_arm(tmp_path)


def test_good_files_pass(folder):
    assert [check for check in check_bare(folder) if not check.passed] == []
    assert {problem.code for problem in check_bare(folder)} >= {
        *("C-TREE", "C-MIMIC", "C-DIRECTION", "C-LIMIT", "C-SOLID", "C-UNITS", "C-KEYS", "C-PLAUSIBLE"),
        *("C-XML", "C-NAME", "C-REFERENCE", "C-NUMBER", "C-ASSET", "C-COMPILE", "C-START", "C-CLOSED"),
        *("C-TRIAL", "C-TOGETHER"),
    }


@pytest.mark.parametrize("fault", BARE, ids=lambda fault: fault.title)
def test_a_fault_of_a_bare_file_is_found(folder, fault):
    planted = fault.change(folder, "arm")
    together = fault.codes == ("C-TOGETHER",)
    checks = check_bare(folder if together else folder / f"arm.{'urdf' if 'urdf' in fault.file else 'xml'}")
    (expected,) = [(*fault.codes, *planted.elements, *planted.attributes)]
    assert expected in problems(checks)
    assert all(finding.message for check in checks for finding in check.findings)


def test_what_becomes_infinite_is_found(folder):
    """A servo whose gains the time step cannot follow."""
    replace_last(folder / "arm.xml", 'kp="20"', 'kp="1e7"')
    replace_last(folder / "arm.xml", "<asset>", '<option timestep="0.02"/><asset>')
    replace_last(folder / "arm.xml", 'qpos="0.1 0.1', 'qpos="0.4 0.4')
    assert "C-TRIAL" in {check.code for check in check_bare(folder / "arm.xml") if check.fails}


def test_other_files_beside_models_are_left_alone(folder):
    (folder / "config.xml").write_text("<settings/>")
    (folder / "notes.txt").write_text("<")
    assert all(check.passed for check in check_bare(folder))


@pytest.mark.parametrize("name", FILES)
def test_the_files_of_others_have_no_error(name):
    """What they have that could be better is a warning."""
    if not is_here(name):
        pytest.skip("needs the robots of others")
    path = FILES[name][1]
    assert [check for check in check_bare(path) if check.fails] == []
    assert [check for check in check_folder(path.parent, [path.name]) if check.fails] == []


INERTIA = '<inertia ixx="{i}" iyy="{i}" izz="{i}" ixy="0" ixz="0" iyz="0"/>'
SOLID = f'<inertial><mass value="{{}}"/>{INERTIA}</inertial>'
FIXED = '<joint name="{0}" type="fixed"><parent link="lower"/><child link="{0}"/></joint></robot>'
BOX = '<visual><geometry><box size=".001 .001 .001"/></geometry></visual>'
TOOL = f'<link name="tool">{SOLID.format("1e-9", i="0")}</link>{FIXED.format("tool")}'
LIMITS = 'lower="-1.5" upper="1.5"'


def marked(mass, moment="1e-4"):
    """A box that marks a sensor, and is not its form."""
    return f'<link name="imu">{SOLID.format(mass, i=moment)}{BOX}</link>{FIXED.format("imu")}'


HARMLESS = {
    "a quaternion of another length": ("arm.xml", 'quat="1 0 0 0"', 'quat="2 0 0 0"'),
    "a static base without mass": (
        "arm.xml",
        'mass="1" diaginertia="0.004 0.004 0.0009"/>\n      <geom class="visual" mesh="base"',
        'mass="0" diaginertia="0 0 0"/>\n      <geom class="visual" mesh="base"',
    ),
    "room for contacts, of gigabytes": (
        "arm.xml", "<asset>", '<size njmax="8000" nconmax="4000"/><asset>'),
    "limits that mean no limit": ("arm.urdf", LIMITS, 'lower="-10" upper="10"'),
    "huge limits": ("arm.urdf", LIMITS, 'lower="-1e16" upper="1e16"'),
    "a frame without a body": ("arm.urdf", "</robot>", TOOL),
    **{f"a marker of {mass} kg": ("arm.urdf", "</robot>", marked(mass)) for mass in ("0.001", "0.5", "0")},
}  # fmt: skip


@pytest.mark.parametrize("kind", HARMLESS)
def test_what_many_files_have_is_no_fault(folder, kind):
    file, old, new = HARMLESS[kind]
    replace_last(folder / file, old, new)
    assert [(check.code, check.detail) for check in check_bare(folder / file) if not check.passed] == []


def test_a_fixed_link_may_be_a_point_and_may_not_have_a_negative_mass(folder):
    replace_last(folder / "arm.urdf", "</robot>", marked("0.5", moment="0"))
    assert [check for check in check_bare(folder / "arm.urdf") if check.fails] == []
    replace_last(folder / "arm.urdf", 'value="0.5"', 'value="-0.5"')
    assert "C-SOLID" in {check.code for check in check_bare(folder / "arm.urdf") if check.fails}


def test_a_mesh_that_cannot_be_read_may_explain_what_is_odd(folder):
    text = (folder / "arm.urdf").read_text()
    wide = text.replace('ixx="0.004"', 'ixx="0.04"').replace('iyy="0.004"', 'iyy="0.04"')
    assert wide != text
    (folder / "arm.urdf").write_text(wide)
    assert "C-INERTIAL" in {check.code for check in check_bare(folder / "arm.urdf") if not check.passed}
    (folder / "other.dae").write_text("<COLLADA/>")
    seen = '<visual><geometry><mesh filename="other.dae"/></geometry></visual></link>'
    (folder / "arm.urdf").write_text(wide.replace("</link>", seen))
    assert "C-INERTIAL" not in {check.code for check in check_bare(folder / "arm.urdf") if not check.passed}
