"""Every option of `export.urdf`, as Pinocchio and MuJoCo read the file."""

from pathlib import Path

import mujoco
import numpy as np
import pytest

from pipeline.errors import ConfigError
from stages.export.urdf.keys import UrdfFormatKeys
from stages.export.urdf.model import write_urdf
from stages.formats.xml import parse
from stages.mesh import make_geometry
from stages.robot.geometry import Geometry
from stages.robot.model import Frame, frozen
from stages.validate import validate
from tests.support.building import bundle_of, plan_of, robot_of, write
from tests.support.kit import SIDE, TOP, Kit
from tests.support.pinocchio import pin
from tests.support.robots import joint, pose, robot_with

NO_SHAPES = Geometry((), {})


def built(folder: Path, **keys: object) -> bytes:
    """The URDF of two bars with meshes, checked by the validate stage."""
    kit = Kit()
    base, arm = kit.place("Base", fixed=True), kit.place("Arm")
    kit.root.revolute("Elbow", (arm, TOP), (base, SIDE), value=0.3, limits=(0, 1))
    plan = plan_of(export={"urdf": keys})
    robot = robot_of(kit.document, plan)
    geometry = make_geometry(robot, bundle_of(kit.document), plan, lambda kind, key, make: make())
    exported = write(robot, folder, plan, geometry)
    assert [check.name for check in validate(folder, robot, plan) if not check.passed] == []
    return exported.files["robot.urdf"]


@pytest.mark.parametrize("package", [None, "my-robot_2"])
def test_meshes_by_package_are_found_there_and_by_the_checks(package: str | None, tmp_path: Path) -> None:
    folder = tmp_path / (package or "robot")
    text = built(folder, meshes="package", package=package)
    files = {node.get("filename") for node in parse(text).iter("mesh")}
    assert files
    assert all(file.startswith(f"package://{folder.name}/assets/") for file in files)
    model = pin.buildModelFromXML(text.decode())
    visual = pin.buildGeomFromUrdfString(model, text.decode(), pin.VISUAL, package_dirs=[str(tmp_path)])
    assert {Path(one.meshPath) for one in visual.geometryObjects} <= set((folder / "assets").iterdir())
    assert visual.ngeoms == 2


def test_a_mesh_missing_from_the_package_fails_the_check(tmp_path: Path) -> None:
    text = built(tmp_path, meshes="package")
    (tmp_path / "robot.urdf").write_bytes(text.replace(b"assets/arm", b"assets/nothing"))
    checks = validate(tmp_path, robot_with([]), plan_of(validate__level="quick"))
    assert [check.name for check in checks if not check.passed] == ["robot.urdf: compiles"]


@pytest.mark.parametrize("meshes", ["relative", "package"])
def test_the_meshes_that_mujoco_compiles_are_the_same(meshes: str, tmp_path: Path) -> None:
    from stages.validate.engines.mujoco_engine import load

    built(tmp_path, meshes=meshes)
    model = load(tmp_path / "robot.urdf").model
    assert (model.nmesh, model.ngeom) == (4, 4)


def test_without_a_word_links_of_frames_have_no_inertial_and_with_tiny_next_to_none() -> None:
    rng = np.random.default_rng(2)
    frames = [Frame(name, "arm", frozen(pose(rng)), name) for name in ("tool", "camera")]
    robot = robot_with([joint("revolute", "base", "arm", place=pose(rng))], frames=frames)
    none, tiny = (
        write_urdf(robot, NO_SHAPES, UrdfFormatKeys(frame_inertia=kind)) for kind in ("none", "tiny")
    )
    for text, expected in ((none, []), (tiny, ["tool", "camera"])):
        links = parse(text).findall("link")
        assert [link.get("name") for link in links if link.find("inertial") is not None][2:] == expected
    heavy, light = (mujoco.MjModel.from_xml_string(text.decode()) for text in (tiny, none))
    assert heavy.body("tool").mass[0] == 1e-12
    assert tuple(heavy.body("tool").inertia) == (1e-12,) * 3
    assert light.body("tool").mass[0] == 0
    weights = [pin.computeTotalMass(pin.buildModelFromXML(text.decode())) for text in (tiny, none)]
    assert weights[0] - weights[1] == pytest.approx(2e-12, rel=1e-2)


def test_a_root_called_world_stays_without_an_inertial() -> None:
    robot = robot_with([joint("revolute", "world", "arm")], root="world")
    text = write_urdf(robot, NO_SHAPES, UrdfFormatKeys(frame_inertia="tiny"))
    assert len(parse(text).find("link[@name='world']")) == 0


@pytest.mark.parametrize(
    ("keys", "where", "message"),
    [
        ({"meshes": "absolute"}, "export.urdf.meshes", "'absolute' is not allowed"),
        ({"package": "my robot"}, "export.urdf.package", "must be the name of a package"),
        ({"package": "../up"}, "export.urdf.package", "must be the name of a package"),
        ({"package": ""}, "export.urdf.package", ""),
        ({"frame_inertia": "small"}, "export.urdf.frame_inertia", "'small' is not allowed"),
    ],
)
def test_a_bad_option_is_named(keys: dict, where: str, message: str) -> None:
    with pytest.raises(ConfigError) as caught:
        plan_of(export={"urdf": keys})
    (problem,) = caught.value.problems
    assert problem.where == where
    assert message in problem.message
