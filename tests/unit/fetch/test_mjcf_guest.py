"""A foreign MJCF is compiled by a guest: the same model, within bounds, and one message whatever happens."""

import json

import pytest

from linkwright.stages.fetch.mjcf import gather
from linkwright.stages.fetch.mjcf.section import MjcfSourceSection
from linkwright.stages.formats.mjcf import bounds as mjcf_bounds
from linkwright.stages.graph import build_robot
from linkwright.stages.robot.errors import ProtocolError, SourceError
from linkwright.stages.robot.system import guest
from linkwright.stages.robot.system.guest import Bounds, Ended
from tests.support.building import plan_of
from tests.support.mjcfs import at_home, body, bundle_of, model, robot_of, written
from tests.unit.fetch.test_urdf_files import block

BOX = '<mesh name="box" vertex="0 0 0 1 0 0 0 1 0 0 0 1"/>'
MESHED = model(body("a", '<geom type="mesh" mesh="box"/><joint name="j"/>'), f"<asset>{BOX}</asset>")


def refused(path):
    with pytest.raises(SourceError) as caught:
        gather.gather(MjcfSourceSection(path=str(path)))
    assert str(path.parent) not in str(caught.value)
    return caught.value


def test_a_guest_makes_the_bundle_that_we_would(tmp_path, monkeypatch):
    path = written(tmp_path, MESHED)
    (tmp_path / "mujoco.py").write_text("raise SystemExit(9)")
    monkeypatch.chdir(tmp_path)
    made = bundle_of(path)
    monkeypatch.setattr(guest, "ask", at_home)
    assert made == bundle_of(path)
    assert len(made.requests) == 2


def test_a_crash_of_the_compiler_is_one_message(tmp_path):
    attach = '<worldbody><body><attach model="m" prefix="a"/></body></worldbody>'
    asset = '<asset><model name="m" file="model.xml"/></asset>'
    error = refused(written(tmp_path, f"<mujoco>{asset}{attach}</mujoco>"))
    assert "MuJoCo's compiler crashed (SIG" in error.message or "refuses it" in error.message
    assert "names itself" in error.hint or "MuJoCo's own" in error.hint


def test_bounds_hold(tmp_path, monkeypatch):
    for bounds, words in (
        (Bounds(0.001, 4 << 30, 1 << 30), "took longer"),
        (Bounds(60, 1 << 20, 1 << 30), "needed more than 0.00105 GB"),
        (Bounds(60, 4 << 30, 100), "made more than"),
    ):
        monkeypatch.setattr(gather, "BOUNDS", bounds)
        assert f"MuJoCo's compiler {words}" in refused(written(tmp_path, MESHED)).message


@pytest.mark.parametrize(
    "reply",
    [
        b"",
        b"[]\n",
        b'{"warnings": 1, "model": 0, "meshes": [], "images": []}\n',
        b'{"warnings": [], "model": 0, "meshes": [["../x", 0]], "images": []}\n',
        b'{"warnings": [], "model": 0, "meshes": [["x", 3]], "images": []}\nabc',
        b'{"warnings": [], "model": 0, "meshes": []}\n',
        b'{"warnings": [], "model": 0, "meshes": [], "images": [3]}\nabc',
        b'{"warnings": [], "model": "x", "meshes": [], "images": []}\n',
        b"[" * 100_000,
    ],
)
def test_a_guests_reply_is_not_taken_on_trust(tmp_path, monkeypatch, reply):
    monkeypatch.setattr(guest, "ask", lambda *_: reply)
    assert "does not answer with a model" in refused(written(tmp_path, MESHED)).message


# What a few bytes ask for.

MANY = "9" * 400


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (model('<replicate count="30000"><body/></replicate>'), "come to 30000 elements"),
        (model('<replicate count="101"><replicate count="100"><geom/></replicate></replicate>'), "come to"),
        (model('<replicate count="2">' + "<geom/>" * 6000 + "</replicate>"), "come to 10002 elements"),
        (model(f'<replicate count="{MANY}"/>'), "come to inf"),
        (model('<body><composite type="cable" count="100000 1 1"/></body>'), "<composite>"),
        (model('<body><flexcomp type="grid" count="30 30 30"/></body>'), "come to 27000 elements"),
        (model('<body><composite type="cable" count="9000 1 1"/></body>' * 2), "come to 18000 elements"),
        (model("", '<size nkey="2000000000"/>'), "<size nkey> is 2000000000; at most 10000"),
        (model("", '<size nuser_body="20000"/>'), "<size nuser_body> is 20000"),
        (model("", '<size nuserdata="20000"/>'), "<size nuserdata> is 20000"),
        (model("", '<sensor><user dim="2000000000"/></sensor>'), "<user dim> is 2000000000"),
        (model("", '<actuator><general actdim="20000"/></actuator>'), "<general actdim> is 20000"),
        (model("", '<asset><hfield nrow="60000" ncol="60000"/></asset>'), "<hfield> has 3.6e+09 points"),
        (model("", '<asset><texture width="9000" height="9000"/></asset>'), "<texture> has 8.1e+07 pixels"),
        (model("<body/>" * 20_001), "it has 20001 bodies"),
        (model(f'<body name="{"a" * 1001}"/>'), "the name of a <body> has 1001 letters"),
    ],
)
def test_more_than_a_robot_has_is_refused_before_it_is_compiled(tmp_path, text, said):
    path = written(tmp_path, text)
    with pytest.raises(SourceError) as caught:
        mjcf_bounds.require_within_limits([path])
    assert said in caught.value.message


def test_an_included_file_is_bounded_too(tmp_path):
    written(tmp_path, model('<replicate count="30000"><body/></replicate>'), "inner.xml")
    error = refused(written(tmp_path, model('<include file="inner.xml"/>')))
    assert "come to" in error.message
    assert error.where == "inner.xml"


def test_a_robot_within_bounds_is_let_through(tmp_path):
    sizes = '<size nkey="100" memory="1T" njmax="100000"/><asset><hfield nrow="1000" ncol="1000"/></asset>'
    for text in (
        model('<replicate count="100"><body><geom/></body></replicate>' * 10),
        model("<geom/>" * 20_000),
        model("", sizes),
        model('<replicate count="x"/>'),
        "<mujoco>",
    ):
        path = written(tmp_path, text)
        mjcf_bounds.require_within_limits([path])


def test_bounds_take_time_in_proportion(tmp_path):
    """The guest's own reading of the XML: no element is looked at more often in a longer text."""
    from tests.unit.pipeline.test_scale import FEW, lines_run

    def counted(count):
        path = written(tmp_path, model("<body><geom/></body>" * count))
        return lines_run(lambda: mjcf_bounds.require_within_limits([path]))

    before, after = counted(200), counted(800)
    assert max(after[line] / before[line] for line in after if after[line] > FEW) < 5


def test_warnings_are_reported_in_bounds(tmp_path, monkeypatch):
    head = {"warnings": ["x" * 1000] * 1000, "model": 2, "meshes": [], "images": []}
    monkeypatch.setattr(guest, "ask", lambda *_: json.dumps(head).encode() + b"\n{}")
    _, problems = gather.gather(MjcfSourceSection(path=str(written(tmp_path, MESHED))))
    assert (len(problems), {len(problem.message) for problem in problems}) == (100, {500})


def test_a_guest_that_cannot_start_is_reported(tmp_path, monkeypatch):
    def never(*_):
        raise Ended("could not be started (no memory)")

    monkeypatch.setattr(guest, "ask", never)
    assert "MuJoCo's compiler could not be started" in refused(written(tmp_path, MESHED)).message


def test_work_is_done_while_the_guest_compiles(tmp_path, monkeypatch):
    """The later stages' imports begin once the file is known to be one, before MuJoCo has an answer."""
    order = []
    monkeypatch.setattr(guest, "ask", lambda *asked: order.append("asked") or at_home(*asked))
    gather.gather(MjcfSourceSection(path=str(written(tmp_path, MESHED))), lambda: order.append("meanwhile"))
    assert order == ["meanwhile", "asked"]


@pytest.mark.usefixtures("guests_at_home")
def test_an_attached_model_is_part_of_the_identity(tmp_path):
    (tmp_path / "arm").mkdir()
    (tmp_path / "arm" / "wedge.stl").write_bytes(block())
    asset = '<asset><mesh file="wedge.stl"/></asset>'
    written(tmp_path / "arm", model(body("link", '<geom type="mesh" mesh="wedge"/>'), asset), "arm.xml")
    attached = '<frame pos="0 0 1"><attach model="arm" body="link" prefix="left/"/></frame>'
    path = written(
        tmp_path, model(body("base", attached), '<asset><model name="arm" file="arm/arm.xml"/></asset>')
    )
    assert sorted(gather.identity(keys_of(path))["files"]) == ["arm/arm.xml", "arm/wedge.stl", "model.xml"]
    robot = robot_of(path)
    assert [link.name for link in robot.links] == ["base", "left/link"]
    assert len(robot.links[1].parts) == 1


def keys_of(path):
    return MjcfSourceSection(path=str(path))


@pytest.mark.usefixtures("guests_at_home")
def test_the_identity_is_the_content_of_all_files(tmp_path):
    for folder in ("inc", "assets", "elsewhere"):
        (tmp_path / folder).mkdir()
    (tmp_path / "assets" / "wedge.stl").write_bytes(block())
    (tmp_path / "inc" / "more.xml").write_text('<mujoco><asset><mesh file="wedge.stl"/></asset></mujoco>')
    more = '<include file="inc/more.xml"/><!-- file="x" -->'
    path = written(tmp_path, model(body("b"), more, compiler='meshdir="assets"'))
    first = gather.identity(keys_of(path))
    assert sorted(first["files"]) == ["assets/wedge.stl", "inc/more.xml", "model.xml"]
    assert gather.gather(keys_of(path))[0].root["microversion"]
    with (tmp_path / "inc" / "more.xml").open("a") as file:
        file.write("<!-- a word -->")
    assert gather.identity(keys_of(path)) == first
    (tmp_path / "assets" / "wedge.stl").write_bytes(block() + b"\0")
    assert gather.identity(keys_of(path)) != first


def driven(attributes):
    """A hinge with a position servo with these attributes."""
    servo = f'<actuator><position joint="j" {attributes}/></actuator>'
    return model(body("a", '<joint name="j"/>'), servo)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("hello", "not XML"),
        ("", "not XML"),
        ('<robot name="x"/>', "source=urdf"),
        ("<html/>", "<html>"),
        ("<mujoco><worldbody>", "MuJoCo cannot compile it: XML parse error"),
        ("<mujoco><worldbody/></mujoco>", "no body"),
        ('<mujoco><asset><mesh file="nope.stl"/></asset></mujoco>', "nope.stl"),
        ('<mujoco><include file="nope.xml"/></mujoco>', "nope.xml"),
        ('<mujoco><include file="model.xml"/></mujoco>', "already included"),
        (model(body("a", pos="nan 0 0")), "body_pos"),
        (model(body("a", pos="inf 0 0")), "body_pos"),
        (model(body("a", '<joint stiffness="nan"/>')), "jnt_stiffness"),
        (model(body("a", '<joint springref="nan" stiffness="1"/>')), "qpos_spring"),
        (model(body("a", '<joint actuatorfrcrange="-1 nan" actuatorfrclimited="true"/>')), "jnt_actfrcrange"),
        (driven('kp="nan"'), "actuator_gainprm"),
        (driven('gear="nan"'), "actuator_gear"),
        (driven('forcerange="nan 1" forcelimited="true"'), "actuator_forcerange"),
        (driven('forcerange="-inf inf"'), "actuator_forcerange"),
        (model(body("a", '<geom size="1" friction="nan"/>')), "geom_friction"),
        (model(body("a") + body("a")), "repeated name 'a'"),
        (model("<body><joint/></body>"), "mass and inertia of moving bodies"),
        ("<mujoco><foo/></mujoco>", "foo"),
        ("<mujoco><worldbody>" + "<body>" * 10000 + "</body>" * 10000 + "</worldbody></mujoco>", "too deep"),
        ('<mujoco model="' + "a" * 50_000_000 + '"/>', "longer than"),
        ("<!--" * 100_000, "not XML"),
        ("<mujoco>" + "".join(f'<a file="{i}"/>' for i in range(30_000)), "names more than"),
    ],
)
@pytest.mark.usefixtures("guests_at_home")
def test_a_text_that_is_no_model_is_refused_without_a_path(tmp_path, monkeypatch, text, said):
    monkeypatch.chdir(tmp_path)
    path = written(tmp_path, text)
    with pytest.raises((SourceError, ProtocolError)) as caught:
        build_robot(gather.gather(keys_of(path))[0], plan_of())
    assert said in str(caught.value)
    assert str(tmp_path) not in str(caught.value)
    assert [path.name for path in tmp_path.iterdir()] == ["model.xml"]
