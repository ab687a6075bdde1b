"""Every option of `export.urdf`, as Pinocchio and MuJoCo read the file."""

from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np
import pytest

from linkwright.stages.export.urdf.model import write_urdf
from linkwright.stages.export.urdf.section import UrdfFormatSection
from linkwright.stages.formats.urdf.form import UrdfForm
from linkwright.stages.formats.written import Written
from linkwright.stages.formats.xml import parse
from linkwright.stages.robot.dynamics.mass_matrix import mass_matrix
from linkwright.stages.robot.model.robot import Frame, frozen
from linkwright.stages.robot.motion.kinematics import link_poses
from linkwright.stages.validate.engines.mujoco_engine import load
from tests.support.building import NO_MESHES, plan_of, shaped, write
from tests.support.checked import checked
from tests.support.engines import Mujoco, Pinocchio
from tests.support.exports import failing
from tests.support.kit import Kit
from tests.support.pinocchio import pin
from tests.support.robots import joint, pose, robot_with, some_values
from tests.unit.export.test_mjcf_fused import PLACES, arm


def with_meshes(**keys):
    """Two bars on a hinge, and their meshes."""
    kit = Kit()
    kit.elbow(value=0.3, limits=(0, 1))
    return shaped(kit.document, **keys)


def built(folder, **keys):
    """The URDF of two bars with meshes, checked by the validate stage."""
    robot, geometry, _ = with_meshes()
    return urdf_of(robot, geometry, folder, **keys).read_bytes()


@pytest.mark.parametrize("package", [None, "my-robot_2"])
def test_meshes_by_package_are_found_there_and_by_the_checks(package, tmp_path):
    folder = tmp_path / (package or "robot")
    text = built(folder, meshes="package", package=package)
    files = {node.get("filename") for node in parse(text).iter("mesh")}
    assert files
    assert all(file.startswith(f"package://{folder.name}/assets/") for file in files)
    model = pin.buildModelFromXML(text.decode())
    visual = pin.buildGeomFromUrdfString(model, text.decode(), pin.VISUAL, package_dirs=[str(tmp_path)])
    paths = {Path(shape.meshPath) for shape in visual.geometryObjects}
    assert paths <= set((folder / "assets").iterdir())
    assert visual.ngeoms == 2


def test_mesh_missing_from_the_package_fails_the_check(tmp_path):
    text = built(tmp_path, meshes="package")
    (tmp_path / "robot.urdf").write_bytes(text.replace(b"assets/arm", b"assets/nothing"))
    checks = checked(tmp_path, robot_with([]), plan_of(validate__level="quick"))
    assert [check.name for check in checks if check.fails] == ["robot.urdf: paths", "robot.urdf: compiles"]


@pytest.mark.parametrize("meshes", ["relative", "package"])
def test_meshes_that_mujoco_compiles_are_the_same(meshes, tmp_path):
    built(tmp_path, meshes=meshes)
    model = load(tmp_path / "robot.urdf").model
    assert (model.nmesh, model.ngeom) == (4, 4)


def test_inertial_of_frames_is_left_out_or_tiny():
    rng = np.random.default_rng(2)
    frames = [Frame(name, "arm", frozen(pose(rng)), name) for name in ("tool", "camera")]
    robot = robot_with([joint("revolute", "base", "arm", place=pose(rng))], frames=frames)
    texts = [write_urdf(Written(robot), UrdfFormatSection(frame_inertia=kind)) for kind in ("none", "tiny")]
    for text, expected in zip(texts, ([], ["tool", "camera"]), strict=True):
        links = parse(text).findall("link")
        assert [link.get("name") for link in links if link.find("inertial") is not None][2:] == expected
    light, heavy = (mujoco.MjModel.from_xml_string(text.decode()) for text in texts)
    assert (heavy.body("tool").mass[0], tuple(heavy.body("tool").inertia)) == (1e-12, (1e-12,) * 3)
    assert light.body("tool").mass[0] == 0
    weights = [pin.computeTotalMass(pin.buildModelFromXML(text.decode())) for text in texts]
    assert weights[1] - weights[0] == pytest.approx(2e-12, rel=1e-2)


def urdf_of(robot, geometry, folder, **keys):
    """The URDF in a folder of its own, checked by the validate stage."""
    plan = plan_of(export={"urdf": keys})
    assert failing(folder, write(robot, folder, plan, geometry), plan) == []
    return folder / "robot.urdf"


def test_merged_links_move_weigh_and_stand_as_they_did(tmp_path):
    robot, geometry = arm()
    kept = urdf_of(robot, geometry, tmp_path / "keep", fixed_joints="keep")
    merged = urdf_of(robot, geometry, tmp_path / "merge", fixed_joints="merge")
    tree = parse(merged.read_bytes())
    assert [link.get("name") for link in tree.findall("link")] == ["base", "arm", "hand", "tool"]
    dofs = [dof.name for dof in robot.dofs]
    engines = [(Pinocchio(kept.read_bytes()), Pinocchio(merged.read_bytes())), (Mujoco(kept), Mujoco(merged))]
    rng = np.random.default_rng(7)
    for before, after in engines:
        for _ in range(5):
            q = some_values(robot, rng)
            old, new = before.poses(q), after.poses(q)
            own = link_poses(robot, q)
            own["tool"] = own["tip"] @ PLACES[5]
            for name in ("arm", "hand", "tool"):
                assert np.abs(new[name] - old[name]).max() < 1e-9
                assert np.abs(new[name] - own[name]).max() < 1e-9
            inertia = after.mass_matrix(q, dofs)
            assert np.abs(inertia - before.mass_matrix(q, dofs)).max() < 1e-9
            assert np.abs(inertia - mass_matrix(robot, q)).max() < 1e-9
            assert np.abs(after.gravity(q, dofs) - before.gravity(q, dofs)).max() < 1e-9
    places = [np.array(sorted(engine.data.geom_xpos.tolist())) for engine in engines[1]]
    assert len(places[0]) == 10
    assert np.abs(places[0] - places[1]).max() < 1e-9
    total = sum(link.inertial.mass for link in robot.links)
    assert engines[1][1].model.body_mass.sum() == pytest.approx(total, abs=1e-9)
    free = pin.buildModelFromXML(merged.read_text(), pin.JointModelFreeFlyer())
    assert (pin.computeTotalMass(free), free.nbodies) == (pytest.approx(total, abs=1e-9), 1 + 3)


def test_mesh_of_a_merged_link_is_where_it_was(tmp_path):
    robot, geometry, _ = with_meshes()
    held = replace(robot.joints[0], type="fixed", dofs=())  # as a URDF source has it
    robot = replace(robot, joints=(held,))
    (tmp_path / "assets").mkdir()
    for name, data in geometry.files.items():
        (tmp_path / "assets" / name).write_bytes(data)
    places = []
    for is_merged in (False, True):
        form = UrdfForm(merged=is_merged)
        text = write_urdf(Written(robot, geometry=geometry, urdf_form=form)).decode()
        model = pin.buildModelFromXML(text)
        shapes = pin.buildGeomFromUrdfString(model, text, pin.VISUAL, package_dirs=[str(tmp_path)])
        places.append({shape.meshPath: shape.placement.homogeneous for shape in shapes.geometryObjects})
    assert places[0].keys() == places[1].keys()
    assert max(np.abs(places[0][key] - places[1][key]).max() for key in places[0]) < 1e-12
    assert max(np.abs(place - np.eye(4)).max() for place in places[1].values()) > 0.01


def test_link_fixed_to_a_root_called_world_keeps_its_mass(tmp_path):
    robot, geometry = arm("world")
    merged = urdf_of(robot, geometry, tmp_path, fixed_joints="merge")
    names = [link.get("name") for link in parse(merged.read_bytes()).findall("link")]
    assert names == ["world", "arm", "hand", "mast", "tool"]
    total = sum(link.inertial.mass for link in robot.links)
    assert Mujoco(merged).model.body_mass.sum() == pytest.approx(total, abs=1e-9)


def test_controls_of_a_merged_joint_are_left_out():
    joints = '<joint name="plate_joint"/><joint name="arm_joint"/>'
    text = f'<ros2_control name="c" type="system">{joints}</ros2_control>'
    robot = replace(arm()[0], controls=(text,))
    tree = parse(write_urdf(Written(robot, geometry=NO_MESHES, urdf_form=UrdfForm(merged=True))))
    assert [node.get("name") for node in tree.findall("ros2_control/joint")] == ["arm_joint"]
