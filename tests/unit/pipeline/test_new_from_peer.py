"""`linkwright new --from config.json`: every option of onshape-to-robot becomes a key, or is named."""

import json
import math
from pathlib import Path
from types import SimpleNamespace

import pytest
import yaml
from lxml import etree

from linkwright.pipeline.new_robot.peer_config import PeerConfig, read
from linkwright.pipeline.new_robot.peer_options import CONVERTERS, SOURCE_OPTIONS, converted
from linkwright.pipeline.new_robot.yaml_lines import flow
from linkwright.pipeline.reference.peers import ONSHAPE_TO_ROBOT
from linkwright.stages.robot.text.globs import matches_glob
from tests.fake_onshape.prefixed import prefixed
from tests.fake_onshape.server import OnshapeServer
from tests.support.command import called, environment
from tests.support.users import URL
from tests.unit.pipeline.test_verb_new import text_of, uncommented

pytestmark = pytest.mark.e2e

PROPERTIES = {
    "elbow": {"max_effort": 12, "limits": [-0.2, 1.0], "kp": 30, "forcerange": 5, "class": "soft"},
    "default": {"max_velocity": 3, "frictionloss": 0.05, "damping": 0.1, "armature": 0.01, "kp": 20},
    "*wheel": {"actuated": False, "stiffness": 2},
    "crank": {"type": "motor", "dampratio": 1, "kv": None, "range": False, "limits": [-1, 1]},
    "nothing*": {"damping": 1},
}

MAPPED = {
    "output_format": "mujoco",
    "output_filename": "walker",
    "robot_name": "Walker 2",
    "configuration": "default",
    "ignore_limits": False,
    "ignore": {"plate": "visual", "*a*": "collision", "!arm": "collision", "gone": "all"},
    "joint_properties": PROPERTIES,
    "geom_properties": {"arm": {"friction": 0.9, "rgba": "1 0 0 1"}, "base": {"collision": {"condim": "4"}}},
    "equalities": {"closing_rod*": {"solref": [0.01, 1]}, "gone": {"solref": [0.01, 1]}},
    "additional_xml": ["sensors.xml", "gone.xml"],
    "package_name": "",
    "merge_stls": True,
    "simplify_stls": "visual",
    "max_stl_size": 1,
    "use_fixed_links": False,
    "add_dummy_base_link": True,
    "convex_decomposition": True,
    "no_collision_meshes": False,
    "use_scads": False,
}
"""Options that become keys."""

NAMED = {
    "assembly_name": "Robot", "assets_directory": "meshes", "draw_frames": False, "color": [0.1, 0.2, 0.3],
    "no_dynamics": False, "include_configuration_suffix": True, "round_decimals": 6,
    "post_import_commands": [], "processors": ["ProcessorMergeParts"], "ball_to_euler": True,
    "ball_to_euler_order": "xyz", "pure_shape_dilatation": 0.0, "rainbow_colors": False,
    "collisions_as_visual": False,
    "set_zero_mass_to_fixed": False,
}  # fmt: skip
"""Options that are named with a reason."""

PER_JOINT = {
    *("default", "effort", "max_effort", "max_velocity", "friction", "frictionloss", "damping", "armature"),
    *("stiffness", "limits", "actuated", "type", "kp", "kv", "dampratio", "forcerange", "range", "class"),
}
"""Rows about `joint_properties`."""


def configured(folder, **options):
    (folder / "config.json").write_text(json.dumps(options), encoding="utf-8")
    return folder / "config.json"


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    """A folder with the robot of a configuration with all options, whose build was tried; its file, and the
    result of the verb."""
    here = tmp_path_factory.mktemp("peer")
    (here / "sensors.xml").write_text("<custom><numeric name='n' data='1'/></custom>", encoding="utf-8")
    with OnshapeServer(prefixed()) as server:
        configured(here, url=server.document_url(), **MAPPED, **NAMED, wheels=4)
        environ = environment(here, seeded=False, **server.environ)
        done = called(here, "new", "--from", "config.json", "--json", environ=environ, status=0)
        assert server.count == 1
        # Long enough to meet every name in the file: the globs of `geoms`, `ignore` and `elements`.
        called(here, "robot=Walker_2", "mesh=visual", "until=export", environ=environ, status=0)
        filled = uncommented(text_of(here, "Walker_2"))
        (here / "robot" / "filled.yaml").write_text(filled, encoding="utf-8")
        called(here, "robot=filled", "until=graph", environ=environ, status=0)
        xml = etree.parse(here / "outputs" / "Walker_2" / "Walker_2.xml")
    return yaml.safe_load(text_of(here, "Walker_2")), json.loads(done.stdout), xml


def test_every_option_is_a_key_or_has_a_reason():
    options = {name for name in ONSHAPE_TO_ROBOT if name.islower() and name.isidentifier()}
    options -= PER_JOINT | {"wheel", "continuous", "_inv", "_inverted"}
    assert options == {*SOURCE_OPTIONS, *CONVERTERS, *NAMED}
    assert {*CONVERTERS, *SOURCE_OPTIONS[5:]} == {*MAPPED}
    assert all(ONSHAPE_TO_ROBOT[name].note for name in NAMED)


def test_options_and_properties_of_joints_become_keys(written):
    tree, _, xml = written
    assert tree["conventions"] == "onshape_to_robot"
    assert {"override /export": "mjcf"} in [
        {key: value for key, value in entry.items() if "export" in key} for entry in tree["defaults"]
    ]
    assert {"override /mesh": "coacd"} in tree["defaults"]
    assert {"override /root": "auto"} in tree["defaults"]
    assert tree["mesh"] == {"visual": {"merge": "colour", "max_faces": 20000}}
    assert tree["ignore"]["visual"] == ["Plate"]
    assert tree["ignore"]["collision"] == ["Base", "Camera", "Crank", "Forearm", "Palm", "Plate"]
    assert tree["attributes"]["closing_rod"] == {"solref": [0.01, 1]}
    assert tree["geoms"]["Base"] == {"collision": {"condim": 4}}
    assert tree["geoms"]["Arm"]["collision"] == {"friction": [0.9, 0.005, 0.0001]}
    assert tree["elements"]["additional_1"]["into"] == {"tag": "mujoco"}
    assert tree["links"] == {"base_link": {"child": "base"}}
    assert tree["joints"]["*"] == {"velocity": 3, "friction": 0.05, "damping": 0.1, "armature": 0.01}
    assert tree["joints"]["elbow"]["effort"] == 12
    assert tree["actuators"]["elbow"] == {"kp": 30, "forcerange": [-5, 5]}
    assert tree["actuators"]["left_wheel"] == "none"
    assert tree["actuators"]["crank"] == {"type": "motor"}
    assert tree["attributes"]["left_wheel"] == {"stiffness": 2}
    # Limits count from the saved pose, as there.
    for name, limits in (("elbow", [-0.2, 1.0]), ("crank", [-1.0, 1.0])):
        (joint,) = xml.findall(f".//joint[@name='{name}'][@range]")
        assert [float(end) for end in joint.get("range").split()] == pytest.approx(limits)


def test_what_is_left_out_is_named(written):
    _, result, _ = written
    named = {remark.partition(":")[0] for remark in result["remarks"]}
    assert {*NAMED, "wheels"} <= named
    for part in (
        "ignore: no part matches 'gone'",
        "joint_properties: no joint matches 'nothing*'",
        "class of 'elbow'",
        "range of 'crank'",
        "kp, dampratio of 'crank'",
        "rgba of 'arm' (collision)",
        "equalities: no loop matches 'gone'",
        "gone.xml: there is no such file",
        "wheels: onshape-to-robot has no such option",
    ):
        assert any(part in remark for remark in result["remarks"]), part


@pytest.mark.parametrize(("text", "source"), [
    (f'{{"url": "{URL}"}}', {"url": URL}),
    (f'// the arm\n{{"url": "{URL}", /* long */ # short\n "configuration": "a=1;b=true",}}',
     {"url": URL, "configuration": {"a": "1", "b": "true"}}),
    ('{"documentId": "d", "workspaceId": "w", "elementId": "e", "configuration": {"a": 1}}',
     {"url": "https://cad.onshape.com/documents/d/w/w/e/e", "configuration": {"a": 1}}),
    ('{"document_id": "d", "version_id": "v", "element_id": "e"}',
     {"url": "https://cad.onshape.com/documents/d/v/v/e/e"}),
])  # fmt: skip
def test_the_source_is_read_in_every_form(tmp_path, text, source):
    (tmp_path / "config.json").write_text(text, encoding="utf-8")
    for place in (tmp_path, tmp_path / "config.json"):
        assert read(str(place)).source() == {"kind": "onshape", **source}


@pytest.mark.parametrize(("text", "message"), [
    ("{", "config.json: it cannot be read as JSON with comments"),
    ("[]", "config.json: it is not a mapping of options"),
    ('{"document_id": "d"}', "it has neither url nor all of document_id, workspace_id or "),
    (None, "config.json does not exist"),
])  # fmt: skip
def test_a_wrong_configuration_is_an_error(tmp_path, text, message):
    if text is not None:
        (tmp_path / "config.json").write_text(text, encoding="utf-8")
    done = called(tmp_path, "new", "--from", "config.json", status=2)
    assert message in done.stderr
    assert not (tmp_path / "robot").exists()


@pytest.mark.parametrize(("options", "name"), [
    ({"robot_name": "my robot"}, "my_robot"), ({"output_filename": "duck"}, "duck"),
    ({"output_filename": "robot"}, "arms"), ({}, "arms"),
])  # fmt: skip
def test_the_name_is_that_of_the_other_tool(tmp_path, options, name):
    folder = tmp_path / "arms"
    folder.mkdir()
    assert read(str(configured(folder, **options))).name == name


def conversion_of(**options):
    names = ("left_knee", "right_knee")
    rows = [SimpleNamespace(name=name, loop=False, is_drivable=True) for name in names]
    value = SimpleNamespace(to_mate=float)
    dofs = [SimpleNamespace(name=name, kind="turn", mate_value=value) for name in names]
    config = PeerConfig("config.json", options, Path())
    return converted(config, SimpleNamespace(dofs=dofs, loops=()), rows).keys["joints"]


def test_a_later_entry_of_a_joint_wins_over_all_before_it():
    properties = {
        "default": {"damping": 0.1}, "*knee": {"limits": [-1, 1]}, "left_*": {"max_effort": 5},
        "left_knee": {"max_effort": 20}, "*": {"damping": 0.3},
    }  # fmt: skip
    joints = conversion_of(joint_properties=properties)
    for name, effort in (("left_knee", 20), ("right_knee", None)):
        values = {}
        for glob, entry in joints.items():
            values |= entry if matches_glob(name, glob) else {}
        assert values.get("effort") == effort
        assert (values["damping"], values["limits"]) == (0.3, [-1, 1])


@pytest.mark.parametrize("is_last", [True, False])
def test_ignored_limits_leave_other_properties_of_joints(is_last):
    options = {"ignore_limits": True}
    properties = {"joint_properties": {"default": {"damping": 0.1}, "left_knee": {"limits": [-1, 1]}}}
    joints = conversion_of(**(properties | options if is_last else options | properties))
    assert joints["*"] == {"limits": [None, None], "damping": 0.1}
    assert joints["left_knee"] == {"limits": [-1, 1]}
    assert next(iter(joints)) == "*"


@pytest.mark.parametrize("number", [1e-05, 1.5e-07, -2e22, 0.25, 3.0, math.inf, -math.inf])
def test_a_number_is_read_as_a_number(number):
    assert yaml.safe_load(flow({"armature": number})) == {"armature": number}
