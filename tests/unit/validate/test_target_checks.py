"""What engines do not take of a model is named, each thing of it, and nothing else.

Which of these models MJX 3.17.0 and MuJoCo Warp 4.0.0 refuse is as `put_model` of each said.
"""

import json
from typing import get_args

import mujoco
import pytest

from linkwright.pipeline.cli import run
from linkwright.pipeline.verbs.check import TARGETS
from linkwright.stages.robot.model.robot import Relation
from linkwright.stages.targets.engines import ENGINES, MujocoVersion
from linkwright.stages.targets.readers import rows_of
from linkwright.stages.validate.targets.build import check_targets
from linkwright.stages.validate.targets.judge import judge_file, message
from tests.support.building import plan_of, write
from tests.support.robots import joint, robot_with

NEEDS_WORDS = pytest.mark.skipif(
    int(mujoco.__version__.split(".")[0]) < 4, reason="an older MuJoCo does not know the words of these files"
)

MESH = '<mesh name="m" vertex="0 0 0 .1 0 0 0 .1 0 0 0 .1"/>'
CONE = "frictionless contacts in elliptic cones"
CYLINDER, ELLIPSOID = 'type="cylinder" size=".1 .1"', 'type="ellipsoid" size=".1 .2 .1"'
BOX, SOLID = 'type="box" size=".1 .1 .1"', 'type="mesh" mesh="m"'


def two(first, second):
    bodies = "".join(
        f'<body name="{name}" pos="0 0 {z}"><freejoint/><geom name="g{name}" {geom}/></body>'
        for name, z, geom in (("a", 0, first), ("b", 0.3, second))
    )
    return f"<mujoco><asset>{MESH}</asset><worldbody>{bodies}</worldbody></mujoco>"


def arm(actuator="", option="", sensor="", geom=""):
    return f"""<mujoco><option {option.partition(">")[0]}>{option.partition(">")[2]}</option><worldbody>
    <geom name="floor" type="plane" size="1 1 1" {geom}/><body name="a" pos="0 0 1">
    <joint name="j" range="-1 1" limited="true"/><geom name="g" size=".1" {geom}/><site name="s"/>
    <body name="b" pos=".5 0 0"><joint name="k"/><geom size=".1"/><site name="t"/></body></body></worldbody>
    <actuator>{actuator}</actuator><sensor>{sensor}</sensor></mujoco>"""


def flag(name, value="enable"):
    return arm(option=f'><flag {name}="{value}"/>')


def flex(how):
    grid = f'<flexcomp name="f" type="grid" count="4 4 4" spacing=".1 .1 .1" dim="3" radius=".01" {how}/>'
    return f'<mujoco><worldbody><body name="a">{grid}</body></worldbody></mujoco>'


BALLS = "".join(f'<body name="c{x}" pos="{x} 0 3"><freejoint/><geom size=".1"/></body>' for x in range(3, 14))
CROWD = arm(option='jacobian="dense"').replace("</worldbody>", f"{BALLS}</worldbody>")

SITES = "contact sensors of sites, bodies and net forces"
DISTANCES = "sensors of distances, limits and energies"
SLIDERS = "adhesion and slider-cranks"
FLEXES = "rigid, quadratic and self-colliding flexes"
ORIENTED = arm('<orientation joint="k" kp="1"/>').replace('name="k"', 'name="k" type="ball"')

CASES = {
    "cylinder and mesh": (two(CYLINDER, SOLID), "cylinders", ""),
    "cylinder and box": (two(CYLINDER, BOX), "cylinders", ""),
    "two cylinders": (two(CYLINDER, CYLINDER), "", ""),
    "ellipsoid and mesh": (two(SOLID, ELLIPSOID), "ellipsoids", ""),
    "two ellipsoids": (two(ELLIPSOID, ELLIPSOID), "", ""),
    "margin of a mesh": (two(f'{SOLID} margin=".01"', BOX), "margins of meshes", ""),
    "margin of a box": (two(f'{BOX} margin=".01"', BOX), "", ""),
    "motor": (arm('<dcmotor joint="j" motorconst=".1" resistance="2"/>'), "motors by voltage", ""),
    "pid": (arm('<pid joint="j" kp="1" ki="2" input="pos"/>'), "pid servos", "pid servos"),
    "delay": (arm('<position joint="j" kp="1" delay=".01" nsample="5"/>'), "delays of actuators", ""),
    "muscle": (arm('<muscle joint="j" lengthrange="0 1"/>'), "", ""),
    "user": (arm('<general joint="j" dyntype="user" actdim="1"/>'), "user actuators", ""),
    "adhesion": (arm('<adhesion body="a" ctrlrange="0 1"/>'), SLIDERS, ""),
    "slider-crank": (arm('<general cranksite="s" slidersite="t" cranklength=".2"/>'), SLIDERS, ""),
    "implicit": (arm(option='integrator="implicit"'), "implicit integrator", ""),
    "RK4": (arm(option='integrator="RK4"'), "", ""),
    "PGS": (arm(option='solver="PGS"'), "solver PGS", "solver PGS"),
    "elliptic": (arm(option='cone="elliptic"'), "", ""),
    "elliptic without friction": (arm(option='cone="elliptic"', geom='condim="1"'), CONE, ""),
    "fluid": (arm(option='integrator="implicitfast" density="1"'), "fluid with implicitfast", ""),
    "contact of a site": (arm(sensor='<contact site="s" num="1"/>'), SITES, ""),
    "contact of geoms": (arm(sensor='<contact geom1="g" num="1"/>'), "", ""),
    "net force": (arm(sensor='<contact geom1="g" reduce="netforce"/>'), SITES, ""),
    "distance": (arm(sensor='<distance geom1="g" geom2="floor"/>'), DISTANCES, ""),
    "energy sensor": (arm(sensor="<e_kinetic/>"), DISTANCES, ""),
    "limit": (arm(sensor='<jointlimitpos joint="j"/>'), DISTANCES, ""),
    "touch": (arm(sensor='<touch site="s"/>'), "", ""),
    "energy": (flag("energy"), "flag energy", ""),
    "fwdinv": (flag("fwdinv"), "flag fwdinv", "flag fwdinv"),
    "override": (flag("override"), "flags of the solver", "flags of the solver"),
    "midphase": (flag("midphase", "disable"), "", "disabled midphase or autoreset"),
    "ipc": (arm(option='integrator="discrete" solver="CG"><flag ipc="enable"/>'), "", "flag ipc"),
    "noslip and discrete": (arm(option='integrator="discrete" noslip_iterations="3"'), "",
                            "noslip iterations of the discrete integrator"),
    "dense": (CROWD, "", "dense Jacobian of more than 60 speeds"),
    "sleep and CG": (arm(option='solver="CG"><flag sleep="enable"/>'), "",
                     "sleep of another solver than Newton"),
    "sleep": (flag("sleep"), "", ""),
    "orientation": (ORIENTED, "orientation servos", "orientation servos"),
    "flex": (flex(""), "flexes", ""),
    "rigid flex": (flex('rigid="true"'), "flexes", FLEXES),
    "quadratic flex": (flex('dof="quadratic"'), "flexes", FLEXES),
    "trilinear flex": (flex('dof="trilinear"'), "flexes", FLEXES),
    "eulerdamp": (flag("eulerdamp", "disable"), "", ""),
}  # fmt: skip
"""By kind: a model, and what MJX and MuJoCo Warp refuse of it."""


def things(target, text, folder, version=None):
    """The things that the check of a file names."""
    path = folder / "robot.xml"
    path.write_text(text)
    check, *_ = judge_file(target, path, version)
    assert check.passed == (not check.findings)
    return named(check)


def named(check):
    """The things that a check names."""
    return sorted({finding.message.partition(", ")[2].partition(": ")[0] for finding in check.findings})


@NEEDS_WORDS
@pytest.mark.parametrize("case", CASES)
def test_what_mjx_and_mujoco_warp_refuse_is_named(case, tmp_path):
    text, *refused = CASES[case]
    for target, thing in zip(("mjx", "mjwarp"), refused, strict=True):
        assert things(target, text, tmp_path) == [thing] * bool(thing)


EVERYTHING = f"""<mujoco><option solver="PGS" integrator="implicit" cone="elliptic">
<flag energy="enable" fwdinv="enable" override="enable"/></option>
<asset>{MESH}</asset><worldbody><geom name="floor" type="plane" size="1 1 1" condim="1"/>
<body name="a"><joint name="j" range="-1 1" limited="true"/><geom name="can" {CYLINDER} condim="1"/>
<site name="s"/><body name="b" pos="1 0 0"><joint name="k"/><geom name="egg" {ELLIPSOID}/>
<site name="t"/></body></body>
<body name="c" pos="0 0 1"><freejoint/><geom name="rock" {SOLID} margin="0.01"/></body></worldbody>
<actuator><dcmotor name="volt" joint="j" motorconst=".1" resistance="2"/>
<pid name="loop" joint="k" kp="1" ki="2" input="pos"/>
<general name="mine" joint="j" dyntype="user" actdim="1"/><adhesion name="glue" body="a" ctrlrange="0 1"/>
<position name="late" joint="j" kp="1" delay=".01" nsample="5"/></actuator>
<sensor><contact name="push" site="s" num="1"/>
<distance name="far" geom1="can" geom2="floor"/></sensor></mujoco>"""


@NEEDS_WORDS
@pytest.mark.usefixtures("guests_at_home")
def test_each_thing_of_a_model_with_everything_is_named(tmp_path, capsys):
    path = tmp_path / "robot.xml"
    path.write_text(EVERYTHING)
    check, *_ = judge_file("mjx", path)
    places = " ".join(f"{finding.element} {finding.attribute}" for finding in check.findings)
    names = ("can", "egg", "rock", "volt", "loop", "mine", "glue", "late", "push", "far")
    words = ("flag energy", "flag fwdinv", "flag override", "option solver", "option integrator", "condim")
    assert [word for word in (*(f'"{name}"' for name in names), *words) if word not in places] == []
    assert run(["check", "--target", "mjx", str(path)]) == 3
    output = capsys.readouterr().out
    assert "C-TARGET" in output
    assert "can" in output
    path.write_text(two(BOX, BOX))
    assert run(["check", "--target", "mjx,mjwarp", str(path)]) == 0
    assert run(["check", "--target", "mjy", str(path)]) == 2


@NEEDS_WORDS
@pytest.mark.parametrize(
    ("text", "version", "expected"),
    [
        (arm('<pid joint="j" kp="1" input="pos"/>'), "3.11", ["words of MuJoCo 3.16"]),
        (arm('<pid joint="j" kp="1" input="pos"/>'), "3.16", []),
        (arm(option='integrator="discrete"'), "3.11", ["words of MuJoCo 3.16"]),
        (arm(geom='castshadow="false"'), "3.17", ["words of MuJoCo 4.0"]),
        (arm(geom='castshadow="false"'), "4.0", []),
    ],
)
def test_version_of_mujoco_is_told_by_the_words_that_came_later(text, version, expected, tmp_path):
    assert things("mujoco", text, tmp_path, version) == expected


@NEEDS_WORDS
@pytest.mark.parametrize(
    ("count", "shapes", "pairs"),
    [(7, 7, 21), (6, 6, None), (8, 1, None)],
)
def test_many_pairs_of_hulls_that_jax_compiles_are_stated(count, shapes, pairs, tmp_path):
    """Pairs of the same two meshes are compiled once."""
    corners = "0 0 0 1 0 0 0 1 0 0 0"
    meshes = "".join(f'<mesh name="m{i}" vertex="{corners} {i + 1}"/>' for i in range(shapes))
    bodies = "".join(
        f'<body pos="{3 * i} 0 0"><freejoint/><geom type="mesh" mesh="m{i % shapes}"/></body>'
        for i in range(count)
    )
    path = tmp_path / "robot.xml"
    path.write_text(f"<mujoco><asset>{meshes}</asset><worldbody>{bodies}</worldbody></mujoco>")
    stated = [finding.message for check in judge_file("mjx", path)[1:] for finding in check.findings]
    assert [text.partition(":")[0] for text in stated] == [f"{pairs} pairs of hulls may touch"] * bool(pairs)


def test_visuals_that_a_reader_refuses_are_named(tmp_path):
    urdf = tmp_path / "arm.urdf"
    urdf.write_text(
        '<robot name="arm"><link name="a"><visual><geometry><mesh filename="a.glb"/></geometry></visual>'
        '<inertial><mass value="1"/></inertial></link></robot>'
    )
    refused, *_ = judge_file("pybullet", urdf)
    assert [finding.element for finding in refused.findings] == ['mesh of visual of link "a"']
    assert "`mesh.format: obj`" in refused.findings[0].message


def test_readers_of_urdf_and_mjcf_are_judged_by_the_text(tmp_path):
    urdf = tmp_path / "arm.urdf"
    urdf.write_text(
        '<robot name="arm"><link name="a"><collision><geometry><mesh filename="a.stl"/></geometry>'
        '</collision></link><link name="b"/><link name="c"/>'
        '<joint name="j" type="revolute"><parent link="a"/><child link="b"/>'
        '<limit lower="-1" upper="1" effort="2" velocity="3"/><dynamics friction="0.1"/></joint>'
        '<joint name="k" type="revolute"><parent link="b"/><child link="c"/><mimic joint="j"/>'
        '<limit lower="-1" upper="1" effort="0" velocity="3"/></joint></robot>'
    )
    refused, left = judge_file("drake", urdf)
    assert [finding.element for finding in refused.findings] == ['mesh of collision of link "a"']
    assert (refused.level, left.level) == ("error", "warning")
    assert named(left) == ["effort", "friction", "relations"]
    refused, *_ = judge_file("pybullet", urdf)
    assert named(refused) == ["frames", "relations"]
    assert 'mimic of joint "k"' in [finding.element for finding in refused.findings]


def check_of(target, path):
    (check,) = judge_file(target, path)
    return check


def test_format_that_an_engine_does_not_read_fails(tmp_path):
    urdf = tmp_path / "arm.urdf"
    urdf.write_text('<robot name="arm"><link name="a"/></robot>')
    check = check_of("gazebo", urdf)
    assert (check.passed, check.detail) == (False, "Gazebo with DART reads SDF; this is a URDF")
    mjcf = tmp_path / "robot.xml"
    mjcf.write_text(arm())
    assert check_of("isaac", mjcf).detail == "Isaac Sim reads USD or URDF; this is an MJCF"
    assert check_of("pybullet", mjcf).detail == "PyBullet reads URDF; this is an MJCF"


def test_rows_are_there_for_each_format_that_an_engine_reads():
    assert all([*rows_of(name, form)] for name, engine in ENGINES.items() for form in engine.reads)


NEWTON = {
    "plain": ("", "", "", ""),
    "orientation servos": ('<orientation joint="k" kp="1"/>', "", "", 'type="ball"'),
    "adhesion": ('<adhesion body="a" ctrlrange="0 1"/>', "", "", ""),
    "pneumatic cylinders": ('<cylinder joint="j"/>', "", "", ""),
    "delays of actuators": ('<position joint="j" kp="1" delay=".01" nsample="5"/>', "", "", ""),
    "time constants of servos": ('<position joint="j" kp="1" timeconst=".1"/>', "", "", ""),
    "pid servos": ('<pid joint="j" kp="1"/>', "", "", ""),
    "cones": ("", "", "", 'type="ball" range="0 1"'),
    "spring-dampers": ("", "", "", 'springdamper=".1 1"'),
    "polynomials of damping": ("", "", "", 'damping="1 2 3"'),
    "sensors": ("", "", '<touch site="s"/>', ""),
    "gravity": ("", 'gravity="0 0 -3"', "", ""),
    "noslip iterations": ("", 'noslip_iterations="3"', "", ""),
}


@pytest.mark.parametrize("thing", NEWTON)
def test_what_newton_leaves_out_of_an_mjcf_is_named(thing, tmp_path):
    actuator, option, sensor, attributes = NEWTON[thing]
    path = tmp_path / "robot.xml"
    path.write_text(arm(actuator, option, sensor).replace('name="k"', f'name="k" {attributes}'))
    assert {name for check in judge_file("newton", path) for name in named(check)} == {thing} - {"plain"}


@pytest.mark.usefixtures("guests_at_home")
def test_of_a_folder_an_engine_is_asked_about_what_it_reads(tmp_path, capsys):
    (tmp_path / "arm.urdf").write_text('<robot name="arm"><link name="a"/></robot>')
    assert run(["check", "--target", "gazebo", str(tmp_path)]) == 3
    (tmp_path / "arm.sdf").write_text(SDF)
    capsys.readouterr()
    assert run(["check", "--target", "gazebo", "--json", str(tmp_path)]) == 3
    checks = json.loads(capsys.readouterr().out)["checks"]
    assert [check["name"] for check in checks] == ["arm.sdf: target gazebo"]


SDF = """<sdf version="1.9"><model name="arm"><link name="a"/><link name="b"/><link name="c"/>
<joint name="hold" type="fixed"><parent>world</parent><child>a</child></joint>
<joint name="j" type="revolute"><parent>a</parent><child>b</child><axis><xyz>0 0 1</xyz></axis></joint>
<joint name="k" type="revolute"><parent>a</parent><child>c</child>
<axis><xyz>0 0 1</xyz><mimic joint="j"/></axis></joint>
<joint name="shut" type="ball"><parent>c</parent><child>b</child></joint></model></sdf>"""


def test_sdf_is_judged_by_its_text(tmp_path):
    sdf = tmp_path / "arm.sdf"
    sdf.write_text(SDF)
    for target in ("gazebo", "drake"):
        check = check_of(target, sdf)
        loops = [finding.element for finding in check.findings if "loops" in finding.message]
        assert (loops, named(check)) == (['joint "shut"'], ["loops", "relations"])


def test_joint_of_a_plugin_or_of_another_model_closes_no_loop(tmp_path):
    sdf = tmp_path / "arm.sdf"
    plugin = '<plugin name="p" filename="p"><joint>j</joint><joint>k</joint></plugin>'
    model = SDF.partition("<model")[1] + SDF.partition("<model")[2].partition("</model>")[0]
    models = f"{model}{plugin}</model>{model}</model>".replace('type="ball"', 'type="fixed"')
    sdf.write_text(f'<sdf version="1.9"><world name="w">{models}</world></sdf>')
    check = check_of("drake", sdf)
    loops = [finding.element for finding in check.findings if "loops" in finding.message]
    assert loops == ['joint "shut"'] * 2


ZEROS = [("0.00", []), ("0e0", []), ("-0", []), ("0.1", ["damping"])]


@pytest.mark.parametrize(("damping", "expected"), ZEROS)
def test_number_that_is_zero_is_nothing_to_leave_out(damping, expected, tmp_path):
    urdf = tmp_path / "arm.urdf"
    urdf.write_text(
        '<robot name="arm"><link name="a"/><link name="b"/><joint name="j" type="continuous">'
        f'<parent link="a"/><child link="b"/><dynamics damping="{damping}"/></joint></robot>'
    )
    left_out = [name for check in judge_file("isaac", urdf) for name in named(check)]
    assert [name for name in left_out if name == "damping"] == expected


def test_pybullet_gives_a_kilogram_to_links_without_inertials(tmp_path):
    inertial = '<inertial><mass value="1"/></inertial>'
    urdf = tmp_path / "arm.urdf"
    joints = "".join(
        f'<joint name="{child}" type="fixed"><parent link="{parent}"/><child link="{child}"/></joint>'
        for parent, child in (("world", "base"), ("base", "tip"))
    )
    urdf.write_text(
        f'<robot name="arm"><link name="world"/><link name="base">{inertial}</link><link name="tip"/>'
        f"{joints}</robot>"
    )
    refused, left = judge_file("pybullet", urdf)
    assert [finding.element for finding in refused.findings] == ['link "tip"']
    assert [finding.element for finding in left.findings] == ['link "base"']
    assert named(left) == ["inertia"]


@NEEDS_WORDS
def test_words_that_the_mujoco_of_mjx_lacks_are_refused(tmp_path):
    text = arm().replace('name="k"', 'name="k" springyield="1"')
    assert things("mjx", text, tmp_path) == ["words of MuJoCo 4.0"]
    assert things("mjwarp", text, tmp_path) == []


def test_pair_has_its_own_dimension_and_margin(tmp_path):
    def paired(first, second, pair, option=""):
        contact = f'<contact><pair name="p" geom1="ga" geom2="gb" {pair}/></contact>'
        return two(first, second).replace("</mujoco>", f"{option}{contact}</mujoco>")

    elliptic, slick = '<option cone="elliptic"/>', f'{BOX} condim="1"'
    assert things("mjx", two(slick, slick).replace("<asset>", f"{elliptic}<asset>"), tmp_path) == [CONE]
    assert things("mjx", paired(slick, slick, 'condim="3"', elliptic), tmp_path) == []
    assert things("mjx", paired(BOX, BOX, 'condim="1"', elliptic), tmp_path) == [CONE]
    assert things("mjx", paired(f'{SOLID} margin=".01"', BOX, 'margin="0"'), tmp_path) == []
    assert things("mjx", paired(SOLID, BOX, 'margin=".01"'), tmp_path) == ["margins of meshes"]


def test_two_versions_of_an_engine_have_names_of_their_own(tmp_path):
    path = tmp_path / "robot.xml"
    path.write_text(arm())
    names = [judge_file("mujoco", path, version)[0].name for version in ("3.11", "4.0")]
    assert names == ["robot.xml: target mujoco:3.11", "robot.xml: target mujoco:4.0"]


def test_verb_lists_the_engines_that_there_are():
    versions = [f"mujoco:{version}" for version in get_args(MujocoVersion)]
    listed = [name for name in TARGETS if name not in versions]
    assert listed == list(ENGINES)
    assert set(versions) < set(TARGETS)


def test_message_reads_as_a_sentence_of_the_thing():
    (row,) = (row for row in rows_of("pybullet", "urdf") if row.thing == "relations")
    assert message(row).startswith("PyBullet 3.2.7, relations: dropped silently")


def test_build_is_judged_as_its_file_and_its_model_are(tmp_path):
    robot = robot_with(
        [joint("revolute", "base", "arm"), joint("revolute", "arm", "hand")],
        relations=[Relation("Gear", "hand_joint", "arm_joint", 2.0, 0.0)],
    )
    keys = plan_of(target={"pybullet": {}, "mjx": {}}, scene__option={"noslip_iterations": 3})
    made = write(robot, tmp_path, keys)
    urdf = tmp_path / f"{robot.name}.urdf"
    more = (
        '<joint name="shut" type="continuous"><parent link="arm"/><child link="late"/>'
        '<mimic joint="arm_joint"/></joint>'
    )
    link = '<link name="late"><inertial><mass value="1"/></inertial></link>'
    urdf.write_text(urdf.read_text().replace("</robot>", f"{link}{more}</robot>"))
    checks = {check.name: check for check in check_targets(tmp_path, made.written, keys.target)}
    pybullet = checks[f"{urdf.name}: target pybullet"]
    mimics = [finding.element for finding in pybullet.findings if "relations" in finding.message]
    assert mimics == ['mimic of joint "hand_joint"', 'mimic of joint "shut"']
    assert f"{urdf.name}: left out by pybullet" not in checks
    assert named(checks["scene.xml: left out by mjx"]) == ["noslip iterations"]
