"""Variants in the engines that learn from them: the code of docs/guide/variants.md, run on robots."""

from contextlib import chdir
from pathlib import Path

import mujoco
import numpy as np
import pytest

from linkwright.stages.robot.model.geometry import Geometry
from tests.fake_onshape.sample import sample_document
from tests.support.building import plan_of, robot_of, write
from tests.support.pages import blocks
from tests.unit.export.test_variants import ball

CODE, N = blocks("docs/guide/variants.md"), 12


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """The sample with servos, a ball on two links, and variants."""
    made = tmp_path_factory.mktemp("variants")
    geometry = Geometry((ball("forearm"), ball("base_plate")), {})
    plan = plan_of(actuators={"*": "position"}, variants={"n": N, "seed": 3, "ranges": {"*": 0.2}})
    write(robot_of(sample_document()), made, plan, geometry)
    return made


@pytest.fixture
def names(folder):
    """What the first piece of code defines."""
    namespace = {}
    with chdir(folder):
        exec(CODE["mujoco"], namespace)
        yield namespace


def compiled_variant(folder, file, number):
    """The scene compiled with a variant's values in its elements: no field of a model is set."""
    spec = mujoco.MjSpec.from_file(str(folder / "scene.xml"))
    geoms = {}
    for body, name in enumerate(file["body_names"].tolist()):
        element = spec.body(name)
        if body:
            element.explicitinertial = True
            for attribute, field in (("mass", "mass"), ("ipos", "ipos"), ("inertia", "inertia")):
                setattr(element, attribute, file[f"body_{field}"][number, body])
            element.iquat = file["body_iquat"][number, body]
        geoms[body] = element.geoms
    for geom, values in enumerate(file["geom_friction"][number]):
        geoms[file["geom_bodyid"][geom]][file["geom_in_body"][geom]].friction = values
    for dof, name in enumerate(file["joint_names"].tolist()):
        # Each joint of the sample has one degree of freedom.
        joint = spec.joint(name)
        damping, armature = file["dof_damping"][number, dof], file["dof_armature"][number, dof]
        joint.damping = damping if isinstance(joint.damping, float) else [damping, *joint.damping[1:]]
        joint.armature = armature
        joint.frictionloss = file["dof_frictionloss"][number, dof]
    for index, name in enumerate(file["actuator_names"].tolist()):
        actuator = spec.actuator(name)
        actuator.gainprm = file["actuator_gainprm"][number, index]
        actuator.biasprm = file["actuator_biasprm"][number, index]
    return spec.compile()


def motion(model):
    """The robot's positions over a quarter of a second, from home, pushed."""
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, model.key("home").id)
    data.qvel[:] = np.linspace(-0.2, 0.2, model.nv)
    positions = []
    for _ in range(125):
        mujoco.mj_step(model, data)
        positions.append(data.qpos.copy())
    return np.array(positions)


def test_a_variant_is_what_mujoco_compiles_of_its_values(folder, names):
    file = names["file"]
    lacking = {"dof_damping", "dof_frictionloss"} - set(file["fields"])
    for field in lacking:
        file[field] = np.repeat(getattr(names["model"], field)[None], N, axis=0)
    for number in (0, N - 1):
        made, expected = (
            names["variant"](names["model"], file, number),
            compiled_variant(folder, file, number),
        )
        for field in ("body_mass", "body_subtreemass", "dof_invweight0", "dof_M0", "geom_friction"):
            assert np.allclose(getattr(made, field), getattr(expected, field), rtol=1e-9, atol=1e-12), field
        assert np.abs(motion(made) - motion(expected)).max() < 1e-9
        assert np.abs(motion(made) - motion(names["model"])).max() > 1e-6


def test_the_same_code_takes_the_robot_alone(folder, names):
    single = mujoco.MjModel.from_xml_path("sample.xml" if Path("sample.xml").exists() else "robot.xml")
    made = names["variant"](single, names["file"], 5)
    scene = names["variant"](names["model"], names["file"], 5)
    for field in names["file"]["fields"]:
        assert (names["file"][field][5] == getattr(made, field)).all()
        if not field.startswith("geom_"):
            assert (getattr(scene, field)[: len(getattr(made, field))] == getattr(made, field)).all()
    floor = names["model"].geom("floor").id
    assert (scene.geom_friction[floor] == names["model"].geom_friction[floor]).all()


def test_variants_roll_out(names):
    exec(CODE["rollout"], names)
    states = names["states"]
    assert states.shape[:2] == (8, 50)
    assert np.isfinite(states).all()
    assert np.ptp(states[:, -1, 1:], axis=0).max() > 1e-9
    # As the first steps by itself.
    model = names["models"][0]
    data = mujoco.MjData(model)
    mujoco.mj_setState(model, data, names["state"], mujoco.mjtState.mjSTATE_FULLPHYSICS)
    data.ctrl[:] = names["control"][0, 0]
    mujoco.mj_step(model, data)
    first = np.empty_like(names["state"])
    mujoco.mj_getState(model, data, first, mujoco.mjtState.mjSTATE_FULLPHYSICS)
    assert np.allclose(first, states[0, 0], atol=1e-12)


@pytest.mark.slow
def test_variants_run_in_mujoco_warp(names):
    pytest.importorskip("mujoco_warp")
    exec(CODE["warp"], names)
    accelerations = names["d"].qacc.numpy()
    for world in range(names["worlds"]):
        data = mujoco.MjData(names["models"][world])
        mujoco.mj_step(names["models"][world], data)
        scale = np.abs(data.qacc).max()
        assert np.abs(accelerations[world] - data.qacc).max() < 2e-2 * scale
