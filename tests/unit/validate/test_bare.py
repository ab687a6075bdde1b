"""Checks of a URDF or MJCF that comes alone: each fault is found in its place, public habits pass."""

import mujoco
import pytest

from linkwright.stages.mesh import make_geometry
from linkwright.stages.mujoco.trial import Trial
from linkwright.stages.validate.bare import start
from linkwright.stages.validate.bare.mjcf_figures import figures
from linkwright.stages.validate.bare.run import check_bare
from linkwright.stages.validate.dynamics.mujoco_features import reads_mimic
from linkwright.stages.validate.files.run import check_folder
from tests.support.building import plan_of, write
from tests.support.checked import checked
from tests.support.faults import BARE
from tests.support.faults.arm import URDF, box_stl, problems, replace_last, write_arm
from tests.support.other_robots import FILES, is_here
from tests.support.urdfs import urdf_bundle, urdf_robot


@pytest.fixture
def folder(tmp_path):
    """A robot's folder, with its meshes in `assets` beside it too."""
    for place in (tmp_path / "robot", tmp_path / "assets"):
        place.mkdir()
        write_arm(place)
    return tmp_path / "robot"


def failing(path):
    """Code, level and words of what does not pass."""
    return [(check.code, check.level, check.detail) for check in check_bare(path) if not check.passed]


def levels(checks):
    return {(check.code, check.level) for check in checks if not check.passed}


ASCII_STL = b"""solid a
facet normal 0 0 1
outer loop
vertex 0 0 0
vertex 1 0 0
vertex 0 1 0
endloop
endfacet
endsolid a
"""


def test_meshes_may_lie_beside_the_folder_of_the_model(folder):
    urdf = folder / "arm.urdf"
    urdf.write_text(urdf.read_text().replace('filename="', 'filename="../assets/'))
    mjcf = folder / "arm.xml"
    mjcf.write_text(mjcf.read_text().replace('angle="radian"', 'angle="radian" meshdir="../assets"'))
    assert failing(urdf) == failing(mjcf) == []
    replace_last(urdf, "../assets/lower.stl", "/srv/lower.stl")
    assert ("C-PATH", "warning") in levels(check_bare(urdf))


UNREAD = {"an ASCII STL": ASCII_STL, "too many triangles": bytes(80) + (200_001).to_bytes(4, "little")}


@pytest.mark.parametrize("kind", UNREAD)
def test_mesh_that_mujoco_does_not_read_is_no_fault_of_a_urdf(folder, kind):
    data = UNREAD[kind] + (bytes(50 * 200_001) if kind == "too many triangles" else b"")
    (folder / "lower.stl").write_bytes(data)
    urdf = folder / "arm.urdf"
    box = '<collision><origin xyz="0 0 0.1"/><geometry><box size="0.07 0.07 0.2"/>'
    replace_last(urdf, box, '<collision><geometry><mesh filename="lower.stl"/>')
    assert "C-COMPILE" not in {code for code, _, _ in failing(urdf)}


def test_what_is_only_seen_of_a_urdf_may_be_flat(folder):
    (folder / "sticker.stl").write_bytes(box_stl(0.03, 0.03, 0.0))
    seen = '<visual><geometry><mesh filename="sticker.stl"/></geometry></visual></link>'
    replace_last(folder / "arm.urdf", "</link>", seen)
    assert failing(folder / "arm.urdf") == []


@pytest.mark.skipif(not reads_mimic(), reason="this MuJoCo reads no <mimic>")
def test_urdf_is_tried_from_within_its_limits(folder, monkeypatch):
    """It does not say where it starts, and far outside of them the limits throw it away."""
    starts = []
    monkeypatch.setattr(start, "trial_run", lambda *arguments: starts.append(arguments[-1]) or Trial("", 1.0))
    urdf = folder / "arm.urdf"
    urdf.write_text(urdf.read_text().replace('lower="-1.5"', 'lower="0.3"'))
    replace_last(urdf, 'multiplier="1"', 'multiplier="-2" offset="0.1"')
    check_bare(urdf)
    assert [list(start) for start in starts] == [[0.3, pytest.approx(-0.5)]]


def test_fixed_joint_that_follows_another_is_only_odd(folder):
    hand = '<link name="hand"/><joint name="hand" type="fixed"><parent link="lower"/><child link="hand"/>'
    replace_last(folder / "arm.urdf", "</robot>", f'{hand}<mimic joint="shoulder"/></joint></robot>')
    checks = check_bare(folder / "arm.urdf")
    assert ("C-PLAUSIBLE", 'mimic of joint "hand"', "joint") in problems(checks)
    assert levels(checks) == {("C-PLAUSIBLE", "warning")}


BORNE = {
    "a colour": ("</visual>", '<material name="grey"/></visual>', 'material "grey"'),
    "a transmission": ("</robot>", '<transmission name="t"><joint name="hip"/></transmission></robot>', ""),
}


@pytest.mark.parametrize("kind", BORNE)
def test_names_that_readers_of_a_urdf_leave_out_are_a_warning(folder, kind):
    old, new, _ = BORNE[kind]
    replace_last(folder / "arm.urdf", old, new)
    assert levels(check_bare(folder / "arm.urdf")) == {("C-REFERENCE", "warning")}
    replace_last(folder / "arm.urdf", 'parent link="upper"', 'parent link="uper"')
    assert ("C-REFERENCE", "error") in levels(check_bare(folder / "arm.urdf"))


SENSOR = """<link name="imu"><inertial><mass value="0.002"/>
<inertia ixx="1e-5" iyy="1e-5" izz="1e-5" ixy="0" ixz="0" iyz="0"/></inertial>
<visual><geometry><box size=".03 .03 .01"/></geometry></visual></link>
<joint name="imu" type="fixed"><parent link="lower"/><child link="imu"/></joint></robot>"""


def test_body_is_judged_with_what_is_fixed_to_it(folder):
    """A radius of gyration of 70 mm, of a sensor that reaches 20 mm, on a link of 200 mm."""
    replace_last(folder / "arm.urdf", "</robot>", SENSOR)
    assert failing(folder / "arm.urdf") == []
    replace_last(folder / "arm.urdf", 'name="imu" type="fixed"', 'name="imu" type="continuous"')
    assert ("C-INERTIAL", 'inertia of link "imu"', "ixx") in problems(check_bare(folder / "arm.urdf"))


WORLD = """<link name="world"/><link name="tool"/>
<joint name="world" type="fixed"><parent link="world"/><child link="base"/></joint>
<joint name="tool" type="{kind}"><parent link="base"/><child link="tool"/></joint></robot>"""


@pytest.mark.parametrize(("kind", "expected"), [("fixed", set()), ("continuous", {("C-SOLID", "error")})])
def test_frame_on_a_base_that_the_file_fixes_needs_no_mass(folder, kind, expected):
    replace_last(folder / "arm.urdf", "</robot>", WORLD.format(kind=kind))
    assert {level for level in levels(check_bare(folder / "arm.urdf")) if level[0] == "C-SOLID"} == expected


def test_what_cannot_move_may_have_any_inertial(folder):
    shelf = '<body name="shelf"><inertial pos="0 0 0" mass="1" diaginertia="{i} {i} {i}"/>'
    shelf += '<geom type="box" size=".1 .1 .1" contype="0" conaffinity="0"/></body><body name="ball"'
    replace_last(folder / "arm.xml", '<body name="ball"', shelf.format(i=0.1))
    assert failing(folder / "arm.xml") == []
    replace_last(folder / "arm.xml", '"0.1 0.1 0.1"/><geom', '"100 100 100"/><geom')
    assert levels(check_bare(folder / "arm.xml")) == {("C-INERTIAL", "warning")}
    replace_last(folder / "arm.xml", 'diaginertia="0.004 0.004 0.0009"', 'diaginertia="4 4 0.9"')
    assert ("C-INERTIAL", "error") in levels(check_bare(folder / "arm.xml"))


@pytest.mark.parametrize(("factor", "unit"), [(100, ""), (1000, "g m²"), (1_000_000, "kg mm²")])
def test_unit_is_named_only_where_it_fits(folder, factor, unit):
    moments = " ".join(str(factor * moment) for moment in (0.004, 0.004, 0.0009))
    replace_last(folder / "arm.xml", 'diaginertia="0.004 0.004 0.0009"', f'diaginertia="{moments}"')
    (words,) = [words for code, _, words in failing(folder / "arm.xml") if code == "C-INERTIAL"]
    assert (f"{unit} read as" in words) if unit else ("read as" not in words)


@pytest.mark.parametrize(("group", "passes"), [(5, True), (2, False)])
def test_what_a_viewer_hides_is_not_the_form_of_a_body(folder, group, passes):
    """A box for a camera that looks from above, far from the body's one collider."""
    camera = (
        f'<geom type="box" size=".5 .5 .1" pos="0 0 2" mass="0" group="{group}" contype="0" conaffinity="0"/>'
    )
    replace_last(folder / "arm.xml", '<freejoint name="ball"/>', f'<freejoint name="ball"/>{camera}')
    assert ("C-COLLIDER" not in {code for code, _, _ in failing(folder / "arm.xml")}) is passes


@pytest.mark.parametrize(("group", "expected"), [(2, set()), (0, {("C-COLLIDER", "error")})])
def test_geom_of_the_group_of_visuals_is_no_collider_of_them(folder, group, expected):
    """A collider 0.5 m beside the mesh of its body: of another group it stands for that, and is misplaced."""
    moved = f'<geom name="upper" class="collision" group="{group}" pos="0 .5 0.1"/>'
    replace_last(folder / "arm.xml", '<geom name="upper" class="collision" pos="0 0 0.1"/>', moved)
    assert levels(check_bare(folder / "arm.xml")) == expected


def test_plane_is_no_shape_of_a_body():
    plane = '<geom type="plane" size="1 1 1"/>'
    model = mujoco.MjModel.from_xml_string(
        f'<mujoco><worldbody><body>{plane}<geom size=".1"/></body></worldbody></mujoco>'
    )
    (body,) = figures(model)
    assert [shape.extent for shape in body.shapes] == [pytest.approx(0.2 * 3**0.5)]


@pytest.mark.parametrize(
    ("between", "relation"),
    [("", "its parent"), ('<body name="mount" pos="0 0 0.1">', "to which its parent is fixed")],
)
def test_what_a_body_moves_on_is_named_as_such_where_it_is_fixed(folder, between, relation):
    """MuJoCo lets a body collide with its parent, and what that is fixed to, where that is the world."""
    height = 0.05 if between else 0.15
    upper = f'{between}<body name="upper" pos="0 0 {height}"'
    replace_last(folder / "arm.xml", '<body name="upper" pos="0 0 0.25"', upper)
    if between:
        replace_last(folder / "arm.xml", '    <body name="ball"', '    </body><body name="ball"')
    (deep,) = [check for check in check_bare(folder / "arm.xml") if check.code == "C-START"]
    assert deep.findings[0].element == 'body "upper"'
    assert f'inside "base" at the start, {relation}: that body is fixed' in deep.findings[0].message


BOXES = URDF.replace('<mesh filename="base.stl"/>', '<box size="0.07 0.07 0.2"/>')
for _name in ("upper", "lower"):
    BOXES = BOXES.replace(f'<mesh filename="{_name}.stl"/>', '<box size="0.07 0.07 0.2"/>')
BOXES = BOXES.replace('ixx="0.004" ixy="0" ixz="0" iyy="0.004"', 'ixx="@x" ixy="0" ixz="0" iyy="@x"')

INERTIALS = [
    ({}, set()),
    ({"mass": "1000"}, {"error"}),
    ({"mass": "20"}, {"warning"}),
    ({"moment": "4000"}, {"error"}),
    ({"moment": "0.02"}, {"warning"}),
    ({"com": "0 0 0.35"}, {"warning"}),
    ({"com": "0 0 100"}, {"error"}),
]


@pytest.mark.parametrize(("change", "expected"), INERTIALS)
def test_build_judges_inertials_as_a_check_does(change, expected, tmp_path):
    before, middle, after = BOXES.rpartition('<link name="lower">')
    after = after.replace('mass value="1"', f'mass value="{change.get("mass", "1")}"')
    after = after.replace("@x", change.get("moment", "0.004"))
    after = after.replace('origin xyz="0 0 0.1"', f'origin xyz="{change.get("com", "0 0 0.1")}"', 1)
    text = before.replace("@x", "0.004") + middle + after
    (tmp_path / "arm.urdf").write_text(text)
    checks = check_bare(tmp_path / "arm.urdf")
    robot, plan = urdf_robot(text), plan_of()
    geometry = make_geometry(robot, urdf_bundle(text.encode()), plan, lambda kind, key, make: make())
    write(robot, tmp_path / "out", plan, geometry)
    built = checked(tmp_path / "out", robot, plan)
    for results in (checks, built):
        judged = [check for check in results if check.code == "C-INERTIAL" and not check.passed]
        worst = {check.level for check in judged}
        assert (worst & {"error"} or worst) == expected
        assert all("lower" in finding.element for check in judged for finding in check.findings)


def test_good_files_pass(folder):
    assert [check for check in check_bare(folder) if not check.passed] == []
    assert {problem.code for problem in check_bare(folder)} >= {
        *("C-TREE", "C-MIMIC", "C-DIRECTION", "C-LIMIT", "C-SOLID", "C-UNITS", "C-KEYS", "C-PLAUSIBLE"),
        *("C-XML", "C-NAME", "C-REFERENCE", "C-NUMBER", "C-ASSET", "C-COMPILE", "C-START", "C-CLOSED"),
        *("C-TRIAL", "C-TOGETHER"),
    }


@pytest.mark.parametrize("fault", BARE, ids=lambda fault: fault.title)
def test_fault_of_a_bare_file_is_found(folder, fault):
    planted = fault.change(folder, "arm")
    together = fault.codes == ("C-TOGETHER",)
    checks = check_bare(folder if together else folder / f"arm.{'urdf' if 'urdf' in fault.file else 'xml'}")
    (expected,) = [(*fault.codes, *planted.elements, *planted.attributes)]
    assert expected in problems(checks)
    assert all(finding.message for check in checks for finding in check.findings)


def test_what_becomes_infinite_is_found(folder):
    replace_last(folder / "arm.xml", 'kp="20"', 'kp="1e7"')
    replace_last(folder / "arm.xml", "<asset>", '<option timestep="0.02"/><asset>')
    replace_last(folder / "arm.xml", 'qpos="0.1 0.1', 'qpos="0.4 0.4')
    assert "C-TRIAL" in {check.code for check in check_bare(folder / "arm.xml") if check.fails}


def test_other_files_beside_models_are_left_alone(folder):
    (folder / "config.xml").write_text("<settings/>")
    (folder / "notes.txt").write_text("<")
    assert all(check.passed for check in check_bare(folder))


@pytest.mark.parametrize("name", FILES)
def test_files_of_others_have_no_error(name):
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
DRIVE = '<actuator><position name="shoulder" joint="shoulder" kp="20"'


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
    "a range that another shorthand's defaults give": (
        "arm.xml", f"{DRIVE} ctrlrange=\"-1.5 1.5\"/></actuator>",
        f'{DRIVE}/></actuator><default><motor ctrlrange="-1.5 1.5"/></default>'),
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


def test_fixed_link_may_be_a_point_but_has_no_negative_mass(folder):
    replace_last(folder / "arm.urdf", "</robot>", marked("0.5", moment="0"))
    assert [check for check in check_bare(folder / "arm.urdf") if check.fails] == []
    replace_last(folder / "arm.urdf", 'value="0.5"', 'value="-0.5"')
    assert "C-SOLID" in {check.code for check in check_bare(folder / "arm.urdf") if check.fails}


def test_mesh_that_cannot_be_read_may_explain_what_is_odd(folder):
    text = (folder / "arm.urdf").read_text()
    wide = text.replace('ixx="0.004"', 'ixx="0.04"').replace('iyy="0.004"', 'iyy="0.04"')
    assert wide != text
    (folder / "arm.urdf").write_text(wide)
    assert "C-INERTIAL" in {check.code for check in check_bare(folder / "arm.urdf") if not check.passed}
    (folder / "other.dae").write_text("<COLLADA/>")
    seen = '<visual><geometry><mesh filename="other.dae"/></geometry></visual></link>'
    (folder / "arm.urdf").write_text(wide.replace("</link>", seen))
    assert "C-INERTIAL" not in {check.code for check in check_bare(folder / "arm.urdf") if not check.passed}
