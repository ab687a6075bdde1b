"""Files of packages are compared by what they say: not by bytes, and never by running them."""

import pytest

from linkwright.stages.robot.model.amendments import Amendment
from linkwright.stages.validate.rewritten.amended import is_amended
from linkwright.stages.validate.rewritten.check import rewritten
from linkwright.stages.validate.rewritten.compare import differences

SAME = {
    "a.xml": (
        '<robot name="r"><link name="a"><mass value="0.1"/></link></robot>',
        '<robot  name = "r" >\n<!-- looked at -->\n<link name="a">\n<mass value="1e-1"/></link>\n</robot>',
    ),
    "colours.urdf": (
        '<robot><visual material="red"/><material name="red"><color rgba="1 0 0 1"/></material></robot>',
        '<robot><visual material="r"/><material name="r"><color rgba="1.0 0 0 1"/></material></robot>',
    ),
    "turned.urdf": (
        '<robot><joint name="j"><origin rpy="0.3 1.5707963267948966 0.1"/></joint></robot>',
        '<robot><joint name="j"><origin rpy="0.2 1.5707963267948966 0"/></joint></robot>',
    ),
    "rounded.launch.py": ('HOME = {"a": -0.000700734229}\n', 'HOME = {"a": -0.00070073423}\n'),
    "rounded.xacro": (
        '<robot><joint name="j"><param name="initial_value">0.000700734229</param></joint></robot>',
        '<robot><joint name="j"><param name="initial_value">0.00070073423</param></joint></robot>',
    ),
    "a.yaml": ('a: {joints: ["x", "y"], rate: 100}\n', "a:\n  rate: 100  # Hz\n  joints:\n  - x\n  - 'y'\n"),
    "a.toml": ('[project]\nname = "x"\n', "# ours\n[project]\nname='x'\n"),
    "a.json": ('{"mass": 1.0, "names": ["a"]}', '{\n"names": ["a"], "mass": 1}'),
    "a.py": ('"""Doc."""\nA = "x"\nB = 1.0\n', "B = 1.00\nA = 'x'  # the name\n"),
    "a.launch.py": ("def f(a):\n    return g(a)\n", 'def f(a):\n    """Doc."""\n    return g( a )\n'),
    "CMakeLists.txt": ("install(\n  DIRECTORY a b\n)\n", "INSTALL(DIRECTORY b a) # all\n"),
    "a.obj": ("v 0 0.5 1\nf 1 2 3\n", "# shape\nv 0 5e-1 1.0\nf 1 2 3\n"),
}

OTHER = {
    "a.xml": ('<a><b x="1"/></a>', '<a><b x="2"/></a>', "x"),
    "whole.yaml": ("rate: 100.0\n", "rate: 100\n", ""),
    "infinite.yaml": ("limit: .inf\n", "limit: 5.0\n", ""),
    "row.yaml": ("joints: [a, b]\n", "joints: [b, a]\n", ""),
    "a.toml": ('[a]\nx = "1"\n', "[a]\nx = 1\n", "x"),
    "a.json": ('{"x": [1, 2]}', '{"x": [1, 2, 3]}', ""),
    "a.py": ('A = "x"\n', "A = x\n", ""),
    "code.py": ("def f(a):\n    return a\n", "def f(a):\n    return 2 * a\n", "statement 1"),
    "CMakeLists.txt": ("project(a)\n", "project(b)\n", ""),
    "a.mtl": ("Kd 1 0 0\n", "Kd 0 0 1\n", ""),
    "a.stl": ("solid a", "solid b", ""),
    "empty.yaml": ("a: 1\n", "", ""),
    "scalar.yaml": ("a: 1\n", "hello\n", ""),
    "set.py": ("A = 1\n", "A = {[1], 2}\n", ""),
    "base.py": ("class A(B):\n    x = 1\n", "class A(C):\n    x = 1\n", "bases"),
    "decorated.py": ("def f():\n    pass\n", "@g\ndef f():\n    pass\n", "decorators"),
    "broken.yaml": ("a: 1\n", "a: [1\n", ""),
    "tag.yaml": ("a: 1\n", "a: !!python/object/apply:os.system [true]\n", ""),
    "broken.py": ("A = 1\n", "A = = 1\n", ""),
}


@pytest.mark.parametrize("name", SAME)
def test_what_means_the_same_is_no_difference(name):
    first, second = (text.encode() for text in SAME[name])
    assert list(differences(name, second, first)) == []
    assert list(differences(name, first, second)) == []


@pytest.mark.parametrize("name", OTHER)
def test_what_means_something_else_is_a_difference(name):
    expected, data, attribute = OTHER[name]
    (difference, *_) = differences(name, data.encode(), expected.encode())
    assert attribute in difference.finding.attribute
    assert list(differences(name, expected.encode(), data.encode())) or "tag" in name or "broken" in name


def test_long_row_says_only_where_it_differs():
    names = [f"joint_{number}" for number in range(30)]
    expected = f"joints: [{', '.join(names)}]\n".encode()
    (difference,) = differences("a.yaml", expected.replace(b"joint_29", b"joint_30"), expected)
    assert difference.finding.message == 'has "joint_30" and lacks "joint_29"'


def test_element_that_is_missing_has_no_attribute():
    text = b'<robot><link name="a"/></robot>'
    (difference,) = differences("a.urdf", b"<robot/>", text)
    assert (difference.finding.element, difference.finding.attribute) == ('link "a"', "")
    (difference,) = differences("a.urdf", text.replace(b"/>", b"><visual/></link>", 1), text)
    assert (difference.finding.element, difference.finding.attribute) == ('link "a"', "visual")


def test_copies_in_a_folder_share_a_check_beside_a_subfolder(tmp_path):
    expected = dict.fromkeys(("m/a.stl", "m/b/c.stl", "m/d.stl"), b"solid")
    names = [check.name for check in rewritten(tmp_path, expected, copies=True, current=True)]
    assert names == ["m: copies", "m/b: copies"]


def test_view_of_rviz_that_cannot_be_read_is_a_fault(tmp_path):
    (tmp_path / "a.rviz").write_text("[" * 100_000)
    (check,) = rewritten(tmp_path, {"a.rviz": b"a: 1"}, copies=False, current=True)
    assert check.fails


OWN = {
    "package.xml": ("<package><name>a</name><version>0.0.0</version></package>", "0.0.0", "1.2.0", ""),
    "renamed/package.xml": ("<package><name>a</name></package>", ">a<", ">b<", "error"),
    "controllers.yaml": (
        "controller_manager: {ros__parameters: {update_rate: 100}}",
        "100",
        "500",
        "warning",
    ),
    "more/controllers.yaml": ("a: {joints: [x]}\n", "a:", "b: 1\na:", "warning"),
    "more.urdf": ('<robot name="r"></robot>', "></", "><link name='b'/></", "error"),
}
"""By file: what a build writes, a change of it, and what that is."""


@pytest.mark.parametrize("path", OWN)
def test_what_is_for_the_user_to_set_is_no_fault(path, tmp_path):
    text, old, new, level = OWN[path]
    file = tmp_path / path
    file.parent.mkdir(exist_ok=True)
    file.write_text(text.replace(old, new))
    (check,) = rewritten(tmp_path, {path: text.encode()}, copies=False, current=True)
    assert (check.passed, "" if check.passed else check.level) == (not level, level)
    (check,) = rewritten(tmp_path, {path: text.encode()}, copies=True, current=True)
    assert check.fails
    (check,) = rewritten(tmp_path, {path: text.encode()}, copies=False, current=False)
    assert not check.fails


LINK = '<robot name="r"><link name="${prefix}a"/>%s</robot>'
CHANGES = (
    Amendment("elements.lamp", "r.urdf", "link a", ("<visual>",)),
    Amendment("elements.flag", "r.urdf", "robot r", ("link flag",)),
    Amendment("attributes.a", "r.urdf", "link a", (), ("colour",)),
)


@pytest.mark.parametrize(
    ("old", "new", "amended"),
    [
        ("/>%s", "><visual><box/></visual></link>%s", True),
        ("%s", '<link name="flag"/>', True),
        ('a"/', 'a" colour="red"/', True),
        ('a"/', 'a" weight="3"/', False),
        ("%s", '<link name="other"/>', False),
    ],
)
def test_what_the_own_xml_changed_is_known(old, new, amended):
    text, changed = LINK % "", LINK.replace(old, new).replace("%s", "")
    difference = list(differences("r_macro.xacro", changed.encode(), text.encode()))
    assert difference
    assert all(is_amended(difference, CHANGES) for difference in difference) is amended
