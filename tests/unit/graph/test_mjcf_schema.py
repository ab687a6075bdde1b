"""Every attribute that MuJoCo knows: carried over to the robot, or named, or without a meaning of its own.

The schema is that of the MuJoCo which is installed. An attribute that a later one adds fails here until
it stands in one of the tables.
"""

import re
from collections.abc import Mapping
from dataclasses import replace
from hashlib import sha256

import mujoco
import pytest
from lxml import etree

from linkwright.stages.fetch.mjcf.compiled import unsupported
from linkwright.stages.fetch.mjcf.compiled.meshes import Meshes
from linkwright.stages.fetch.mjcf.compiled.model import convert
from linkwright.stages.fetch.mjcf.compiled.textures import Textures
from linkwright.stages.graph import build_robot
from linkwright.stages.robot import codec
from linkwright.stages.robot.bundle import FileBundle
from linkwright.stages.robot.codec import encode_robot
from tests.support.building import plan_of
from tests.support.mujoco_schema import schema

LEFT_WHOLE = (
    *((name,) for name in ("custom", "deformable")),
    *(("asset", name) for name in ("texture", "skin")),
    ("body", "flexcomp"),
    *(("equality", name) for name in ("flex", "flexstrain", "flexvert")),
    *(("extension",), ("asset", "material", "layer"), ("body", "plugin"), ("body", "geom", "plugin")),
    *(("actuator", name) for name in ("plugin", "pid", "dcmotor", "orientation")),
    *(("sensor", name) for name in ("plugin", "tactile")),
)
"""Elements that are named as a whole, with all that is said in them."""

SHORTCUTS = ("motor", "position", "velocity", "intvelocity", "damper", "cylinder", "muscle", "adhesion")
"""Actuators that MuJoCo compiles to a `general`: `unit/fetch/test_mjcf_actuation.py` has them."""

ALIKE = (
    *("touch", "accelerometer", "velocimeter", "gyro", "force", "torque", "magnetometer", "camprojection"),
    *("jointpos", "jointvel", "tendonvel", "actuatorpos", "actuatorvel", "actuatorfrc", "jointactuatorfrc"),
    *("tendonactuatorfrc", "ballquat", "ballangvel", "jointlimitpos", "jointlimitvel", "jointlimitfrc"),
    *("tendonlimitpos", "tendonlimitvel", "tendonlimitfrc", "framequat", "framexaxis", "frameyaxis"),
    *("framezaxis", "framelinvel", "frameangvel", "framelinacc", "frameangacc", "subtreelinvel"),
    *("subtreeangmom", "normal", "fromto", "e_potential", "e_kinetic"),
)
"""Sensors whose attributes are those of others that are looked at."""

COMPILED = (
    *(("actuator", name) for name in SHORTCUTS),
    *(("sensor", name) for name in ALIKE),
    *((name,) for name in ("compiler", "default", "include")),
    *(("body", name) for name in ("frame", "replicate", "composite", "attach")),
    *(("asset", name) for name in ("model", "mesh")),
)
"""Elements that MuJoCo settles when it compiles: what they come to is looked at where it arrives."""

WITHOUT_MEANING = {
    *("class", "childclass"),  # defaults are settled
    *("fuse", "simple", "alignfree"),  # how MuJoCo compiles, and whether it looks for a quick way
    *("inheritrange", "shellinertia", "fitscale"),  # come to a range, an inertia and a size
    *("directional", "focalpixel", "principalpixel"),  # come to a type, and to lengths
    "content_type",  # how a file is read
    "align",  # of a free joint: where its frame is, which the body's pose has
    "nstack",  # is refused
    "material name",  # is only referred to in the file
    # Of things that the model below does not have: `unit/fetch/test_mjcf_keyframes.py` has them.
    *("key act", "key ctrl", "key mpos", "key mquat", "key plastic"),
    # Of actuators with several controls, which are named as a whole.
    "spatial armature",  # as of a fixed tendon; with a geom on its path it takes none
    *("general ffrange", "general velrange", "general input"),
    "hfield file",  # comes to its elevation
    *("bv", "bvactive"),  # colours of MuJoCo's own debugging, which its Python does not show
}
"""Attributes that are settled when MuJoCo compiles."""

SOLID = '<inertial mass="1" pos="0 0 0" diaginertia="1 1.5 2"/>'
BASE = f"""<mujoco model="base"><compiler angle="radian"/><option><flag/></option><size/><statistic/>
<visual><global/><quality/><headlight/><map/><scale/><rgba/></visual>
<asset><material name="m" rgba="1 0 0 1"/><mesh name="tet" vertex="0 0 0 1 0 0 0 1 0 0 0 1"/>
<texture name="t" type="2d" builtin="flat" width="4" height="4"/>
<hfield name="hills" nrow="2" ncol="2" size="1 1 1 1"/></asset>
<worldbody><geom name="land" type="hfield" hfield="hills" pos="0 0 -9"/>
<body name="stand">{SOLID}</body>
<body name="root">{SOLID}<freejoint name="free"/><site name="eye"/>
  <geom name="nail" size=".01"/><body name="arm" pos="0 0 1">{SOLID}<joint name="j" range="-1 1"/>
    <geom name="ball" size=".1 .1 .1"/>
    <site name="tip" pos="0 0 1"/><camera name="view"/><light name="lamp"/></body>
  <body name="hand" pos="0 1 0">{SOLID}<joint name="k"/><joint name="l" type="slide"/>
    <geom type="mesh" mesh="tet" material="m" contype="0" conaffinity="0" mass="0"/>
    <site name="pin" pos="0 0 1"/></body>
  <body name="foot" pos="0 2 0">{SOLID}<joint name="n"/><site name="toe"/>
    <geom name="heel" type="cylinder" size=".1 .1"/></body></body></worldbody>
<contact><pair name="p" geom1="ball" geom2="heel"/><exclude name="x" body1="arm" body2="hand"/></contact>
<tendon><spatial name="s"><site site="tip"/><geom geom="heel"/><site site="toe"/><pulley divisor="2"/>
  <site site="toe"/><site site="eye"/></spatial><fixed name="f"><joint joint="j" coef="1"/></fixed></tendon>
<actuator><general name="lift" tendon="s"/></actuator>
<sensor><tendonpos name="a" tendon="s"/><rangefinder name="b" site="tip"/><subtreecom name="d" body="arm"/>
  <framepos name="q" objtype="body" objname="arm"/><insidesite name="i" site="tip" objtype="body"
  objname="hand"/><distance name="e" geom1="nail" geom2="heel" cutoff="1"/><contact name="h" geom1="nail"/>
  <clock name="t"/><user name="u" dim="1"/></sensor>
<equality><connect name="c" body1="foot" body2="hand" anchor="0 0 1"/>
  <weld name="w" body1="foot" body2="hand"/><joint name="e" joint1="n" joint2="k"/>
  <tendon name="y" tendon1="f" tendon2="s"/></equality>
<keyframe><key name="ready"/></keyframe></mujoco>"""

Values = Mapping[str, str | None]

BETWEEN_SITES = {"site1": "toe", "site2": "pin", "body1": None, "body2": None, "anchor": None}

SAID = {
    **dict(
        entry.strip().split(" = ")
        for line in """pos = 0 .1 .2; quat = 1 1 0 0; axisangle = 1 0 0 1; euler = 1 0 0; zaxis = 1 0 0
xyaxes = 0 1 0 -1 0 0; user = 1 2; group = 3; rgba = 0 1 0 1; mocap = true; sleep = never; mass = 2
diaginertia = 2 2 3; type = slide; axis = 1 0 0; stiffness = 1; damping = 1; range = -1 2; limited = false
solreflimit = .1 1; solimplimit = .8 .9 .01; solreffriction = .1 1; solimpfriction = .8 .9 .01; solref = .1 1
solimp = .8 .9 .01; springdamper = .1 .2; actuatorfrcrange = -1 3; size = .2 .2 .2; contype = 3
conaffinity = 3; condim = 4; friction = 2 .1 .1; material = m; castshadow = false; surfacevel = 1 0 0 0 0 0
fluidshape = ellipsoid; active = false; relpose = 0 0 0 1 1 0 0; polycoef = 1 1 0 0 0; joint1 = l; joint2 = l
body1 = root; body2 = root; geom1 = heel; geom2 = ball; target = foot; resolution = 3 4; sensorsize = .1 .2
ambient = .1 .2 .3; attenuation = 2 0 0; springlength = .5; tendon = f; site = pin; joint = l; geom = ball
sidesite = eye; objname = root; objtype = xbody; coef = 3; divisor = 4; datatype = quaternion; needstage = vel
data = dist dir; ctrlrange = -2 3; forcerange = -2 3; actrange = -2 3; gear = 2; dyntype = filter
gaintype = affine; biastype = affine; elevation = 0 1 2 3; texture = t; memory = 10M; cone = elliptic
integrator = RK4; jacobian = dense; solver = CG; gravity = 0 0 -1.6; o_solref = .1 1; o_solimp = .8 .9 .01
o_friction = 2 2 .1 .1 .1""".splitlines()
        for entry in line.split(";")
    ),
    "fullinertia": {"fullinertia": "2 2 2 .1 0 0", "diaginertia": None},
    "actuatorfrclimited": {"actuatorfrclimited": "true", "actuatorfrcrange": "-3 3"},
    "fromto": {"fromto": "0 0 0 0 0 1", "type": "capsule", "pos": None},
    "fluidcoef": {"fluidshape": "ellipsoid", "fluidcoef": "1 1 1 1 1"},
    "hfield": {"hfield": "hills", "type": "hfield"},
    "mesh": {"mesh": "tet", "type": "mesh", "size": None},
    **dict.fromkeys(("site1", "site2"), BETWEEN_SITES),
}
"""What says something, by attribute: a value, or attributes that belong together (None: without that)."""

YIELDS = {"springyield": ".5", "stiffness": "1"}
LATE = {"nsample": "3", "delay": ".01", "interp": "linear"}
LENS = {"sensorsize": ".1 .1", "resolution": "3 4", "focal": "1 1"}
AIMED = {"target": "foot", "mode": "targetbody"}
SEEN_FROM = {"refname": "hand", "reftype": "xbody"}
NAMED = {"objname": "hand", "objtype": "xbody"}
CRANK = {"cranksite": "tip", "slidersite": "toe", "cranklength": "1", "tendon": None}
ACTIVE = {"actrange": "0 1", "dyntype": "filter", "actlimited": "true"}
SENSORS = ("rangefinder", "tendonpos", "framepos", "subtreecom", "insidesite", "distance", "contact", "clock")

ELSEWHERE = {
    **{
        tuple(name.split()): value
        for name, value in {
            "flag gravity": "disable", "headlight active": "0", "flag sleep": "enable", "geom type": "box",
            "site type": "box", "light type": "point", "light mode": "trackcom", "camera mode": "trackcom",
            "camera projection": "orthographic", "contact data": "found force", "contact body2": "hand",
            "contact subtree2": "hand", "contact reduce": "maxforce", "hfield size": "1 2 3 4",
            "hfield nrow": "3", "hfield ncol": "3", "general lengthrange": "0 1", "subtreecom body": "hand",
            "distance geom1": "ball", "distance geom2": "ball", "light range": "7", "camera output": "depth",
            "global elevation": "7", "rgba joint": "0 1 0 1", "key qpos": "0 0 0 1 0 0 0 .5 0 0 0",
            "key qvel": "0 0 0 0 0 0 .5 0 0 0", "camera target": AIMED, "light target": AIMED,
            "camera sensorsize": LENS, "framepos refname": SEEN_FROM, "framepos reftype": SEEN_FROM,
            "user objname": NAMED, "user objtype": NAMED, "general cranksite": CRANK,
            "general slidersite": CRANK, "general cranklength": CRANK, "general actrange": ACTIVE,
            "general actlimited": ACTIVE, "spatial springyield": YIELDS, "fixed springyield": YIELDS,
            "tendon tendon2": {"tendon2": None},
        }.items()
    },
    ("flag", "ipc"): {"ipc": "enable", "../integrator": "discrete"},
    ("camera", "focal"): {"focal": ".1 .2", "sensorsize": ".1 .1", "resolution": "3 4"},
    ("camera", "principal"): {"principal": ".1 .2", **LENS},
    ("contact", "body1"): {"body1": "root", "geom1": None},
    ("contact", "site"): {"site": "tip", "geom1": None},
    ("contact", "subtree1"): {"subtree1": "root", "geom1": None},
    ("rangefinder", "camera"): {"camera": "view", "site": None},
    ("distance", "body1"): {"body1": "root", "geom1": None},
    ("distance", "body2"): {"body2": "root", "geom2": None},
    **{
        ("general", name): {name: value, "tendon": None}
        for name, value in {"body": "arm", "joint": "j", "jointinparent": "j", "site": "tip"}.items()
    },
    ("general", "refsite"): {"site": "tip", "refsite": "toe", "tendon": None},
    ("general", "actdim"): {"actdim": "2", "dyntype": "user"},
    ("general", "actearly"): {"actearly": "true", "dyntype": "filter"},
    ("general", "ctrllimited"): {"ctrlrange": "0 1", "ctrllimited": "true"},
    ("general", "forcelimited"): {"forcerange": "0 1", "forcelimited": "true"},
    **{(kind, "limited"): {"range": "0 1", "limited": "true"} for kind in ("spatial", "fixed")},
    ("joint", "springref"): {"springref": ".3", "stiffness": "1"},
    ("general", "armature"): {"armature": "1", "joint": "j", "tendon": None},
    **{(kind, name): LATE for kind in ("general", *SENSORS) for name in ("delay", "interp", "nsample")},
    ("tendon", "tendon1"): {"tendon1": "s", "tendon2": None},
    ("user", "datatype"): {"datatype": "quaternion", "dim": "4"},
    **{("geom", name): {name: "2", "BODY": None} for name in ("mass", "density")},
}  # fmt: skip
"""The same of single elements."""

ANY = ("0.7", "7", "2 2", ".1 .2 .3", ".1 .2 .3 .4", "true", "enable", "disable")
"""Values for other attributes: the first is used that MuJoCo takes and that says something."""


ON_TOP = {"mocap", "sleep"}
"""Attributes that only bodies in the world may have."""


PLAN = plan_of(root={"disconnected": "separate"})


def robot_of(tree):
    """The robot of an MJCF; ValueError where MuJoCo does not take it."""
    spec = mujoco.MjSpec.from_string(etree.tostring(tree).decode())
    model = spec.compile()
    body = codec.dump(convert(model, spec, Meshes(model), Textures(model), "base.xml"))
    root = {"document": "base.xml", "microversion": "m", "element": "", "configuration": ""}
    digest = sha256(body).hexdigest()
    bundle = FileBundle("mjcf", root, digest, {"model": digest}, {digest: body})
    return build_robot(bundle, PLAN)


def values_of(element, attribute):
    """Attributes to set, in the order in which they are tried."""
    text = ELSEWHERE.get((element, attribute), SAID.get(attribute))
    if text is None:
        return [{attribute: value} for value in ANY]
    return [{attribute: text} if isinstance(text, str) else text]


def changed(where, values):
    """The model with one element that says more."""
    tree = etree.fromstring(BASE)
    path = "/".join({"body": "worldbody/body/body"}.get(step, step) for step in where)
    path = "worldbody/body/freejoint" if path.endswith("freejoint") else path
    if where == ("body",) and values.keys() & ON_TOP:
        path = f"worldbody/body[{2 if 'sleep' in values else 1}]"
    node = tree.find(path)
    assert node is not None, where
    for name, value in values.items():
        if name == "BODY":
            node.getparent().remove(node.getparent().find("inertial"))
        elif name.startswith("../"):
            node.getparent().set(name[3:], value)
        elif value is None:
            node.attrib.pop(name, None)
        elif name == "name" and "name" in node.attrib:
            old, node.attrib["name"] = node.attrib["name"], value
            for other in tree.iter():
                named = [key for key, text in other.attrib.items() if text == old and key != "name"]
                other.attrib.update(dict.fromkeys(named, value))
        else:
            node.set(name, value)
    return tree


def without_findings(robot):
    return encode_robot(replace(robot, diagnostics=()))


def left(robot):
    return [note.message for note in robot.diagnostics if note.code.endswith("MJCF-LEFT")]


def is_named(robot, where, attribute):
    """Whether a diagnostic has the names of the element and of the attribute beside each other."""
    phrases = [re.findall(r"\w+", phrase) for message in left(robot) for phrase in re.split("[;:]", message)]
    section = {where[0]} & {"actuator", "contact", "equality", "sensor", "tendon"}
    elements = {where[-1].removeprefix("free"), *section}
    return any(attribute in words and elements & set(words) for words in phrases)


def lost(where, attributes, base):
    """The attributes that are neither carried over nor named."""
    silent = []
    for attribute in attributes:
        took = False
        for values in values_of(where[-1], attribute):
            try:
                robot = robot_of(changed(where, values))
            except ValueError:
                continue
            took = True
            news = is_named(robot, where, attribute) and not is_named(base, where, attribute)
            if news or without_findings(robot) != without_findings(base):
                break
        else:
            silent.append(f"{attribute} {'is silent' if took else 'takes none of the values'}")
    return silent


def walked():
    """The elements that are looked at attribute by attribute."""
    whole = (*LEFT_WHOLE, *COMPILED)
    beneath = [(where, names) for where, names in schema() if not any(where[: len(w)] == w for w in whole)]
    return [
        (where, left)
        for where, names in beneath
        if where and (left := [name for name in names if not {name, f"{where[-1]} {name}"} & WITHOUT_MEANING])
    ]


@pytest.fixture(scope="module")
def base():
    return robot_of(etree.fromstring(BASE))


@pytest.mark.slow
@pytest.mark.parametrize(("where", "attributes"), walked(), ids=["/".join(where) for where, _ in walked()])
def test_an_attribute_is_carried_over_or_named(where, attributes, base):
    assert lost(where, attributes, base) == []


WHOLE = {
    "custom numeric": '<custom><numeric name="x" data="1"/></custom>',
    "custom text": '<custom><text name="x" data="1"/></custom>',
    "custom tuple": '<custom><tuple name="x"><element objtype="body" objname="arm"/></tuple></custom>',
    "texture": '<asset><texture name="x" type="2d" builtin="flat" width="4" height="4"/></asset>',
    "flex": """<worldbody><flexcomp name="x" type="grid" dim="2" count="3 3 1" spacing="1 1 1" mass="1"
        radius=".01"/></worldbody>""",
}
"""Words of the diagnostic → elements that are left out as a whole, called x."""


@pytest.mark.parametrize("words", WHOLE)
def test_elements_that_are_left_out_as_a_whole_are_named(words):
    robot = robot_of(etree.fromstring(BASE.replace("</mujoco>", f"{WHOLE[words]}</mujoco>")))
    assert re.search(rf"\d × {words} \([^)]*\bx\b", " ".join(left(robot)))


def test_a_silent_attribute_is_found(base, monkeypatch):
    monkeypatch.setattr(unsupported, "element_omissions", lambda *_: ())
    assert lost(("asset", "material"), ["shininess", "rgba"], base) == ["shininess is silent"]


def test_the_walk_sees_the_schema():
    elements = dict(schema())
    assert len(elements) > 120
    assert {"margin", "solreflimit", "actuatorgravcomp"} <= set(elements["body", "joint"])
    assert "fluidshape" in elements["body", "geom"]
    assert "contact" in elements["option", "flag"]
    assert len(walked()) > 15


def test_defaults_are_nobodys_loss(base):
    """Values that say what MuJoCo says anyway, typed or nearly so."""
    text = BASE.replace("<option>", '<option timestep="0.002" gravity="0 0 -9.80665" density="0">')
    text = text.replace('name="j"', 'name="j" margin="0" solreflimit="0.02 1" stiffness="0"')
    text = text.replace('name="ball"', 'name="ball" friction="1 0.005 0.0001" condim="3" solmix="1.0000001"')
    messages, usual = (
        [d.message for d in robot.diagnostics] for robot in (robot_of(etree.fromstring(text)), base)
    )
    assert messages == usual
