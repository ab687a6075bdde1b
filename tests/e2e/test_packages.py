"""The packages of whole robots as their users take them: the ROS 2 package, and what pip installs."""

import json
import shlex
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest
import yaml
from lxml import etree

from linkwright.pipeline.checking.run import checked
from tests.support.command import called, report_of
from tests.support.pages import code
from tests.support.pinocchio import pin
from tests.support.ros2 import (
    Package,
    check_control,
    check_manifest,
    launched,
    package_in,
    same_robot,
    same_text,
)
from tests.support.users import write
from tests.support.validators import colcon_build

PIP = [sys.executable, "-m", "pip", "--disable-pip-version-check"]
OFFLINE = ["--no-deps", "--no-build-isolation", "--no-index", "--quiet"]

ANSWER = """
import importlib, json, mujoco, os
import {module} as robot
model = mujoco.MjModel.from_xml_path(robot.SCENE_PATH)
alone = mujoco.MjModel.from_xml_path(robot.MJCF_PATH)
by_urdf = mujoco.MjModel.from_xml_path(robot.URDF_PATH)
answer = {{"paths": {{name: getattr(robot, name) for name in robot.__all__}}, "cwd": os.getcwd()}}
answer["mass"] = [float(model.body_mass.sum()) for model in (alone, by_urdf)]
answer["joints"] = [sorted(model.joint(i).name for i in range(model.njnt)) for model in (alone, by_urdf)]
try:
    pinocchio = importlib.import_module("pinocchio")
except ModuleNotFoundError:
    answer["pinocchio"] = None
else:
    paths = [robot.PACKAGE_PATH, robot.REPOSITORY_PATH, os.path.dirname(robot.URDF_PATH)]
    pin, _, visual = pinocchio.buildModelsFromUrdf(robot.URDF_PATH, paths)
    answer["pinocchio"] = sum(inertia.mass for inertia in pin.inertias)
    answer["visuals"] = visual.ngeoms
print(json.dumps(answer))
"""


def test_the_ros_package_has_the_robot_of_the_urdf_and_what_it_names(built, monkeypatch):
    package = package_in(built)
    check_manifest(package)
    (urdf,) = built.glob("*.urdf")
    for prefix in ("", "left_"):
        expanded = package.expanded(prefix=prefix)
        same_text(package.plain, expanded, prefix)
        same_robot(urdf.read_bytes(), expanded, prefix)
        for file in ("display.launch.py", "control.launch.py"):
            assert launched(package, file, monkeypatch, prefix=prefix)
    check_control(package, package.expanded(), package.controllers())
    path = package.folder / "urdf" / urdf.name
    root = etree.parse(path).getroot()
    visuals = root.findall("link/visual")
    uris = [mesh.get("filename") for mesh in root.iter("mesh", "texture")]
    assert visuals
    assert uris
    assert all(package.file_of(uri).is_file() for uri in uris)
    # Pinocchio finds each mesh by the name of its package.
    _, _, shown = pin.buildModelsFromUrdf(str(path), [str(package.folder.parent)])
    assert shown.ngeoms == len(visuals)
    # RViz shows what has no colour of its own in that of the link's first visual, or in red.
    colours = {material.get("name") for material in root.findall("material[color]")}
    assert {material.get("name") for material in root.iterfind("link/visual/material")} == colours
    assert all(visual.find("material") is not None for visual in visuals)
    assets = {path.name: path.read_bytes() for path in (built / "assets").iterdir()}
    assert {path.name: path.read_bytes() for path in (package.folder / "meshes").iterdir()} == assets


def test_controllers_of_the_sample_command_its_actuators(sample):
    # What closes the sample's loop follows its shoulder.
    assert "I-ROS2-PASSIVE" not in [row["code"] for row in report_of(sample)["diagnostics"]]
    controllers = package_in(sample).controllers()
    arm, gripper = (
        controllers[name]["ros__parameters"]["joints"]
        for name in ("joint_trajectory_controller", "gripper_controller")
    )
    actuators = json.loads((sample / "robot.json").read_text())["actuators"]
    assert arm + gripper == [actuator["dof"] for actuator in actuators]
    assert gripper == ["left_finger"]


@pytest.mark.slow
def test_colcon_builds_and_installs_the_ros_package(sample, tmp_path):
    shutil.copytree(sample / "ros2", tmp_path / "src")
    assert colcon_build(tmp_path) == ""
    sources = [path for path in (sample / "ros2").iterdir() if path.is_dir()]
    assert len(sources) == 2
    for source in sources:
        prefix = tmp_path / "install" / source.name
        files = [path.relative_to(source) for path in source.rglob("*") if path.is_file()]
        for file in files:
            if file.name != "CMakeLists.txt":
                there = prefix / "share" / source.name / file
                assert there.read_bytes() == (source / file).read_bytes(), file
        index = prefix / "share" / "ament_index" / "resource_index"
        assert (index / "packages" / source.name).is_file()
        needs = (index / "package_run_dependencies" / source.name).read_text().split(";")
        assert sorted(needs) == sorted(check_manifest(Package(source)))


def test_what_the_page_says_of_xacro_works(sample, tmp_path):
    xacro = pytest.importorskip("xacro")
    urdf = sample / "ros2" / "sample_description" / "urdf"
    lines = "\n".join(code("ROS2.md", "sh")).replace("my_arm", "sample").splitlines()
    (line,) = (line for line in lines if line.startswith("xacro "))
    arguments = shlex.split(line.partition(" > ")[0])[1:]
    command = [sys.executable, "-c", "import xacro; xacro.main()", *arguments]
    done = subprocess.run(command, cwd=urdf, capture_output=True, check=True)
    held = etree.fromstring(done.stdout).find("joint[@name='left_base_plate_mount']")
    assert held.find("parent").get("link") == "world"
    assert held.find("origin").get("xyz") == "0 0.5 0"
    (cell,) = code("ROS2.md", "xml")
    cell = cell.replace("my_arm", "sample").replace("$(find sample_description)", str(urdf.parent))
    path = tmp_path / "cell.xacro"
    path.write_text(f'<robot name="cell" xmlns:xacro="http://www.ros.org/wiki/xacro">{cell}</robot>')
    expanded = etree.fromstring(xacro.process_file(str(path)).toxml().encode())
    controls = [element.get("name") for element in expanded.findall("ros2_control")]
    assert controls == ["left_sample", "right_sample"]
    names = [link.get("name") for link in expanded.findall("link")]
    own = etree.parse(urdf / "sample.urdf").findall("link")
    assert len(names) == 1 + 2 * len(own) == len(set(names))


def pip(*arguments):
    """Runs pip without a network."""
    pytest.importorskip("hatchling", reason="hatchling, with which the package is built, is not installed")
    done = subprocess.run([*PIP, *map(str, arguments)], capture_output=True, text=True, check=False)
    if "No module named pip" in done.stderr:
        pytest.skip("pip is not installed")
    assert done.returncode == 0, done.stderr


def test_robot_package_installs_and_loads_in_both_engines(sample, tmp_path):
    before, site = sorted(sample.rglob("*")), tmp_path / "site"
    pip("install", *OFFLINE, "--target", site, sample / "python")
    assert sorted(sample.rglob("*")) == before
    imports = f"import sys; sys.path.insert(0, {str(site)!r})\n"
    (tmp_path / "elsewhere").mkdir()
    command = [sys.executable, "-c", imports + ANSWER.format(module="sample_description")]
    answer = json.loads(subprocess.check_output(command, cwd=tmp_path / "elsewhere"))
    paths = {name: Path(path) for name, path in answer["paths"].items() if name.endswith("_PATH")}
    assert set(paths) == {
        "PACKAGE_PATH", "REPOSITORY_PATH", "URDF_PATH", "MJCF_PATH", "SCENE_PATH", "SDF_PATH",
        "SRDF_PATH", "ROBOT_JSON_PATH",
    }  # fmt: skip
    for name, path in paths.items():
        assert path.is_relative_to(site), name
        if path.is_file():
            assert path.read_bytes() == (sample / path.name).read_bytes(), name
    assert paths["REPOSITORY_PATH"] == site / "sample_description"
    robot = json.loads((sample / "robot.json").read_text())
    assert answer["mass"] == pytest.approx([robot["total_mass"]] * 2, rel=1e-9)
    dofs = sorted(dof["name"] for joint in robot["joints"] for dof in joint["dofs"])
    assert answer["joints"] == [dofs, dofs]
    with_mujoco, with_pinocchio = (text.replace("my_arm", "sample") for text in code("PYTHON.md", "python"))
    subprocess.run([sys.executable, "-c", imports + with_mujoco], cwd=tmp_path, check=True)
    if answer["pinocchio"] is not None:
        subprocess.run([sys.executable, "-c", imports + with_pinocchio], cwd=tmp_path, check=True)
        # Pinocchio has a fixed root's mass in the universe.
        assert answer["pinocchio"] == pytest.approx(robot["total_mass"], rel=1e-9)
        assert answer["visuals"] == (sample / "sample.urdf").read_text().count("<visual>")


def test_a_wheel_holds_every_file(sample, tmp_path):
    pip("wheel", *OFFLINE, "--wheel-dir", tmp_path, sample / "python")
    (wheel,) = tmp_path.glob("*.whl")
    assert wheel.name == "sample_description-1.2.0-py3-none-any.whl"
    with zipfile.ZipFile(wheel) as archive:
        contents = {name: archive.read(name) for name in archive.namelist()}
    about = contents["sample_description-1.2.0.dist-info/METADATA"].decode().splitlines()
    assert {"Name: sample_description", 'Author: Ada "L" Ü', "License: MIT"} <= set(about)
    names = [f"assets/{path.name}" for path in (sample / "assets").iterdir()]
    names += ["sample.urdf", "sample.xml", "scene.xml", "sample.srdf", "sample.sdf", "robot.json"]
    inside = {name: data for name, data in contents.items() if ".dist-info/" not in name}
    prefix = "sample_description/sample"
    assert len(names) > 30
    for name in names:
        assert inside.pop(f"{prefix}/{name}") == (sample / name).read_bytes(), name
    module = {"sample_description/__init__.py", "sample_description/py.typed"}
    assert set(inside) == {*module, f"{prefix}/model.config"}


ELEMENTS = {
    "mark": {"into": {"tag": "body", "name": "wrist"}, "xml": "<site name='mark' pos='0 0 0.1'/>"},
    "lamp": {
        "into": {"tag": "link", "name": "wrist"},
        "xml": "<visual><geometry><sphere radius='0.01'/></geometry></visual>",
    },
    "flag": {
        "into": {"tag": "robot", "name": "sample"},
        "xml": "<link name='flag'/>"
        "<joint name='pole' type='fixed'><parent link='wrist'/><child link='flag'/></joint>",
    },
}


@pytest.mark.slow
@pytest.mark.parametrize("formats", ["ros2", "python", "[python,sdf,ros2]"])
def test_a_build_of_packages_alone_passes_every_check(formats, tmp_path):
    robot = {"defaults": ["/robot/sample", "_self_"], "mesh": {"collider": "hull"}, "elements": ELEMENTS}
    write(tmp_path, own="# @package _global_\n" + yaml.safe_dump(robot, sort_keys=False))
    called(tmp_path, "robot=own", f"export={formats}", "output=out", status=0)
    assert [check for check in checked(str(tmp_path / "out"), "standard").checks if not check.passed] == []


@pytest.mark.slow
def test_a_package_of_an_older_version_passes_its_check(sample, tmp_path):
    """Its robot.json says nothing of what wrote the package."""
    shutil.copytree(sample, tmp_path / "out")
    file = tmp_path / "out/robot.json"
    lines = file.read_text().splitlines(keepends=True)
    file.write_text("".join(line for line in lines if '"writer"' not in line))
    assert file.read_text() != "".join(lines)
    shutil.rmtree(tmp_path / "out/ros2/sample_description/launch")
    checks = checked(str(tmp_path / "out"), "standard").checks
    assert [check for check in checks if check.fails and check.code == "C-ROS2"] == []
