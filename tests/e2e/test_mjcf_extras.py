"""What only an MJCF has: the configuration's word on it, its record in robot.json, and its check."""

import json

import mujoco
import pytest

from linkwright.stages.formats.described import read_robot_json
from linkwright.stages.formats.robot_json.codec import RobotJsonError
from linkwright.stages.robot import codec
from linkwright.stages.validate import validate
from tests.e2e.test_mjcf_motion import BITS, CASES, LOOSE
from tests.support.building import plan_of
from tests.support.command import called
from tests.support.mjcfs import built, model, written

pytestmark = [pytest.mark.slow, pytest.mark.usefixtures("guests_at_home", "no_score")]


def scene(folder, world, more="", **keys):
    """The compiled scene of what is made of a file, all of whose checks pass and of which nothing is lost."""
    reported, failed = built(written(folder, model(world, more)), folder / "out", **keys)
    assert not failed
    assert not [problem.message for problem in reported if problem.code == "W-MJCF-LEFT"]
    return mujoco.MjModel.from_xml_path(str(folder / "out/scene.xml"))


def test_configured_cameras_and_lights_replace_those_of_the_file(tmp_path):
    cameras = {"front": {"xyz": [1, 2, 3]}, "wrist": {"frame": "palm", "fovy": 50}}
    lights = {"sun": {"kind": "spot", "xyz": [0, 0, 9]}, "lamp": {"kind": "none"}}
    made = scene(tmp_path, LOOSE, scene={"cameras": cameras, "lights": lights})
    assert made.camera("front").pos == pytest.approx([1, 2, 3])
    assert made.camera("wrist").fovy == pytest.approx([50])
    assert made.light("sun").pos == pytest.approx([0, 0, 9])
    assert made.nlight == 1


def test_surroundings_of_the_file_are_left_out_if_asked(tmp_path):
    keys = {"scene": {"surroundings": "drop"}, "ground": {"kind": "plane"}}
    made = scene(tmp_path, *CASES["loose"], **keys)
    assert [made.body(body).name for body in range(made.nbody)] == ["world", "arm"]
    assert made.geom("floor").friction == pytest.approx([1, 0.005, 0.0001])


def test_for_mjx_an_ellipsoid_is_its_hull(tmp_path):
    """MJX collides no ellipsoid with a mesh or a box."""
    kinds = {}
    for target in ("mujoco", "mjx"):
        folder = tmp_path / target
        folder.mkdir()
        made = scene(folder, *CASES["ellipsoids"], mesh={"collider": "raw"}, target={target: {}})
        kinds[target] = {int(made.geom(name).type[0]) for name in ("egg", "foot")}
    ellipsoid, mesh = int(mujoco.mjtGeom.mjGEOM_ELLIPSOID), int(mujoco.mjtGeom.mjGEOM_MESH)
    assert kinds == {"mujoco": {ellipsoid}, "mjx": {mesh}}


def test_a_pair_of_links_that_the_user_excludes_does_not_collide(tmp_path):
    """A pair of an MJCF collides whatever its bodies say."""
    more = '<contact><pair geom1="a" geom2="d"/></contact>'
    assert scene(tmp_path, BITS, more).npair == 1
    made = scene(tmp_path, BITS, more, contact={"self": "auto", "exclude": [["base", "d"]]})
    assert made.npair == 0
    assert made.nexclude == 1


def test_a_floor_of_the_file_that_is_only_seen_keeps_its_name(tmp_path):
    """The ground has another then, and is found in its place."""
    world = LOOSE.replace('friction=".7 .01 .001" solref=".01 1"', 'contype="0" conaffinity="0"')
    made = scene(tmp_path, world, ground={"kind": "plane"})
    assert (made.geom("floor").contype[0], made.geom("floor_2").contype[0]) == (0, 1)


FIXED = """<body name="torso"><geom name="trunk" size="0.2"/>
  <body name="plate" pos="0 0 0.3"><geom name="top" size="0.1"/>
    <body name="arm" pos="0 0 0.05"><joint name="turn" axis="1 0 0"/><geom name="upper" size="0.1"/></body>
  </body></body>"""


@pytest.mark.parametrize("joints", ["auto", "merge"])
def test_an_exclude_is_of_the_shapes_of_its_own_body(joints, tmp_path):
    """A link that is fixed to that body does not become part of it: it may collide."""
    more = '<contact><exclude body1="torso" body2="arm"/></contact>'
    made = scene(tmp_path, FIXED, more, export={"urdf": {}, "mjcf": {"fixed_joints": joints}})
    assert made.body(made.geom("top").bodyid[0]).name == "plate"
    data = mujoco.MjData(made)
    mujoco.mj_forward(made, data)
    touching = {frozenset(made.geom(geom).name for geom in pair) for pair in data.contact.geom}
    assert frozenset(("top", "upper")) in touching


def test_the_presets_keep_the_bodies_of_an_mjcf(tmp_path):
    path = written(tmp_path, model(FIXED))
    called(
        tmp_path, "source=mjcf", f"source.path={path}", "mesh=raw", "validate=quick", "output=out", status=0
    )
    made = mujoco.MjModel.from_xml_path(str(tmp_path / "out" / f"{path.stem}.xml"))
    assert [made.body(body).name for body in range(made.nbody)] == ["world", "torso", "plate", "arm"]


@pytest.mark.parametrize("case", CASES)
def test_robot_json_has_all_that_checks_need_also_from_the_cache(case, tmp_path):
    built(written(tmp_path, model(*CASES[case])), tmp_path / "out")
    truth = read_robot_json((tmp_path / "out/robot.json").read_bytes())
    assert truth.written.robot.mjcf is not None
    checks = validate(tmp_path / "out", truth.written, plan_of())
    assert not [(check.name, check.detail) for check in checks if check.fails]
    data = codec.encode_robot(truth.written.robot)
    assert codec.encode_robot(codec.decode_robot(data)) == data


def test_the_record_of_an_mjcf_names_what_is_wrong_with_it(tmp_path):
    """Each text, number and list of the table in turn is of another kind."""
    built(written(tmp_path, model(*CASES["tendons"])), tmp_path / "out")
    data = json.loads((tmp_path / "out/robot.json").read_bytes())
    places = [
        *(("bodies", 0, key) for key in ("link", "pose")),
        *(("mounted", 0, key) for key in ("link", "pose", "element") if data["mjcf"]["mounted"]),
        *(("sections", 0, key) for key in ("tag", "attributes", "names", "children")),
        *(("sections", 0, "children", 0, key) for key in ("tag", "names")),
        *(("order", "sensor"), ("scene_qpos",), ("has_ground",), ("flag",)),
    ]
    for place in places:
        changed = json.loads(json.dumps(data))
        table = changed["mjcf"]
        for key in place[:-1]:
            table = table[key]
        table[place[-1]] = 1.5
        with pytest.raises(RobotJsonError, match=str(place[-1])):
            read_robot_json(json.dumps(changed).encode())


FAULTS = {
    "a stiffer tendon": ("tendons", 'stiffness="60"', 'stiffness="61"'),
    "another gear": ("tendons", 'gear="3', 'gear="4'),
    "another path": ("tendons", 'sidesite="over"', 'sidesite="end"'),
    "a sensor of another body": ("tendons", 'objtype="xbody"', 'objtype="body"'),
    "a stiffer spring": ("springs", 'stiffness="3"', 'stiffness="4"'),
    "a softer limit": ("springs", 'solimplimit="0.8', 'solimplimit="0.7'),
    "another geom": ("loose", 'name="beam"', 'name="boom"'),
    "a camera that is elsewhere": ("loose", '<camera name="wrist"', '<camera name="wrist" mode="track"'),
    "a pair that is rougher": ("bits", 'friction="0.5', 'friction="0.6'),
    "a curve": ("ties", 'polycoef="0 0.5 0.3', 'polycoef="0 0.5 0.4'),
    "a loop that is softer": ("ties", 'solref="0.04 0.9"', 'solref="0.05 0.9"'),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_a_change_of_what_only_an_mjcf_has_is_found(fault, tmp_path):
    case, text, changed = FAULTS[fault]
    folder = tmp_path / "out"
    built(written(tmp_path, model(*CASES[case])), folder)
    truth = read_robot_json((folder / "robot.json").read_bytes())
    file = folder / f"{truth.written.robot.name}.xml"
    assert text in file.read_text()
    file.write_text(file.read_text().replace(text, changed, 1))
    checks = validate(folder, truth.written, plan_of())
    assert [check.name for check in checks if check.fails]


@pytest.mark.parametrize(
    ("case", "words"),
    [
        ("springs", ("springs: ball, slide, swing",)),
        ("ellipsoids", ("ellipsoids (hulls in the others): leg, trunk",)),
        ("tendons", ("tendons: both, cord", "actuators that do not drive a single joint: pull, twist")),
        ("loose", ("cameras and lights: lamp, wrist", "bodies beside the robot: ball, door, target")),
        ("ties", ("equalities: curve",)),
    ],
)
def test_what_other_formats_cannot_have_is_named(case, words, tmp_path):
    path = written(tmp_path, model(*CASES[case]))
    single, _ = built(path, tmp_path / "alone")
    assert "I-MJCF-ONLY" not in {problem.code for problem in single}
    reported, _ = built(path, tmp_path / "out", export={"mjcf": {}, "urdf": {}})
    (text,) = (problem.message for problem in reported if problem.code == "I-MJCF-ONLY")
    assert text.startswith("URDF cannot have")
    assert all(word in text for word in words), text
