"""Faults of robots that a test makes for a check: the tables of the tests of that check.

`expects` is the code of a check where findings name the place, else the name or the number of the check.
"""

from tests.support.faults.edits import sub, swap
from tests.support.faults.fault import table


def first(pattern, value="0.111"):
    """Another first number in the attribute that `pattern` ends in."""
    return sub(f'({pattern}=")[^ "]+', rf"\g<1>{value}")


ANY_JOINT = [
    *table(
        "mjcf",
        ("the axis of a slide of a planar", first(r'name="planar_joint_x"[^>]*? axis', "0.9"), "robot.xml"),
        ("a joint's place in its body", first(r'name="cylindrical_joint_turn"[^>]*? pos', "9"), "robot.xml"),
        ("a range of a slide", first(r'name="cylindrical_joint_slide"[^>]*? range', "-1"), "robot.xml"),
        ("a joint's ref", first(r'name="pin_slot_joint_slide"[^>]*? ref', "0.9"), "robot.xml"),
        ("a ball's body turned", first(r'<body name="ball"[^>]*? quat', "0.1"), "robot.xml"),
        ("a ball for a hinge", sub('<joint name="revolute_joint"', r'\g<0> type="ball"'), "robot.xml"),
        ("two joints swapped",
         sub(r'(<joint name="planar_joint_y"[^>]*>)(\s*)(<joint name="planar_joint_turn"[^>]*>)', r"\3\2\1"),
         "robot.xml"),
        ("the loose body moved", first(r'<body name="loose"[^>]*? pos', "9"), "robot.xml"),
        ("a weld lost", sub(r'<weld name="planar_loop" [^>]*/>', ""), "robot.xml"),
        ("the rigid weld lost", sub(r'<weld name="fixed_loop" [^>]*/>', ""), "robot.xml"),
        ("the ball's connect lost", sub(r'<connect name="ball_loop" [^>]*/>', ""), "robot.xml"),
        ("a carrier's site moved", first(r'<site name="planar_loop_a"[^>]*? pos', "9"), "robot.xml"),
        ("a carrier's inertia lost",
         first(r'<body name="planar_loop_carrier".*?<inertial [^>]*?mass', "0.001"), "robot.xml"),
        ("a carrier moved", first(r'<body name="pin_slot_loop_carrier"[^>]*? pos', "9"), "robot.xml"),
        ("a carrier's dof lost", sub(r'<joint name="parallel_loop_z" [^>]*/>', ""), "robot.xml"),
        ("a carrier's dof turned round", first(r'<joint name="prismatic_loop" [^>]*? axis', "0.9"),
         "robot.xml"),
    ),
    *table(
        "urdf",
        ("the user's mass", sub('<mass value="3"/>', '<mass value="2"/>'), "robot.urdf"),
        ("a lowered dof lost its place", first(r'<joint name="parallel_joint_z".*?<origin xyz', "9"),
         "robot.urdf"),
        ("a turn of a ball", first(r'<joint name="ball_joint_y".*?<axis xyz', "1"), "robot.urdf"),
        ("a floating joint moved", first(r'<joint name="loose_joint".*?<origin xyz', "9"), "robot.urdf"),
        ("a loop's first frame moved", first(r'<joint name="ball_loop_a_fixed".*?<origin xyz', "9"),
         "robot.urdf"),
        ("a loop's second frame lost",
         sub(r'<link name="fixed_loop_b"/>\s*<joint name="fixed_loop_b_fixed".*?</joint>', ""), "robot.urdf"),
        ("a floating joint fixed", sub('type="floating"', 'type="fixed"'), "robot.urdf"),
    ),
]  # fmt: skip
"""Faults of a robot with all types of joints and loops; a check of the file that is named fails."""


def within(tag, name, pattern, new):
    """Changes what matches in the element with a tag and a name."""
    return sub(pattern, new, inside=rf'<{tag} name="{name}".*?</{tag}>')


SDF = table(
    "sdf",
    ("a mass", within("link", "two", r"<mass>.*?</mass>", "<mass>9</mass>"), "mass"),
    ("a mass between", within("link", "three_joint_1", r"<mass>.*?</mass>", "<mass>0.1</mass>"), "mass"),
    ("a centre of mass", within("link", "one", r"(<inertial>\s*<pose>)\S+", r"\g<1>0.5"), "centre of mass"),
    ("a product of inertia", within("link", "one", r"<ixy>.*?</ixy>", "<ixy>0</ixy>"), "inertia"),
    ("an axis", within("joint", "one_joint", r"<xyz>.*?</xyz>", "<xyz>0 1 0</xyz>"), "motion"),
    ("an axis's sign", within("joint", "one_joint", r"<xyz>0 0 1</xyz>", "<xyz>0 0 -1</xyz>"), "motion"),
    ("a joint's place", within("joint", "gear_joint", r"(<pose[^>]*>)\S+", r"\g<1>0.5"), "motion"),
    ("a link's place", within("link", "gear", r"(<pose[^>]*>)0 0 0", r"\g<1>0 0.1 0"), "motion"),
    ("a part", within("joint", "one_joint", r"(<pose[^>]*>)\S+", r"\g<1>0.5"), "poses"),
    ("a frame", within("frame", "tip", r"0 0 0.1", "0 0 0.2"), "motion"),
    ("a frame's link", sub('attached_to="two"', 'attached_to="one"', count=0), "motion"),
    ("a type", within("joint", "one_joint", 'type="revolute"', 'type="prismatic"'), "joints"),
    ("an end of a range", within("joint", "one_joint", r"<lower>.*?</lower>", "<lower>-1</lower>"), "joints"),
    ("a range less", within("joint", "one_joint", r"<lower>.*?</lower>", ""), "joints"),
    ("a range more", within("joint", "gear_joint", r"<limit>", "<limit><lower>0</lower>"), "joints"),
    ("an effort", within("joint", "one_joint", r"<effort>3", "<effort>4"), "joints"),
    ("a velocity", within("joint", "one_joint", r"<velocity>4", "<velocity>3"), "joints"),
    ("a damping", within("joint", "one_joint", r"<damping>0.1", "<damping>0.2"), "joints"),
    ("a friction", within("joint", "one_joint", r"<friction>0.2", "<friction>0.1"), "joints"),
    ("a gear's ratio", within("joint", "gear_joint", r"<multiplier>2", "<multiplier>-2"), "relations"),
    ("a gear's offset", within("joint", "gear_joint", r"<offset>1.5", "<offset>0.5"), "relations"),
    ("a gear's driver", within("joint", "gear_joint", 'joint="one_', 'joint="three_'), "relations"),
    ("no gear", within("joint", "gear_joint", "<mimic.*</mimic>", ""), "relations"),
    ("a loop's place", within("joint", "shut", r"(<pose[^>]*>)\S+", r"\g<1>0.5"), "loops"),
    ("a loop's axis", within("joint", "shut", r"<xyz>.*?</xyz>", "<xyz>1 0 0</xyz>"), "loops"),
    ("a loop's end", within("joint", "shut", "<child>two", "<child>one"), "loops"),
    ("a frame less", sub('<frame name="tip.*?</frame>', ""), "links and joints"),
    ("a frame more", sub("</model>", '<frame name="more" attached_to="one"/></model>'), "links and joints"),
)  # fmt: skip

UNREADABLE_SDF = table(
    "sdf",
    ("cut short", sub(r".{20}\Z", ""), "line"),
    ("another version", sub('version="1.9"', 'version="1.4"'), "not one model"),
    ("relative to nothing", sub('relative_to="one_joint"', 'relative_to="none"', count=0), "'none'"),
    ("a link twice", sub('<link name="one"', '<link name="two"'), "have the same name"),
    ("a frame of a link's name", sub('<frame name="tip"', '<frame name="two"'), "'two'"),
    ("no such child", sub("<child>two", "<child>tow", count=0), "'tow'"),
    ("a mass of words", sub("<mass>1</mass>", "<mass>heavy</mass>", count=0), "'heavy'"),
    ("a mass of nan", sub("<mass>1</mass>", "<mass>nan</mass>", count=0), "'nan'"),
    ("no mass", sub("<mass>1</mass>", "", count=0), "no <mass>"),
    ("another type of joint", sub('type="ball"', 'type="universal"', count=0), "universal"),
    ("a static model", sub("</model>", "<static>true</static></model>"), "<static>"),
    ("an axis of another frame", sub("<xyz>0 0 1", '<xyz expressed_in="base">0 0 1', count=0), "axis"),
    ("degrees", sub("<pose relative", '<pose degrees="true" relative', count=0), "relative_to"),
    ("a frame on itself", sub('attached_to="two"', 'attached_to="tip"', count=0), "tip"),
)  # fmt: skip
"""`expects` is what the error says."""

SENSING = table(
    "mjcf",
    ("a sensor lost", sub(r'<gyro name="imu_gyro"[^>]*/>', ""), "sensors"),
    ("another type", sub('<gyro name="imu_gyro"', '<velocimeter name="imu_gyro"'), "sensors"),
    ("on another site", sub('site="imu"', 'site="mount"'), "sensors"),
    ("on another joint", sub('angle_pos" joint="arm_joint"', 'angle_pos" joint="eye_joint"'), "sensors"),
    ("relative to something else", sub('refname="hand"', 'refname="mount"'), "sensors"),
    ("relative to the world", sub('reftype="site" refname="hand"', ""), "sensors"),
    ("not relative to the world", sub('"imu_quat"', '"imu_quat" reftype="site" refname="mount"'), "sensors"),
    ("a site moved", sub(r'(<site name="imu" pos=")[^ ]+', r"\g<1>9"), "places of sensors"),
    ("a camera turned", sub(r'(<camera name="view"[^>]* quat=")[^"]+', r"\g<1>1 0 0 0"), "places of sensors"),
    ("a camera's angle", sub(r'(<camera name="view"[^>]* fovy=")[^"]+', r"\g<1>9"), "sensors"),
    ("a camera's pixels", sub(r'(<camera name="view"[^>]* resolution=")[^"]+', r"\g<1>9 9"), "sensors"),
    ("another order", sub(r"(<gyro name=[^>]*/>)\s*(<[^>]*/>)", r"\g<2>\g<1>"), "sensors"),
    ("a site on another link",
     sub(r'(<body name="base"[^>]*>)(.*)<site name="pad"[^>]*/>', r'\g<1><site name="pad"/>\g<2>'),
     "places of sensors"),
)  # fmt: skip

USD = table(
    "usd",
    ("mass", sub("float physics:mass = 1.1", "float physics:mass = 1.2"), "mass"),
    ("inertia", sub(r"float3 physics:diagonalInertia = \(", r"\g<0>1"), "inertia"),
    ("NaN mass", sub("float physics:mass = 1.1", "float physics:mass = nan"), "mass"),
    ("NaN inertia", sub(r"(float3 physics:diagonalInertia = \()[^)]*", r"\g<1>nan, nan, nan"), "inertia"),
    ("NaN place", sub(r'(Xform "arm".*?xformOp:translate = \(0, 0, )0', r"\g<1>nan"), "home"),
    ("limit", sub("physics:upperLimit = 0.5", "physics:upperLimit = 0.6"), "joints"),
    ("break", sub(r'RevoluteJoint "elbow".*?\{', r"\g<0>\n        float physics:breakForce = 5"), "drives"),
    ("type", sub('PhysicsRevoluteJoint "elbow"', 'PhysicsPrismaticJoint "elbow"'), "joints"),
    ("place", sub(r"(xformOp:translate = \(0, 0, 0)\)", r"\g<1>.1)"), "home"),
    ("inside", sub("(physics:excludeFromArticulation = )1", r"\g<1>0"), "loops"),
    ("name", sub('PrismaticJoint "slide"', 'PrismaticJoint "slid"'), "links and joints"),
    ("body", sub('Xform "hand"', 'Xform "hnd"'), "links and joints"),
    ("frame", sub(r'(PrismaticJoint "slide".*?localPos0 = \(0, 0, 0)\)', r"\g<1>.01)"), "motion"),
)  # fmt: skip

DRIVES = table(
    "usd",
    *((kind, sub(old, new, inside='def Scope "actuators".*'), "drives") for kind, old, new in (
        ("gain", r"double\[\] mjc:gainPrm = \[90,", "double[] mjc:gainPrm = [80,"),
        ("word", 'mjc:biasType = "affine"', 'mjc:biasType = "none"'),
        ("range", "mjc:forceRange:max = 7", "mjc:forceRange:max = 8"),
        ("more", "prepend rel mjc:target", r"uniform int mjc:group = 2\n        \g<0>"),
        ("target", "joints/elbow>", "joints/slide>"),
        ("absent", 'MjcActuator "servo"', 'Scope "servo"'),
        ("another", 'MjcActuator "servo"', 'MjcActuator "other"'))),
)  # fmt: skip

MOMENTS = 'diaginertia="0.0044 0.0055 0.0066"'
FULL = 'mass="1.1" fullinertia="4e-3 4e-3 4e-3 0 0 0"'
CHILD = r'\1<body name="more"><inertial mass="1" pos="0 0 0" diaginertia="1 1 1"/></body></body>'

READINESS = [
    *table(
        "mjcf",
        ("a light in the robot's file", sub("<worldbody>", '<worldbody><light pos="0 0 1"/>'), "2"),
        ("degrees", sub('angle="radian"', 'angle="degree"'), "3"),
        ("no classes", sub('class="visual"', 'class="seen"', count=0), "4"),
        ("a geom without a class", sub('class="collision" type', "type"), "4"),
        ("one group", sub('group="3"', 'group="2"'), "5"),
        ("no collider", sub(r'<geom name="arm_collision"[^>]*/>', ""), "6"),
        ("no inertia",
         sub(r'(name="arm".*?)<inertial [^>]*/>', r'\1<geom type="box" size=".1 .1 .1" mass="1"/>'), "7"),
        ("an inertia of a larger body", sub(MOMENTS, 'diaginertia="1 1 1"'), "9"),
        ("a centre of mass elsewhere", sub('pos="0.02 -0.01 0.03"', 'pos="2 0 0"'), "9"),
        ("next to no mass", sub('mass="1.1"', 'mass="1e-5"'), "11"),
        ("two conventions", sub(rf'quat="[^"]*" mass="1.1" {MOMENTS}', FULL), "11"),
        ("a body that stays", sub('(<body name="arm".*?)</body>', CHILD), "12"),
        ("a lost frame", sub(r'<site name="tool"[^>]*/>', ""), "13"),
        ("home out of range", sub('range="-1 1" actuatorfrcrange', 'range="0.5 1" actuatorfrcrange'), "14"),
        ("no armature", sub(r'armature="[^"]*"', 'armature="0"'), "15"),
        ("a force without a bound", sub('actuatorfrcrange="-5 5"', ""), "15"),
        ("controls beyond the range", sub("<position ", '<position ctrlrange="-9 9" '), "16"),
        ("a name with a space", sub('name="tool"', 'name="the tool"'), "17"),
        ("an actuator of another name",
         sub('(<position name="|actuator=")arm_joint"', r'\1motor"', count=0),
         "18"),
        ("no home", sub('<key name="home"(.*?) ctrl="0"', r'<key name="start"\1'), "19"),
        ("a colour of its own", sub('material="light_grey"', 'rgba="1 0 0 1"'), "26"),
        ("no time step", sub('timestep="0.002" ', ""), "27"),
        ("a base that floats", sub(r'(<body name="base"[^>]*>)(.*)qpos="0" ctrl="0"',
                                   r'\1<freejoint/>\2qpos="0 0 0.05 1 0 0 0 0"'), "28"),
        ("nothing measured", sub("<sensor>.*</sensor>", ""), "29"),
        ("noise", sub('pos="0.02 -0.01 0.03"', 'pos="0.02 -0.01 3e-17"'), "33"),
    ),
    *table("scene", ("no ground", sub(r'<geom name="floor"[^>]*/>', ""), "2")),
]  # fmt: skip

READY = 'group_state "ready" of group "links"'
PAIR = '<disable_collisions link1="{}" link2="{}" reason="{}"/></robot>'

SRDF_OF_A_USER = table(
    "srdf",
    ("no such link", swap('<link name="lower"/>', '<link name="lowr"/>', 'group "links"'),
     "C-SRDF: link name"),
    ("chain from no link", swap('base_link="upper"', 'base_link="tool"', 'group "mine"'),
     "C-SRDF: chain base_link"),
    ("beyond limits", swap('value="0.9"', 'value="1.9"', READY), "C-SRDF: joint elbow value"),
    ("no number", swap('value="0.9"', 'value="x"', READY), "C-SRDF: joint elbow value"),
    ("no such group", swap('group="links"', 'group="lnks"', READY.replace("links", "lnks")), "C-SRDF: group"),
    ("group twice", swap('name="mine"><', 'name="tool"><', 'group "tool"'), "C-SRDF: name"),
    ("pair switched off",
     swap("<enable_collisions", "<disable_collisions", 'disable_collisions "base" "hand"'),
     "C-SRDF: "),
    ("link switched off", swap("</robot>", '<disable_default_collisions link="hand"/></robot>',
                               'disable_default_collisions "hand"'), "C-SRDF: link"),
    ("pair twice",
     swap("</robot>", PAIR.format("upper", "base", "Adjacent"), 'disable_collisions "upper" "base"'),
     "C-SRDF: "),
    ("link with itself",
     swap("</robot>", PAIR.format("hand", "hand", "Never"), 'disable_collisions "hand" "hand"'),
     "C-SRDF: link2"),
)  # fmt: skip
"""Faults of what a user adds by hand."""
