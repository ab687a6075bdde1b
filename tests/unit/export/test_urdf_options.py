"""Every option of `export.urdf`, as Pinocchio and MuJoCo read the file."""

import json
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
from linkwright.stages.mesh import make_geometry
from linkwright.stages.mesh.collide.primitives import shapes as primitive_shapes
from linkwright.stages.robot.dynamics.mass_matrix import mass_matrix
from linkwright.stages.robot.model.geometry import Geometry
from linkwright.stages.robot.model.robot import Frame, Primitive, frozen
from linkwright.stages.robot.motion.kinematics import link_poses
from linkwright.stages.validate import validate
from tests.support.building import bundle_of, plan_of, robot_of, write
from tests.support.checked import checked
from tests.support.engines import Mujoco, Pinocchio
from tests.support.exports import messages_of
from tests.support.kit import SIDE, TOP, Kit
from tests.support.pinocchio import pin
from tests.support.robots import joint, pose, robot_with, some_values

NO_SHAPES = Geometry((), {})


def built(folder, **keys):
    """The URDF of two bars with meshes, checked by the validate stage."""
    kit = Kit()
    base, arm = kit.place("Base", fixed=True), kit.place("Arm")
    kit.root.revolute("Elbow", (arm, TOP), (base, SIDE), value=0.3, limits=(0, 1))
    plan = plan_of(export={"urdf": keys})
    robot = robot_of(kit.document, plan)
    geometry = make_geometry(robot, bundle_of(kit.document), plan, lambda kind, key, make: make())
    exported = write(robot, folder, plan, geometry)
    assert [check.name for check in validate(folder, exported.written, plan) if check.fails] == []
    return exported.files["robot.urdf"]


@pytest.mark.parametrize("package", [None, "my-robot_2"])
def test_meshes_by_package_are_found_there_and_by_the_checks(package, tmp_path):
    folder = tmp_path / (package or "robot")
    text = built(folder, meshes="package", package=package)
    files = {node.get("filename") for node in parse(text).iter("mesh")}
    assert files
    assert all(file.startswith(f"package://{folder.name}/assets/") for file in files)
    model = pin.buildModelFromXML(text.decode())
    visual = pin.buildGeomFromUrdfString(model, text.decode(), pin.VISUAL, package_dirs=[str(tmp_path)])
    assert {Path(geometryobject.meshPath) for geometryobject in visual.geometryObjects} <= set(
        (folder / "assets").iterdir()
    )
    assert visual.ngeoms == 2


def test_a_mesh_missing_from_the_package_fails_the_check(tmp_path):
    text = built(tmp_path, meshes="package")
    (tmp_path / "robot.urdf").write_bytes(text.replace(b"assets/arm", b"assets/nothing"))
    checks = checked(tmp_path, robot_with([]), plan_of(validate__level="quick"))
    assert [check.name for check in checks if check.fails] == ["robot.urdf: paths", "robot.urdf: compiles"]


@pytest.mark.parametrize("meshes", ["relative", "package"])
def test_the_meshes_that_mujoco_compiles_are_the_same(meshes, tmp_path):
    from linkwright.stages.validate.engines.mujoco_engine import load

    built(tmp_path, meshes=meshes)
    model = load(tmp_path / "robot.urdf").model
    assert (model.nmesh, model.ngeom) == (4, 4)


def test_inertial_of_frames_is_left_out_or_tiny():
    rng = np.random.default_rng(2)
    frames = [Frame(name, "arm", frozen(pose(rng)), name) for name in ("tool", "camera")]
    robot = robot_with([joint("revolute", "base", "arm", place=pose(rng))], frames=frames)
    none, tiny = (
        write_urdf(Written(robot), UrdfFormatSection(frame_inertia=kind)) for kind in ("none", "tiny")
    )
    for text, expected in ((none, []), (tiny, ["tool", "camera"])):
        links = parse(text).findall("link")
        assert [link.get("name") for link in links if link.find("inertial") is not None][2:] == expected
    heavy, light = (mujoco.MjModel.from_xml_string(text.decode()) for text in (tiny, none))
    assert (heavy.body("tool").mass[0], tuple(heavy.body("tool").inertia)) == (1e-12, (1e-12,) * 3)
    assert light.body("tool").mass[0] == 0
    weights = [pin.computeTotalMass(pin.buildModelFromXML(text.decode())) for text in (tiny, none)]
    assert weights[0] - weights[1] == pytest.approx(2e-12, rel=1e-2)


def test_a_root_called_world_stays_without_an_inertial():
    robot = robot_with([joint("revolute", "world", "arm")], root="world")
    text = write_urdf(Written(robot), UrdfFormatSection(frame_inertia="tiny"))
    assert len(parse(text).find("link[@name='world']")) == 0


PLACES = [pose(np.random.default_rng(seed)) for seed in range(20, 26)]


def chain(root="base"):
    """base – turn – arm – fixed – plate – fixed – tip – turn – hand, with shapes and frames on the tip."""
    rows = [
        joint("revolute", root, "arm", place=PLACES[0]), joint("fixed", "arm", "plate", place=PLACES[1]),
        joint("fixed", "plate", "tip", place=PLACES[2]), joint("revolute", "tip", "hand", place=PLACES[3]),
        joint("fixed", root, "mast", place=PLACES[4]),
    ]  # fmt: skip
    ball = Primitive("sphere", (0.02,), frozen(PLACES[5]))
    shapes = dict.fromkeys(("plate", "tip", "mast"), (ball,))
    robot = robot_with(
        rows, root=root, frames=[Frame("tool", "tip", frozen(PLACES[5]), "Tool")], shapes=shapes
    )
    colliders = tuple(shape for link in robot.links for shape in primitive_shapes(link))
    return robot, Geometry(colliders, {})


def urdf_of(robot, geometry, folder, **keys):
    """The URDF in a folder of its own, checked by the validate stage."""
    plan = plan_of(export={"urdf": keys})
    exported = write(robot, folder, plan, geometry)
    checks = validate(folder, exported.written, plan)
    assert [check.name for check in checks if check.fails] == []
    return folder / "robot.urdf"


def test_merged_links_move_weigh_and_stand_as_they_did(tmp_path):
    robot, geometry = chain()
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
    total = sum(link.inertial.mass for link in robot.links)
    assert engines[1][1].model.body_mass.sum() == pytest.approx(total, abs=1e-9)
    free = pin.buildModelFromXML(merged.read_text(), pin.JointModelFreeFlyer())
    assert (pin.computeTotalMass(free), free.nbodies) == (pytest.approx(total, abs=1e-9), 1 + 3)


def test_the_shapes_of_merged_links_are_where_they_were(tmp_path):
    robot, geometry = chain()
    q = some_values(robot, np.random.default_rng(8))
    places = []
    for choice in ("keep", "merge"):
        engine = Mujoco(urdf_of(robot, geometry, tmp_path / choice, fixed_joints=choice))
        engine.poses(q)
        places.append(np.array(sorted(engine.data.geom_xpos.tolist())))
    assert len(places[0]) == 6
    assert np.abs(places[0] - places[1]).max() < 1e-9


def test_a_mesh_of_a_merged_link_is_where_it_was(tmp_path):
    kit = Kit()
    base, arm = kit.place("Base", fixed=True), kit.place("Arm")
    kit.root.revolute("Elbow", (arm, TOP), (base, SIDE), value=0.3, limits=(0, 1))
    robot = robot_of(kit.document)
    plan = plan_of()
    geometry = make_geometry(robot, bundle_of(kit.document), plan, lambda kind, key, make: make())
    held = replace(robot.joints[0], type="fixed", dofs=())  # as a URDF source has it
    robot = replace(robot, joints=(held,))
    places = []
    for choice in ("keep", "merge"):
        text = write_urdf(
            Written(robot, geometry=geometry, urdf_form=UrdfForm(merged=choice == "merge"))
        ).decode()
        model = pin.buildModelFromXML(text)
        files = tmp_path / "assets"
        files.mkdir(exist_ok=True)
        for name, data in geometry.files.items():
            (files / name).write_bytes(data)
        shapes = pin.buildGeomFromUrdfString(model, text, pin.VISUAL, package_dirs=[str(tmp_path)])
        placed = {
            geometryobject.meshPath: geometryobject.placement.homogeneous
            for geometryobject in shapes.geometryObjects
        }
        places.append(placed)
    assert places[0].keys() == places[1].keys()
    assert max(np.abs(places[0][key] - places[1][key]).max() for key in places[0]) < 1e-12
    assert max(np.abs(place - np.eye(4)).max() for place in places[1].values()) > 0.01


def test_what_is_fixed_to_a_root_called_world_keeps_its_mass(tmp_path):
    robot, geometry = chain("world")
    merged = urdf_of(robot, geometry, tmp_path, fixed_joints="merge")
    names = [link.get("name") for link in parse(merged.read_bytes()).findall("link")]
    assert names == ["world", "arm", "hand", "mast", "tool"]
    total = sum(link.inertial.mass for link in robot.links)
    assert Mujoco(merged).model.body_mass.sum() == pytest.approx(total, abs=1e-9)


def test_robot_json_and_a_diagnostic_say_where_merged_links_are(tmp_path):
    robot, geometry = chain()
    exported = write(robot, tmp_path, plan_of(export={"urdf": {"fixed_joints": "merge"}}), geometry)
    (message,) = messages_of(exported, "I-URDF-MERGED")
    assert message.endswith("plate into arm, tip into arm, mast into base")
    table = json.loads(exported.files["robot.json"])
    places = {entry["link"]: (entry["into"], entry["pose"]["xyz"]) for entry in table["merged"]}
    assert places["tip"][0] == "arm"
    assert np.abs((PLACES[1] @ PLACES[2])[:3, 3] - places["tip"][1]).max() < 1e-11
    assert len(table["links"]) == len(robot.links)


def test_controls_of_a_merged_joint_are_left_out():
    joints = '<joint name="plate_joint"/><joint name="arm_joint"/>'
    text = f'<ros2_control name="c" type="system">{joints}</ros2_control>'
    robot = replace(chain()[0], controls=(text,))
    tree = parse(write_urdf(Written(robot, geometry=NO_SHAPES, urdf_form=UrdfForm(merged=True))))
    assert [node.get("name") for node in tree.findall("ros2_control/joint")] == ["arm_joint"]
