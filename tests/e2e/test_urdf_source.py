"""A URDF as the source of a build, through the real command."""

import sys

import pytest
import trimesh

from tests.support.command import called, linkwright, robot_files, run_in

TENSOR = 'ixx="0.02" ixy="0" ixz="0" iyy="0.02" iyz="0" izz="0.01"'
INERTIAL = f'<inertial><mass value="1"/><inertia {TENSOR}/></inertial>'
MESH = '<geometry><mesh filename="package://arm/meshes/a.stl" scale="1 -1 1"/></geometry>'
LINK = f"{INERTIAL}<visual>{MESH}</visual><collision>{MESH}</collision>"
ROBOT = f"""<robot name="arm"><link name="base">{LINK}</link><link name="tip">{LINK}</link>
<joint name="elbow" type="revolute"><parent link="base"/><child link="tip"/><origin xyz="0 0 1"/>
<axis xyz="0 1 0"/><limit lower="-1" upper="1" effort="5" velocity="2"/></joint></robot>"""

SRDF = """<robot name="arm"><group name="whole"><joint name="elbow"/></group>
<group_state name="bent" group="whole"><joint name="elbow" value="0.5"/></group_state></robot>"""


@pytest.fixture
def here(tmp_path):
    (tmp_path / "far" / "meshes").mkdir(parents=True)
    trimesh.creation.box((0.1, 0.2, 0.4)).export(tmp_path / "far" / "meshes" / "a.stl")
    (tmp_path / "arm.urdf").write_text(ROBOT)
    (tmp_path / "arm.srdf").write_text(SRDF)
    return tmp_path


def source(**more):
    keys = {"path": "arm.urdf", "packages": "{arm: far}", **more}
    return ["source=urdf", *(f"source.{key}={value}" for key, value in keys.items())]


@pytest.mark.slow
def test_a_robot_is_built_and_its_bundle_builds_the_same_elsewhere(here):
    linkwright(here, *source(), status=0)
    linkwright(here, "bundle", "arm", "arm.zip", status=0)
    there = here / "there"
    there.mkdir()
    (here / "arm.zip").rename(there / "arm.zip")
    linkwright(there, "source=bundle", "source.path=arm.zip", status=0)
    files = robot_files(here / "outputs" / "arm")
    assert robot_files(there / "outputs" / "arm") == files
    assert b'<group_state name="bent" group="whole">' in files["arm.srdf"]
    written = [*files.values(), *(path.read_bytes() for path in (here / "outputs").rglob("report.*"))]
    assert not [data for data in written if str(here).encode() in data]


def test_unchanged_file_is_cached_without_heavy_imports(here):
    called(here, *source(), status=0)
    code = (
        "import sys; from linkwright.pipeline.cli import run; assert run(sys.argv[1:]) == 0\n"
        "heavy = 'numpy scipy trimesh mujoco networkx lxml collada xacro'.split()\n"
        "print('heavy:', [name for name in heavy if name in sys.modules])"
    )
    done = run_in(here, sys.executable, "-c", code, *source())
    assert "heavy: []" in done.stdout
    assert done.stderr.count("(cached)") == 5
    trimesh.creation.box((0.2, 0.2, 0.4)).export(here / "far" / "meshes" / "a.stl")
    assert called(here, *source()).stderr.count("(cached)") < 5
    (here / "arm.srdf").write_text(SRDF.replace("0.5", "0.75"))
    assert called(here, *source()).stderr.count("(cached)") < 5
