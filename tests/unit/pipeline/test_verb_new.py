"""`linkwright new`: the file of a new robot, which builds as it is or says why not."""

import json
import re

import pytest
import yaml

from tests.fake_onshape import solids
from tests.fake_onshape.document import Document
from tests.fake_onshape.frames import frame
from tests.fake_onshape.sample import sample_document
from tests.fake_onshape.server import OnshapeServer
from tests.support.command import called, environment
from tests.support.kit import Kit, four_bar, hinged
from tests.support.mjcfs import body, model
from tests.support.users import URL

pytestmark = pytest.mark.e2e


def asked(here, server, *arguments, status=0):
    """`linkwright` with the server's key, in a folder."""
    environ = environment(here, seeded=False, **server.environ)
    return called(here, *arguments, environ=environ, status=status)


def text_of(here, name):
    return (here / "robot" / f"{name}.yaml").read_text(encoding="utf-8")


def uncommented(text):
    """The text with every line that is YAML behind a # as YAML."""
    return re.sub(r"(?m)^( *)#(?=[^ #\n])", r"\1", text)


def codes_in(text):
    """The codes of the problems that a robot's file names."""
    return re.findall(r"^# - (E-[A-Z-]+)", text, re.MULTILINE)


def codes_of(here, server, name):
    """The codes of the problems with which the build of a robot ends."""
    done = asked(here, server, f"robot={name}", "until=graph", status=None)
    return re.findall(r"^ *(E-[A-Z-]+)", done.stderr, re.MULTILINE)


def loose():
    kit = Kit()
    hinged(kit)
    kit.place("Screw")
    return kit.document


def without_material():
    """A fixed base, and two arms of which one has no material."""
    document = Document("Bare")
    studio = document.studio("Parts")
    bars = [
        studio.part(name, solids.box(0.02, 0.03, 0.1), density=d)
        for name, d in (("Base", 900), ("Arm", None))
    ]
    robot = document.assembly("Robot")
    base, arm = robot.add(bars[0], fixed=True), robot.add(bars[1])
    robot.revolute("Elbow", (arm, frame()), (base, frame((0, 0, 0.1))), limits=(-1, 1))
    return document


def by_itself():
    kit = Kit()
    kit.place("Base", fixed=True)
    kit.place("Other")
    return kit.document


def linkage():
    kit = Kit()
    four_bar(kit)
    return kit.document


def test_an_assembly_costs_one_call_however_often_it_changes(tmp_path):
    with OnshapeServer(sample_document()) as server:
        for name in ("first", "again"):
            asked(tmp_path, server, "new", server.document_url(), name)
        edited = sample_document()
        edited.changed()
        server.edit(edited)
        done = asked(tmp_path, server, "new", server.document_url(), "edited")
        assert [path.partition("?")[0].count("/assemblies/") for _, path, _ in server.calls] == [1, 1, 1]
        server.reset()
        for name in ("version", "version_again"):
            asked(tmp_path, server, "new", server.document_url("v"), name)
        assert server.count == 1, "a version stays as it is"
    assert "1 API call" in done.stdout
    assert text_of(tmp_path, "first").replace("first", "again") == text_of(tmp_path, "again")


def test_masses_cost_a_call_for_each_part_studio(tmp_path):
    with OnshapeServer(sample_document()) as server:
        asked(tmp_path, server, "new", "--deep", server.document_url(), "arm")
        assert server.count == 5
        server.reset()
        asked(tmp_path, server, "robot=arm", "until=graph")
        assert not any("massproperties" in path for _, path, _ in server.calls)


@pytest.mark.parametrize("document", [loose, linkage], ids=lambda make: make.__name__)
def test_the_file_names_the_problems_of_its_build(tmp_path, document):
    with OnshapeServer(document()) as server:
        asked(tmp_path, server, "new", server.document_url(), "arm")
        assert codes_of(tmp_path, server, "arm") == codes_in(text_of(tmp_path, "arm"))


def test_an_error_without_a_code_is_named_too(tmp_path):
    with OnshapeServer(by_itself()) as server:
        asked(tmp_path, server, "new", server.document_url(), "arm")
        done = asked(tmp_path, server, "robot=arm", "until=graph", status=1)
    text = "the assembly has no mates: nothing connects its parts"
    assert text in done.stderr
    assert re.search(rf"^# - error \w+: {text}$", text_of(tmp_path, "arm"), re.MULTILINE)


def test_parts_without_material_are_found_by_deep(tmp_path):
    with OnshapeServer(without_material()) as server:
        asked(tmp_path, server, "new", server.document_url(), "shallow")
        done = asked(tmp_path, server, "new", "--deep", server.document_url(), "deep")
        assert codes_in(text_of(tmp_path, "shallow")) == []
        assert "E-MASS" in text_of(tmp_path, "shallow")
        assert codes_in(text_of(tmp_path, "deep")) == ["E-MASS"] == codes_of(tmp_path, server, "deep")
        assert "E-MASS Arm <1>: the part has no mass" in done.stdout


@pytest.mark.parametrize(
    "document", [sample_document, loose, without_material, linkage], ids=lambda make: make.__name__
)
def test_every_line_to_fill_in_works(tmp_path, document):
    with OnshapeServer(document()) as server:
        asked(tmp_path, server, "new", "--deep", server.document_url(), "arm")
        text = text_of(tmp_path, "arm")
        (tmp_path / "robot" / "arm.yaml").write_text(uncommented(text), encoding="utf-8")
        assert uncommented(text) != text
        asked(tmp_path, server, "robot=arm", "until=graph")
    effort = yaml.safe_load(uncommented(text))["joints"]
    assert all(values for values in effort.values())


def test_limits_that_the_definition_lacks_are_left_to_the_build(tmp_path):
    with OnshapeServer(sample_document(), newest=16) as server:
        asked(tmp_path, server, "new", server.document_url(), "arm")
        assert server.count == 1
    text = text_of(tmp_path, "arm")
    assert "elbow               revolute   no limits (not in the definition: a build asks for them)" in text
    assert "limits:" not in uncommented(text)


def test_no_file_is_replaced_and_no_call_is_made_for_that(tmp_path):
    with OnshapeServer(sample_document()) as server:
        asked(tmp_path, server, "new", server.document_url(), "arm")
        (tmp_path / "robot" / "arm.yaml").write_text("mine", encoding="utf-8")
        done = asked(tmp_path, server, "new", server.document_url(), "arm", status=2)
        assert server.count == 1
    assert text_of(tmp_path, "arm") == "mine"
    assert "robot/arm.yaml: there is a robot of this name already, and no file is replaced" in done.stderr
    assert " arm_2, or remove robot/arm.yaml" in done.stderr


def test_json_has_the_joints_and_the_calls_and_no_key(tmp_path):
    with OnshapeServer(loose(), keys=("acc-distinct", "sec-distinct")) as server:
        done = asked(tmp_path, server, "new", "--json", server.document_url(), "arm")
        unnamed = asked(tmp_path, server, "new", "--json", server.document_url())
    assert "distinct" not in text_of(tmp_path, "arm") + done.stdout + done.stderr
    element = server.document_url().rpartition("/")[2]
    assert json.loads(unnamed.stdout)["path"] == f"robot/onshape_{element[:8]}.yaml"
    result = json.loads(done.stdout)
    assert {key: result[key] for key in ("format", "version", "path", "name", "weighed", "calls")} == {
        "format": "linkwright-new",
        "version": 1,
        "path": "robot/arm.yaml",
        "name": "arm",
        "weighed": False,
        "calls": {"made": 1, "saved": 0},
    }
    assert result["source"] == {"kind": "onshape", "url": server.document_url()}
    assert result["joints"] == [
        {"name": "elbow", "type": "revolute", "unit": "rad", "lower": -1.0, "upper": 1.0, "follows": "",
         "loop": False, "missing": {"effort": 10, "velocity": 3}},
    ]  # fmt: skip
    assert [(problem["code"], problem["where"]) for problem in result["problems"]] == [
        ("E-LOOSE", "Screw <1>")
    ]


def test_a_folder_of_robots_may_be_named(tmp_path):
    (tmp_path / "mine").mkdir()
    (tmp_path / "arm.xml").write_text(model(body("arm", '<joint name="hip"/>')), encoding="utf-8")
    done = called(tmp_path, "new", "--config-dir", "mine", "arm.xml", status=0)
    assert "linkwright --config-dir mine robot=arm" in done.stdout
    called(tmp_path, "--config-dir", "mine", "robot=arm", "until=graph", status=0)


@pytest.mark.parametrize(("arguments", "status", "message"), [
    ([], 2, "expected an address or a file, and perhaps a name; got 0 arguments"),
    (["a", "b", "c"], 2, "got 3 arguments"),
    (["--fast", URL], 2, "there is no option --fast"),
    (["--config-dir"], 2, "--config-dir needs a folder"),
    (["--config-dir", "none", URL], 2, "there is no folder none"),
    ([URL], 2, "ONSHAPE_ACCESS_KEY"),
    ([URL, "my arm"], 2, "a robot's name has letters, digits, _ and - only, got 'my arm'"),
    ([URL, "My Arm!"], 2, "→ for example my_arm"),
    ([URL, "sample"], 2, "'sample' is the name of a robot or file of Linkwright"),
    ([URL.rpartition("/e/")[0]], 2, "it names a document, but no tab of it"),
    (["https://a-key:a-secret@cad.onshape.com/documents"], 2, "must not contain a user name or password"),
    (["gone.urdf"], 2, "gone.urdf does not exist"),
    (["notes.txt"], 2, "notes.txt: it is neither a URDF, an MJCF (MuJoCo XML) nor a bundle (zip)"),
    (["broken.urdf"], 1, "broken.urdf"),
    (["arm.urdf.xacro"], 2, "source.trust"),
])  # fmt: skip
def test_a_wrong_argument_writes_nothing(tmp_path, arguments, status, message):
    files = {"notes.txt": "an arm", "broken.urdf": "<robot><link", "arm.urdf.xacro": "<robot/>"}
    for name, text in files.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    done = called(tmp_path, "new", *arguments, status=status)
    assert message in done.stderr
    assert done.stderr.startswith("error: ")
    assert "a-secret" not in done.stderr
    assert not (tmp_path / "robot").exists()


@pytest.mark.parametrize("element", ["a part studio", "nothing"])
def test_an_address_without_an_assembly_is_an_error(tmp_path, element):
    document = sample_document()
    identity = document.studios[0].element if element == "a part studio" else "0" * 24
    with OnshapeServer(document) as server:
        done = asked(tmp_path, server, "new", server.document_url(element=identity), "arm", status=1)
    assert "assembly" in done.stderr.partition("error: ")[2]
    assert not (tmp_path / "robot").exists()


URDF = """<robot name="r"><link name="base">{mass}</link>{more}</robot>"""
MASS = '<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>'


def urdf(*links, kind="revolute"):
    """A base with links on hinges."""
    joints = "".join(
        f'<link name="{link}">{MASS}</link><joint name="to_{link}" type="{kind}"><parent link="base"/>'
        f'<child link="{link}"/><axis xyz="0 0 1"/>'
        '<limit lower="-1" upper="1" effort="3" velocity="2"/></joint>'
        for link in links
    )
    return URDF.format(mass=MASS, more=joints)


@pytest.mark.parametrize(("text", "file", "holds", "lacks"), [
    (urdf("arm"), "a.urdf", ["override /root: fixed", "override /actuators: position"], ["geoms", "joints:"]),
    (urdf("left_foot", "right_foot"), "a.urdf", ["/robot/legged", '"*": {kp: null, kv: null}'], ["/root"]),
    (urdf("left_foot"), "a.urdf", ["override /root: fixed"], ["legged"]),
    (urdf("left_wheel", kind="continuous"), "a.urdf",
     ["override /root: auto", 'to_left_wheel: {type: "velocity"}'], ["limits: ["]),
    (urdf("spinner", kind="continuous"), "a.urdf", ["#to_spinner: {limits: [-1.57, 1.57]"], ["velocity\"}"]),
    (urdf("left_finger", "jaw"), "a.urdf", ['"*[Ff]inger*": {collision:', '"*[Jj]aw*": {collision:'], []),
    (model(body("foot", '<joint name="hip"/>') + body("foot2", '<joint name="hop"/>')), "a.xml",
     ["override /root: auto", "#hip: {limits: "], ["legged"]),
    (model(body("arm", '<joint name="hip"/>'), '<actuator><motor joint="hip"/></actuator>'), "a.xml",
     ["override /actuators: none"], ["motor:"]),
], ids=["arm", "feet", "foot", "wheel", "endless", "gripper", "mjcf", "motors of an mjcf"])  # fmt: skip
def test_choices_follow_the_source_and_build(tmp_path, text, file, holds, lacks):
    (tmp_path / file).write_text(text, encoding="utf-8")
    called(tmp_path, "new", file, "r", status=0)
    written = text_of(tmp_path, "r")
    assert [part for part in holds if part not in written] == []
    assert [part for part in lacks if part in written] == []
    called(tmp_path, "robot=r", "until=graph", status=0)
    (tmp_path / "robot" / "r.yaml").write_text(uncommented(written), encoding="utf-8")
    called(tmp_path, "robot=r", "until=graph", status=0)
