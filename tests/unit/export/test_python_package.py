"""The Python package: names, keys, and the constants of its files."""

import ast
import tomllib
from pathlib import Path

from tests.support.exports import exported
from tests.support.robots import joint, robot_with


def files_of(**keys):
    robot = robot_with([joint("revolute", "base", "arm")])
    return exported(robot, **keys).files


def constants(text):
    """The paths that a module makes, without what is above it."""
    folder = Path("/site/module")
    space = {"__file__": str(folder / "__init__.py")}
    exec(compile(text, "module", "exec"), space)
    paths = [name for name in space["__all__"] if name.endswith("_PATH")]
    return {name: str(Path(space[name]).relative_to(folder)) for name in paths}


def test_each_file_has_a_constant():
    files = files_of(export={"python": {}})
    assert [name for name in files if "/" not in name] == ["robot.json"]
    paths = constants(files["python/robot_description/__init__.py"])
    assert paths == {
        "REPOSITORY_PATH": ".", "PACKAGE_PATH": "robot", "URDF_PATH": "robot/robot.urdf",
        "SRDF_PATH": "robot/robot.srdf", "MJCF_PATH": "robot/robot.xml", "SCENE_PATH": "robot/scene.xml",
        "ROBOT_JSON_PATH": "robot/robot.json",
    }  # fmt: skip
    more = files_of(export={"python": {}, "urdf": {}, "sdf": {}, "ros2": {}})
    assert constants(more["python/robot_description/__init__.py"])["SDF_PATH"] == "robot/robot.sdf"
    for path in paths.values():
        assert path in (".", "robot") or f"python/robot_description/{path}" in files
    assert not [path for path in more if path.startswith("python/") and "ros2" in path]
    assert more["python/robot_description/robot/robot.json"] == more["robot.json"]


def test_keys_are_in_the_project_and_paths_find_their_folder():
    keys = {"package": "my-arm", "version": "1.2.0rc1", "author": 'Ada "é" 😀', "license": "MIT"}
    files = files_of(export={"python": keys, "urdf": {"meshes": "package", "package": "my-robot"}})
    project = tomllib.loads(files["python/pyproject.toml"].decode())["project"]
    assert (project["name"], project["version"]) == ("my-arm", "1.2.0rc1")
    assert (project["authors"], project["license"]) == ([{"name": 'Ada "é" 😀'}], {"text": "MIT"})
    text = files["python/my_arm/__init__.py"]
    assert constants(text)["URDF_PATH"] == "my-robot/robot.urdf"
    assert "import my_arm" in ast.get_docstring(ast.parse(text))


def test_users_own_xml_is_in_the_package():
    attributes = {"arm_joint": {"armature": 0.5, "formats": ["mjcf"], "tag": "joint"}}
    files = files_of(export={"python": {}}, attributes=attributes)
    assert b'armature="0.5"' in files["python/robot_description/robot/robot.xml"]
