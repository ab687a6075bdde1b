"""Faults of the arm's URDF and MJCF (`arm`), which are seen without a robot to compare with."""

import re

from tests.support.faults.edits import swap
from tests.support.faults.fault import table


def everywhere(pattern, new, element):
    """Replaces all that matches."""

    def plant(files, rng):
        whole = files.path.read_text()
        assert re.search(pattern, whole), pattern
        files.path.write_text(re.sub(pattern, new, whole))
        return element

    return plant


def more(tag, text, element):
    """Adds a text before the last tag of a name."""
    return swap(tag, text + tag, element)


COM = '<inertial><origin xyz="0 0 0.1"/>'
INERTIA = 'ixx="0.004" ixy="0" ixz="0" iyy="0.004" iyz="0" izz="0.0009"'
LIMITS = 'lower="-1.5" upper="1.5"'
LOWER, ELBOW, MESH = 'link "lower"', 'joint "elbow"', 'mesh of visual of link "lower"'

URDF = table(
    "bare urdf",
    ("broken", swap("</robot>", "", "XML"), "C-XML: "),
    ("tags that do not match", swap("</joint>", "</joints>", "XML"), "C-XML: "),
    ("another root", everywhere(r"(</?)robot\b", r"\1robots", "<robots>"), "C-XML: "),
    ("missing mesh", swap("lower.stl", "bottom.stl", MESH), "C-ASSET: filename"),
    ("package", swap("lower.stl", "package://x/l.stl", MESH), "C-PATH: filename"),
    ("absolute path", swap("lower.stl", "/tmp/lower.stl", MESH), "C-PATH: filename"),
    ("same name", swap('<joint name="elbow"', '<joint name="shoulder"', 'joint "shoulder"'), "C-NAME: name"),
    ("same name of links", swap('<link name="lower"', '<link name="upper"', 'link "upper"'), "C-NAME: name"),
    ("no name", swap('<link name="lower"', '<link name=""', "link"), "C-NAME: name"),
    ("name with a space", swap('<link name="lower"', '<link name=" lower"', 'link " lower"'), "C-NAME: name"),
    ("no such parent", swap('parent link="upper"', 'parent link="uper"', f"parent of {ELBOW}"),
     "C-REFERENCE: link"),
    ("no such child", swap('child link="lower"', 'child link="lowr"', f"child of {ELBOW}"),
     "C-REFERENCE: link"),
    ("no child", swap('<child link="lower"/>', "", ELBOW), "C-REFERENCE: child"),
    ("no such material", more("</visual>", '<material name="red"/>', 'material "red"'), "C-REFERENCE: name"),
    ("transmission of no joint",
     more("</robot>", '<transmission name="t"><joint name="knee"/></transmission>', 'joint "knee"'),
     "C-REFERENCE: name"),
    ("two roots", more("</robot>", '<link name="lost"/>', 'link "lost"'), "C-TREE: name"),
    ("cycle", swap('parent link="upper"', 'parent link="lower"', ELBOW), "C-TREE: child"),
    ("mimic itself", swap('mimic joint="shoulder"', 'mimic joint="elbow"', f"mimic of {ELBOW}"),
     "C-MIMIC: joint"),
    ("mimic of nothing", swap('mimic joint="shoulder"', 'mimic joint="hip"', f"mimic of {ELBOW}"),
     "C-REFERENCE: joint"),
    ("swapped limits", swap(LIMITS, 'lower="1.5" upper="-1.5"', f"limit of {ELBOW}"), "C-LIMIT: lower"),
    ("no limits", swap(f'<limit {LIMITS} effort="10" velocity="3"/>', "", ELBOW), "C-LIMIT: limit"),
    ("limit no number", swap('upper="1.5"', 'upper="one"', f"limit of {ELBOW}"), "C-NUMBER: upper"),
    ("degrees", swap('upper="1.5"', 'upper="90"', f"limit of {ELBOW}"), "C-PLAUSIBLE: upper"),
    ("no effort", swap('effort="10"', 'effort="0"', f"limit of {ELBOW}"), "C-PLAUSIBLE: effort"),
    ("negative effort", swap('effort="10"', 'effort="-10"', f"limit of {ELBOW}"), "C-LIMIT: effort"),
    ("negative velocity", swap('velocity="3"', 'velocity="-3"', f"limit of {ELBOW}"), "C-LIMIT: velocity"),
    ("negative damping", swap('damping="0.1"', 'damping="-0.1"', f"dynamics of {ELBOW}"), "C-LIMIT: damping"),
    ("no axis", swap('axis xyz="0 1 0"', 'axis xyz="0 0 0"', f"axis of {ELBOW}"), "C-DIRECTION: xyz"),
    ("long axis", swap('axis xyz="0 1 0"', 'axis xyz="0 2 0"', f"axis of {ELBOW}"), "C-PLAUSIBLE: xyz"),
    ("nan", swap('axis xyz="0 1 0"', 'axis xyz="0 nan 0"', f"axis of {ELBOW}"), "C-NUMBER: xyz"),
    *((f"mass {words}", swap('mass value="1"', f'mass value="{mass}"', f"mass of {LOWER}"), f"{code}: value")
      for words, mass, code in (
          ("zero", "0", "C-SOLID"), ("negative", "-1", "C-SOLID"), ("in grams", "1000", "C-INERTIAL"),
          ("nan", "nan", "C-NUMBER"), ("infinite", "1e999", "C-NUMBER"), ("with a comma", "1,5",
     "C-NUMBER"))),
    ("no mass", swap('<mass value="1"', "<mass", f"mass of {LOWER}"), "C-NUMBER: value"),
    ("negative moment", swap('ixx="0.004"', 'ixx="-0.004"', f"inertia of {LOWER}"), "C-SOLID: ixx"),
    ("not definite", swap('ixy="0"', 'ixy="0.005"', f"inertia of {LOWER}"), "C-SOLID: ixy"),
    ("triangle", swap('izz="0.0009"', 'izz="0.009"', f"inertia of {LOWER}"), "C-SOLID: izz"),
    ("kg mm²",
     swap(INERTIA, 'ixx="4000" ixy="0" ixz="0" iyy="4000" iyz="0" izz="900"', f"inertia of {LOWER}"),
     "C-INERTIAL: ixx"),
    ("center in mm", swap(COM, COM.replace("0.1", "100"), f"origin of {LOWER}"), "C-INERTIAL: xyz"),
    ("center outside", swap(COM, COM.replace("0.1", "0.5"), f"origin of {LOWER}"), "C-INERTIAL: xyz"),
    ("two numbers", swap(COM, COM.replace("0 0 0.1", "0 0"), f"origin of {LOWER}"), "C-NUMBER: xyz"),
    ("mesh in mm", swap('filename="lower.stl"', 'filename="lower.stl" scale="1000 1000 1000"', MESH),
     "C-UNITS: scale"),
    ("collider moved", swap('<collision><origin xyz="0 0 0.1"/>', '<collision><origin xyz="0 0 0.6"/>',
                            f"origin of collision of {LOWER}"), "C-COLLIDER: xyz"),
    ("light beside heavy", swap('mass value="1"', 'mass value="0.0005"', f"mass of {LOWER}"),
     "C-MASS-RATIO: value"),
    ("misspelled", swap('upper="1.5"', 'uper="1.5"', f"limit of {ELBOW}"), "C-XML-KNOWN: uper"),
    ("unknown element", more("<collision>", "<colision/>", f"colision of {LOWER}"), "C-XML-KNOWN: "),
)  # fmt: skip

RANGE, DIAGONAL = 'name="elbow" axis="0 1 0" range="-1.5 1.5"', 'diaginertia="0.004 0.004 0.0009"'
INERTIAL, GEOM, KEY = 'inertial of body "lower"', 'geom of body "lower"', 'key "home"'
MOTOR, LOOP = 'position "shoulder"', 'connect "loop"'
COLLIDER = '<geom name="upper" class="collision" pos="0 0 0.1"/>'


def sensor(text, element):
    return more("<keyframe>", f"<sensor>{text}</sensor>", element)


MJCF = table(
    "bare mjcf",
    ("broken", swap("</mujoco>", "", "XML"), "C-XML: "),
    ("missing mesh", swap('file="lower.stl"', 'name="lower" file="x.stl"', 'mesh "lower"'), "C-ASSET: file"),
    ("absolute path", swap('file="lower.stl"', 'name="lower" file="/a/x.stl"', 'mesh "lower"'),
     "C-ASSET: file"),
    ("same name", swap('joint name="elbow"', 'joint name="shoulder"', 'joint "shoulder"'), "C-NAME: name"),
    ("same name of bodies", swap('<body name="lower"', '<body name="base"', 'body "base"'), "C-NAME: name"),
    ("same name of sites", swap('site name="lower_start"', 'site name="upper_end"', 'site "upper_end"'),
     "C-NAME: name"),
    ("same name of sensors",
     sensor('<jointpos name="a" joint="elbow"/><jointvel name="a" joint="elbow"/>', 'jointvel "a"'),
     "C-NAME: name"),
    ("mesh twice", more('<mesh file="lower.stl"/>', '<mesh file="lower.stl"/>', 'mesh "lower"'),
     "C-NAME: file"),
    ("no such joint", swap('joint="shoulder" kp', 'joint="hip" kp', MOTOR), "C-REFERENCE: joint"),
    ("no such body", swap('site2="lower_start"', 'body2="nobody"', LOOP), "C-REFERENCE: body2"),
    ("no such site", swap('site2="lower_start"', 'site2="top"', LOOP), "C-REFERENCE: site2"),
    ("no such class", swap('class="collision" pos', 'class="colision" pos', GEOM), "C-REFERENCE: class"),
    ("no such mesh", swap('mesh="lower"', 'mesh="loer"', GEOM), "C-REFERENCE: mesh"),
    ("no such material", swap('mesh="lower"', 'mesh="lower" material="gray"', GEOM), "C-REFERENCE: material"),
    ("exclude of no body", more("<equality>", '<contact><exclude body1="base" body2="knee"/></contact>',
                                "exclude of contact"), "C-REFERENCE: body2"),
    ("sensor of no site", sensor('<framepos name="where" objtype="site" objname="top"/>', 'framepos "where"'),
     "C-REFERENCE: objname"),
    ("sensor of no joint", sensor('<jointpos name="angle" joint="x"/>', 'jointpos "angle"'),
     "C-REFERENCE: joint"),
    ("swapped range", swap(RANGE, RANGE.replace("-1.5 1.5", "1.5 -1.5"), ELBOW), "C-LIMIT: range"),
    ("degrees", swap(RANGE, RANGE.replace("-1.5 1.5", "-90 90"), ELBOW), "C-PLAUSIBLE: range"),
    ("radians as degrees", swap('angle="radian"', 'angle="degree"', 'joint "shoulder"'),
     "C-PLAUSIBLE: range"),
    ("no axis", swap('name="elbow" axis="0 1 0"', 'name="elbow" axis="0 0 0"', ELBOW), "C-DIRECTION: axis"),
    ("no rotation", swap('quat="1 0 0 0"', 'quat="0 0 0 0"', 'body "upper"'), "C-DIRECTION: quat"),
    ("three numbers", swap('quat="1 0 0 0"', 'quat="1 0 0"', 'body "upper"'), "C-NUMBER: quat"),
    ("nan", swap('quat="1 0 0 0"', 'quat="1 nan 0 0"', 'body "upper"'), "C-NUMBER: quat"),
    ("nan in an inertial", swap(DIAGONAL, DIAGONAL.replace("0.004 ", "nan ", 1), INERTIAL),
     "C-NUMBER: diaginertia"),
    ("place no number", swap('"upper_end" pos="0 0 0.25"', '"upper_end" pos="0 0 x"', 'site "upper_end"'),
     "C-NUMBER: pos"),
    ("gain no number", swap('kp="20"', 'kp="ten"', MOTOR), "C-NUMBER: kp"),
    ("negative mass", swap('mass="1"', 'mass="-1"', INERTIAL), "C-SOLID: mass"),
    ("no mass", swap('mass="1"', 'mass="0"', INERTIAL), "C-SOLID: mass"),
    ("triangle", swap(DIAGONAL, 'diaginertia="0.004 0.004 0.009"', INERTIAL), "C-SOLID: diaginertia"),
    ("not definite", swap(DIAGONAL, 'fullinertia="0.004 0.004 0.0009 0.005 0 0"', INERTIAL),
     "C-SOLID: fullinertia"),
    ("kg mm²", swap(DIAGONAL, 'diaginertia="4000 4000 900"', INERTIAL), "C-INERTIAL: diaginertia"),
    ("grams", swap('mass="1"', 'mass="1000"', INERTIAL), "C-INERTIAL: mass"),
    ("center in mm", swap('pos="0 0 0.1" mass', 'pos="0 0 100" mass', INERTIAL), "C-INERTIAL: pos"),
    ("mesh in mm", swap('file="lower.stl"', 'file="lower.stl" scale="1000 1000 1000"', 'mesh "lower"'),
     "C-UNITS: scale"),
    ("collider moved", swap(COLLIDER, COLLIDER.replace("0 0 0.1", "0 2 0.1"), 'geom "upper"'),
     "C-COLLIDER: pos"),
    ("negative damping", swap('joint damping="0.1"', 'joint damping="-0.1"', ELBOW), "C-LIMIT: damping"),
    ("control swapped", swap('ctrlrange="-1.5 1.5"', 'ctrlrange="1.5 -1.5"', MOTOR), "C-LIMIT: ctrlrange"),
    ("control without range", swap('ctrlrange="-1.5 1.5"', "", MOTOR), "C-PLAUSIBLE: ctrlrange"),
    ("no gain", swap('kp="20"', 'kp="0"', MOTOR), "C-LIMIT: kp"),
    ("keyframe too short", swap('qpos="0.1 0.1 0', 'qpos="0.1 0', KEY), "C-KEYS: qpos"),
    ("control too long", swap('ctrl="0.1"', 'ctrl="0.1 0"', KEY), "C-KEYS: ctrl"),
    ("keyframe outside", swap('qpos="0.1 0.1', 'qpos="2.1 2.1', KEY), "C-PLAUSIBLE: qpos"),
    ("keyframe quaternion", swap("0.3 1 0 0 0", "0.3 2 0 0 0", KEY), "C-PLAUSIBLE: qpos"),
    ("keyframe no quaternion", swap("0.3 1 0 0 0", "0.3 0 0 0 0", KEY), "C-KEYS: qpos"),
    ("loop open", swap('name="upper_end" pos="0 0 0.25"', 'name="upper_end" pos="0 0 0.3"', LOOP),
     "C-CLOSED: site2"),
    ("relation open", swap('qpos="0.1 0.1', 'qpos="0.1 0.4', "joint of equality"), "C-CLOSED: polycoef"),
    ("inside at start", swap("0 1 0.3 1 0 0 0", "0 0 0.3 1 0 0 0", 'body "ball"'), "C-START: pos"),
    ("misspelled", swap('armature="0.01"', 'armatur="0.01"', "joint of default"), "C-XML-KNOWN: armatur"),
    ("misspelled in a body", swap(RANGE, RANGE.replace("range", "rnage"), ELBOW), "C-XML-KNOWN: rnage"),
    ("unknown element", more("<actuator>", "<contacts/>", "contacts"), "C-XML-KNOWN: "),
    ("unknown sensor", sensor('<gyroo name="g" site="upper_end"/>', 'gyroo "g"'), "C-XML-KNOWN: "),
)  # fmt: skip

TOGETHER = table(
    "bare mjcf",
    ("mass of another", swap('mass="1"', 'mass="1.1"', 'body "lower"'), "C-TOGETHER: mass"),
    ("limit of another", swap(RANGE, RANGE.replace("-1.5 1.5", "-1.5 1.2"), ELBOW), "C-TOGETHER: range"),
    ("place of another",
     swap('<body name="lower" pos="0 0 0.25">', '<body name="lower" pos="0 0 0.26">', 'body "lower"'),
     "C-TOGETHER: pos"),
    ("axis of another", swap('name="elbow" axis="0 1 0"', 'name="elbow" axis="0 -1 0"', 'body "lower"'),
     "C-TOGETHER: pos"),
    ("joint of another", everywhere('"elbow"', '"knee"', ELBOW), "C-TOGETHER: name"),
)  # fmt: skip
"""Those that the URDF beside the MJCF shows."""

IN_A_BUILD = [
    *table(
        "bare urdf",
        ("mesh outside the folder", swap("lower.stl", "../x/lower.stl", MESH), "C-PATH: filename"),
    ),
    *table(
        "bare mjcf",
        ("meshes outside the folder", swap('angle="radian"', 'angle="radian" meshdir="../x"', "compiler"),
     "C-PATH: meshdir"),
    ),
]  # fmt: skip
"""Those that only the checks of a build mind: a model that comes alone may have its meshes anywhere."""

FAULTS = [*URDF, *MJCF, *TOGETHER]
