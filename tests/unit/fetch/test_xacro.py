"""xacro: expanded where it is named so and trusted, in a process that knows nothing of ours; else never."""

import re

import pytest

from linkwright.stages.fetch import pinned, preflight
from linkwright.stages.fetch.urdf.gather import gather
from linkwright.stages.fetch.urdf.section import UrdfSourceSection
from linkwright.stages.robot.errors import ConfigError, SourceError
from linkwright.stages.robot.system import guest
from tests.support.building import plan_of
from tests.support.textures import put
from tests.unit.fetch.test_urdf_files import block

XMLNS = b'xmlns:xacro="http://www.ros.org/wiki/xacro"'
XACRO = (
    b"""<robot %s name="r"><xacro:arg name="n" default="x"/>
<xacro:include filename="$(find parts)/part.xacro"/>
<link name="$(arg n)"/><xacro:part mesh="file://$(find parts)/a.stl"/>
<gazebo><config>$(find parts)/c.yaml</config></gazebo></robot>"""
    % XMLNS
)
PART = (
    b"""<robot %s><xacro:include filename="$(find more)/more.xacro"/>
<xacro:macro name="part" params="mesh">
<link name="part"><visual><geometry><mesh filename="${mesh}"/></geometry></visual></link>
</xacro:macro></robot>"""
    % XMLNS
)


def text_of(path, environ=None, **keys):
    """What a trusted xacro file becomes."""
    bundle, _ = gather(UrdfSourceSection(path=str(path), trust=True, **keys), environ or {})
    return bundle.blobs[bundle.definition].decode()


def robot(inside):
    return b'<robot %s name="r">%s</robot>' % (XMLNS, inside.encode())


def made(folder, inside, environ=None, **keys):
    put(folder, **{"r.xacro": robot(inside)})
    return text_of(folder / "r.xacro", environ, **keys)


def refused(folder, inside, **keys):
    with pytest.raises(SourceError) as caught:
        made(folder, inside, **keys)
    assert str(folder) not in str(caught.value)
    return caught.value


@pytest.fixture
def no_guest(monkeypatch):
    def never(*_):
        raise AssertionError("a guest was started")

    monkeypatch.setattr(guest, "ask", never)


def test_a_xacro_is_expanded_with_its_arguments_and_packages(tmp_path):
    put(tmp_path, **{"r.urdf.xacro": XACRO, "p/part.xacro": PART, "p/a.stl": block()})
    put(tmp_path, **{"m/more.xacro": b'<robot %s><link name="more"/></robot>' % XMLNS})
    packages = {"parts": str(tmp_path / "p"), "more": str(tmp_path / "m")}
    text = text_of(tmp_path / "r.urdf.xacro", packages=packages, args={"n": True})
    assert [name in text for name in ('<link name="true"', '"more"', "package://parts/c.yaml")] == [True] * 3
    assert str(tmp_path) not in text


@pytest.mark.usefixtures("no_guest")
def test_a_xacro_without_trust_is_not_run(tmp_path):
    put(tmp_path, **{"r.urdf.xacro": XACRO})
    plan = plan_of(source={"kind": "urdf", "path": str(tmp_path / "r.urdf.xacro")})
    for call in (preflight, pinned, lambda plan, environ: gather(plan.source, environ)):
        with pytest.raises(ConfigError, match="which is a program") as caught:
            call(plan, {})
        assert caught.value.where == "source.trust"
        assert "source.trust=true" in caught.value.hint


def test_a_missing_xacro_is_known_before_any_work(tmp_path, monkeypatch):
    put(tmp_path, **{"r.xacro": XACRO})
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    source = {"kind": "urdf", "path": str(tmp_path / "r.xacro"), "trust": True}
    with pytest.raises(ConfigError, match=re.escape("pip install 'xacro")):
        preflight(plan_of(source=source), {})


@pytest.mark.parametrize(
    ("inside", "said"),
    [
        ('\n<xacro:property name="m" value="1"/>', "line 2: <xacro:property>"),
        ('<link name="a"><xacro:if value="1"/></link>', "<xacro:if>"),
        ('<link name="a" xacro:b="1"/>', 'xacro:b="…"'),
        ('<link name="${a}"/>', "${a}"),
        ('<link name="a"><visual><geometry><mesh filename="$(x)"/></geometry></visual></link>', "$("),
        ("<ros2_control><param>${(lambda: 1)()}</param></ros2_control>", "${(lambda: 1)()}"),
    ],
)
@pytest.mark.usefixtures("no_guest")
def test_a_urdf_with_xacro_is_refused_with_the_way_out(tmp_path, inside, said):
    put(tmp_path, **{"r.urdf": robot(inside)})
    with pytest.raises(SourceError) as caught:
        gather(UrdfSourceSection(path=str(tmp_path / "r.urdf"), trust=True), {})
    assert said in caught.value.message
    assert "xacro FILE > robot.urdf" in caught.value.hint
    assert "r.urdf.xacro" in caught.value.hint


@pytest.mark.usefixtures("no_guest")
def test_xacro_is_known_however_it_is_declared(tmp_path):
    path, link = tmp_path / "r.urdf", b'<link name="a"/></robot>'
    for text in (
        b'<robot name="r"><xacro:property name="m" value="1"/>' + link,
        b'<robot name="r" xmlns:x="http://ros.org/wiki/xacro"><x:property name="m"/>' + link,
        b'<robot name="r" xmlns:xacro="urn:any"><xacro:property name="m"/>' + link,
        b'<robot name="r"><link name="$(env HOME)"/></robot>',
    ):
        path.write_bytes(text)
        with pytest.raises(SourceError, match="is for xacro"):
            gather(UrdfSourceSection(path=str(path)), {})
    for inside in (
        '<link name="a"/>',
        '<link name="a$5"/><!-- <xacro:property/> ${a} -->',
        '<link name="a"/><gazebo><plugin><parameters>$(find p)/c.yaml</parameters></plugin></gazebo>',
    ):
        path.write_bytes(robot(inside))
        bundle, _ = gather(UrdfSourceSection(path=str(path)), {})
        assert b'<link name="a' in bundle.blobs[bundle.definition]


ESCAPED = (
    "${(lambda: [c for c in ().__class__.__base__.__subclasses__() if c.__name__ == '_wrap_close'][0]"
    ".__init__.__globals__['environ'].copy().keys().__repr__())()}"
)
"""The variables of the process, by an expression that gets around xacro's filter."""


def test_a_trusted_xacro_sees_only_the_paths_of_ros(tmp_path, monkeypatch):
    monkeypatch.setenv("ONSHAPE_SECRET_KEY", "very-secret-indeed")
    environ = {"ROS_PACKAGE_PATH": str(tmp_path), "ONSHAPE_SECRET_KEY": "very-secret-indeed", "HOME": "/root"}
    text = made(tmp_path, f'<link name="{ESCAPED}"/>', environ)
    assert "['ROS_PACKAGE_PATH']" in text.replace("&apos;", "'")
    error = refused(tmp_path, '<link name="$(env ONSHAPE_SECRET_KEY)"/>')
    assert "can read only ROS's variables" in error.hint


def test_a_refusal_of_xacro_is_reported_as_ours(tmp_path):
    error = refused(tmp_path, '<link name="$(find parts)"/>')
    assert error.message.startswith("xacro cannot expand it: there is no package parts")
    assert "source.packages={parts: FOLDER}" in error.hint
