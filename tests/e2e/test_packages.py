"""The packages of whole robots as their users take them: the ROS 2 package, and what pip installs."""

import json
import re
import shlex
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest
from lxml import etree

from tests.support.command import called, environment, linkwright
from tests.support.other_robots import AS_IT_IS, FILES, is_here, source_of
from tests.support.pinocchio import pin
from tests.support.places import PROJECT
from tests.support.ros2 import (
    Package,
    check_control,
    check_manifest,
    launched,
    package_in,
    same_robot,
    same_text,
)
from tests.support.validators import colcon_build

PIP = [sys.executable, "-m", "pip", "--disable-pip-version-check"]
OFFLINE = ["--no-deps", "--no-build-isolation", "--no-index", "--quiet"]

ASKED = """
import importlib, json, mujoco, os
import {module} as robot
model = mujoco.MjModel.from_xml_path(robot.SCENE_PATH)
alone = mujoco.MjModel.from_xml_path(robot.MJCF_PATH)
by_urdf = mujoco.MjModel.from_xml_path(robot.URDF_PATH)
found = {{"paths": {{name: getattr(robot, name) for name in robot.__all__}}, "cwd": os.getcwd()}}
found["mass"] = [float(one.body_mass.sum()) for one in (alone, by_urdf)]
found["joints"] = [sorted(one.joint(i).name for i in range(one.njnt)) for one in (alone, by_urdf)]
try:
    pinocchio = importlib.import_module("pinocchio")
except ModuleNotFoundError:
    found["pinocchio"] = None
else:
    paths = [robot.PACKAGE_PATH, robot.REPOSITORY_PATH, os.path.dirname(robot.URDF_PATH)]
    pin, _, visual = pinocchio.buildModelsFromUrdf(robot.URDF_PATH, paths)
    found["pinocchio"] = sum(one.mass for one in pin.inertias)
    found["visuals"] = visual.ngeoms
print(json.dumps(found))
"""


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The output of the sample with both packages, where git is told to ignore meshes."""
    here = tmp_path_factory.mktemp("packages")
    (here / ".git").mkdir()
    (here / ".gitignore").write_text("*.stl\nassets/\n")
    about = ["export.python.author='Ada \"L\" Ü'", "export.python.license=MIT", "export.python.version=1.2.0"]
    formats = "export=[urdf,mjcf,sdf,ros2,python]"
    done = called(here, "robot=sample", "mesh=visual", formats, *about)
    assert done.returncode == 0, done.stderr
    return here / "outputs" / "sample"


def check_ros(output: Path, monkeypatch: pytest.MonkeyPatch) -> Package:
    """The ROS 2 package of a build has the robot of its URDF, and what each part of it names is there."""
    package = package_in(output)
    check_manifest(package)
    (urdf,) = output.glob("*.urdf")
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
    uris = [one.get("filename") for one in root.iter("mesh", "texture")]
    assert visuals
    assert uris
    assert all(package.file_of(uri).is_file() for uri in uris)
    # Pinocchio finds each mesh by the name of its package.
    _, _, shown = pin.buildModelsFromUrdf(str(path), [str(package.folder.parent)])
    assert shown.ngeoms == len(visuals)
    # RViz shows what has no colour of its own in that of the link's first visual, or in red.
    colours = {one.get("name") for one in root.findall("material[color]")}
    assert {one.get("name") for one in root.iterfind("link/visual/material")} == colours
    assert all(one.find("material") is not None for one in visuals)
    assets = {one.name: one.read_bytes() for one in (output / "assets").iterdir()}
    assert {one.name: one.read_bytes() for one in (package.folder / "meshes").iterdir()} == assets
    return package


def test_the_ros_package_of_the_sample(built: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    package = check_ros(built, monkeypatch)
    told = {
        one["code"]: one["message"] for one in json.loads((built / "report.json").read_text())["diagnostics"]
    }
    # What closes the sample's loop follows its shoulder.
    assert "I-ROS2-PASSIVE" not in told
    arm, gripper = (
        package.controllers()[name]["ros__parameters"]["joints"]
        for name in ("joint_trajectory_controller", "gripper_controller")
    )
    driven = [one["dof"] for one in json.loads((built / "robot.json").read_text())["actuators"]]
    assert arm + gripper == driven
    assert gripper == ["left_finger"]


@pytest.mark.slow
@pytest.mark.parametrize("name", FILES)
def test_the_ros_package_of_a_robot_of_others(name, tmp_path, monkeypatch, shared_cache) -> None:
    if not is_here(name):
        pytest.skip("there are no shared data")
    done = linkwright(
        tmp_path, *source_of(name), f"name={name}", "mesh=visual", "actuators=position", *AS_IT_IS,
        "export=[urdf,mjcf,ros2,python]",
        environ=environment(tmp_path, seeded=False, LINKWRIGHT_CACHE=str(shared_cache)),
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    check_ros(tmp_path / "outputs" / name, monkeypatch)


@pytest.mark.slow
def test_colcon_builds_and_installs_the_ros_package(built: Path, tmp_path: Path) -> None:
    shutil.copytree(built / "ros2", tmp_path / "src")
    assert colcon_build(tmp_path) == ""
    sources = [one for one in (built / "ros2").iterdir() if one.is_dir()]
    assert len(sources) == 2
    for source in sources:
        prefix = tmp_path / "install" / source.name
        files = [one.relative_to(source) for one in source.rglob("*") if one.is_file()]
        for file in files:
            if file.name != "CMakeLists.txt":
                there = prefix / "share" / source.name / file
                assert there.read_bytes() == (source / file).read_bytes(), file
        index = prefix / "share" / "ament_index" / "resource_index"
        assert (index / "packages" / source.name).is_file()
        needs = (index / "package_run_dependencies" / source.name).read_text().split(";")
        assert sorted(needs) == sorted(check_manifest(Package(source)))


def blocks(page: str, language: str) -> list[str]:
    """The code of a page in a language, for the sample."""
    text = (PROJECT / "pipeline" / "reference" / "formats" / page).read_text().replace("my_arm", "sample")
    return re.findall(rf"^```{language}\n(.*?)^```$", text, re.MULTILINE | re.DOTALL)


def test_what_the_page_says_of_xacro_works(built: Path, tmp_path: Path) -> None:
    xacro = pytest.importorskip("xacro")
    urdf = built / "ros2" / "sample_description" / "urdf"
    lines = [line for text in blocks("ROS2.md", "sh") for line in text.splitlines()]
    (line,) = (one for one in lines if one.startswith("xacro "))
    arguments = shlex.split(line.partition(" > ")[0])[1:]
    command = [sys.executable, "-c", "import xacro; xacro.main()", *arguments]
    done = subprocess.run(command, cwd=urdf, capture_output=True, check=True)
    held = etree.fromstring(done.stdout).find("joint[@name='left_base_plate_mount']")
    assert held.find("parent").get("link") == "world"
    assert held.find("origin").get("xyz") == "0 0.5 0"
    (cell,) = blocks("ROS2.md", "xml")
    cell = cell.replace("$(find sample_description)", str(urdf.parent))
    path = tmp_path / "cell.xacro"
    path.write_text(f'<robot name="cell" xmlns:xacro="http://www.ros.org/wiki/xacro">{cell}</robot>')
    expanded = etree.fromstring(xacro.process_file(str(path)).toxml().encode())
    controls = [one.get("name") for one in expanded.findall("ros2_control")]
    assert controls == ["left_sample", "right_sample"]
    names = [one.get("name") for one in expanded.findall("link")]
    own = etree.parse(urdf / "sample.urdf").findall("link")
    assert len(names) == 1 + 2 * len(own) == len(set(names))


def installed(source: Path, folder: Path) -> Path:
    """What pip installs of a package, without a network."""
    pytest.importorskip("hatchling", reason="hatchling, with which the package is built, is not installed")
    if subprocess.run([*PIP, "--version"], capture_output=True, check=False).returncode:
        pytest.skip("pip is not installed")
    done = subprocess.run(
        [*PIP, "install", *OFFLINE, "--target", str(folder), str(source)],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return folder


def asked(site: Path, module: str, here: Path) -> dict:
    """What a program elsewhere finds in an installed package."""
    code = f"import sys; sys.path.insert(0, {str(site)!r})\n" + ASKED.format(module=module)
    done = subprocess.run([sys.executable, "-c", code], cwd=here, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def test_pip_installs_the_robot_and_both_engines_load_it_from_anywhere(built: Path, tmp_path: Path) -> None:
    before = sorted(built.rglob("*"))
    site = installed(built / "python", tmp_path / "site")
    assert sorted(built.rglob("*")) == before
    (tmp_path / "elsewhere").mkdir()
    found = asked(site, "sample_description", tmp_path / "elsewhere")
    paths = {name: Path(path) for name, path in found["paths"].items() if name.endswith("_PATH")}
    assert set(paths) == {
        "PACKAGE_PATH", "REPOSITORY_PATH", "URDF_PATH", "MJCF_PATH", "SCENE_PATH", "SDF_PATH",
        "SRDF_PATH", "ROBOT_JSON_PATH",
    }  # fmt: skip
    for name, path in paths.items():
        assert path.is_relative_to(site), name
        if path.is_file():
            assert path.read_bytes() == (built / path.name).read_bytes(), name
    assert paths["REPOSITORY_PATH"] == site / "sample_description"
    robot = json.loads((built / "robot.json").read_text())
    assert found["mass"] == pytest.approx([robot["mass"]] * 2, rel=1e-9)
    dofs = sorted(dof["name"] for joint in robot["joints"] for dof in joint["dofs"])
    assert found["joints"] == [dofs, dofs]
    first, second = blocks("PYTHON.md", "python")
    for code in [first, *([second] if found["pinocchio"] is not None else [])]:
        code = f"import sys; sys.path.insert(0, {str(site)!r})\n{code}"
        subprocess.run([sys.executable, "-c", code], cwd=tmp_path, check=True)
    if found["pinocchio"] is not None:
        # Pinocchio has a fixed root's mass in the universe.
        assert found["pinocchio"] == pytest.approx(robot["mass"], rel=1e-9)
        assert found["visuals"] == (built / "sample.urdf").read_text().count("<visual>")


def test_a_wheel_holds_every_file(built: Path, tmp_path: Path) -> None:
    pytest.importorskip("hatchling", reason="hatchling, with which the package is built, is not installed")
    done = subprocess.run(
        [*PIP, "wheel", *OFFLINE, "--wheel-dir", str(tmp_path), str(built / "python")],
        capture_output=True,
        text=True,
        check=False,
    )
    if "No module named pip" in done.stderr:
        pytest.skip("pip is not installed")
    assert done.returncode == 0, done.stderr
    (wheel,) = tmp_path.glob("*.whl")
    assert wheel.name == "sample_description-1.2.0-py3-none-any.whl"
    with zipfile.ZipFile(wheel) as archive:
        every = {name: archive.read(name) for name in archive.namelist()}
    inside = {name: data for name, data in every.items() if ".dist-info/" not in name}
    about = every["sample_description-1.2.0.dist-info/METADATA"].decode().splitlines()
    assert {"Name: sample_description", 'Author: Ada "L" Ü', "License: MIT"} <= set(about)
    data = {
        f"sample_description/sample/{one.relative_to(built)}": one.read_bytes()
        for one in [
            *built.glob("assets/*"),
            *(built / name for name in ("sample.urdf", "sample.xml", "scene.xml")),
        ]
    }
    assert len(data) > 30
    assert data.items() <= inside.items()
    assert set(inside) - set(data) == {
        "sample_description/__init__.py",
        "sample_description/py.typed",
        *(
            f"sample_description/sample/{name}"
            for name in ("sample.srdf", "sample.sdf", "model.config", "robot.json")
        ),
    }
