"""What MuJoCo makes of a built robot, as JSON: what engines are held against.

`reference(folder)` reads the files of a build. "mjcf" is of its scene, "urdf" of its URDF with each link a
body of its own, "scene" motions of the scene from its keyframe `home`. In "mjcf" and "urdf" the base is held.
Poses of links are 4x4, in the root link.
"""

import json

import mujoco
import numpy as np

POSES = 5
"""Seeded poses, after that at zero."""

SECONDS, SAMPLES = 1.0, 20
"""The length of a motion, and how often it is written down."""

STEP = 2e-4
"""[s] of the motion of a bare tree."""

STEPS = 100
"""Steps of the scene that learning engines are compared over."""

HOLD = 5.0
"""[s] that servos hold."""

STARTS = {"home": 0.0, "pushed": 0.2, "saturated": 2.0}
"""How far controls are from those of the keyframe `home`: by this share of what its servo's force can be, and
at most by `RANGE` of the control's own."""

RANGE = 0.1

NEAR, OWN_WAY = 1e-6, 100.0
"""How far [m, rad] a start is moved, and how many times as far its motion is apart where chaos begins: there
single precision decides."""

LEFT_OUT = (
    mujoco.mjtDisableBit.mjDSBL_CONTACT
    | mujoco.mjtDisableBit.mjDSBL_LIMIT
    | mujoco.mjtDisableBit.mjDSBL_EQUALITY
    | mujoco.mjtDisableBit.mjDSBL_FRICTIONLOSS
    | mujoco.mjtDisableBit.mjDSBL_ACTUATION
)
"""What a bare tree lacks: each engine has its own laws of contact, limits and dry friction."""


def reference(folder):
    """The reference of the robot in this folder, whose files are named after it."""
    name = json.loads((folder / "robot.json").read_text())["name"]
    scene = mujoco.MjModel.from_xml_path(str(folder / "scene.xml"))
    files = {
        kind: f"{name}.{kind}" for kind in ("urdf", "sdf", "usda") if (folder / f"{name}.{kind}").exists()
    }
    return {
        "robot": name,
        "mujoco": mujoco.__version__,
        "files": {"scene": "scene.xml", "mjcf": f"{name}.xml", **files},
        "mjcf": tree(held(folder / f"{name}.xml")),
        "urdf": tree(with_links(folder / files["urdf"])) if "urdf" in files else None,
        "scene": {start: scene_motion(scene, push) for start, push in STARTS.items()},
    }


def held(path):
    """The model with its base held: without free joints."""
    spec = mujoco.MjSpec.from_file(str(path))
    for joint in spec.joints:
        if joint.type == mujoco.mjtJoint.mjJNT_FREE:
            spec.delete(joint)
    for key in spec.keys:
        spec.delete(key)
    return spec.compile()


def with_links(path):
    """The URDF, whose fixed joints are kept."""
    spec = mujoco.MjSpec.from_file(str(path))
    spec.compiler.fusestatic = False
    return spec.compile()


def tree(model):
    """Masses, poses, mass matrices and biases at seeded poses, and the motion of the bare tree."""
    rng = np.random.default_rng(0)
    drawn = [model.qpos0.copy(), *(_drawn(model, rng) for _ in range(POSES))]
    return {
        "joints": [model.joint(index).name for index in range(model.njnt)],
        "zero": model.qpos0.tolist(),
        "masses": {model.body(body).name: float(model.body_mass[body]) for body in range(1, model.nbody)},
        "poses": [at_rest(model, q) for q in drawn],
        "bare": bare_motion(model, drawn[1]),
    }


def _drawn(model, rng):
    """Values of all joints [m, rad], small enough for each; balls turned about a seeded axis."""
    q = model.qpos0.copy()
    for joint in range(model.njnt):
        at = model.jnt_qposadr[joint]
        if model.jnt_type[joint] == mujoco.mjtJoint.mjJNT_BALL:
            mujoco.mju_axisAngle2Quat(q[at : at + 4], rng.normal(size=3), rng.uniform(-1, 1))
        else:
            low, high = model.jnt_range[joint] if model.jnt_limited[joint] else (-1.0, 1.0)
            q[at] = rng.uniform(low, high)
    return q


def at_rest(model, q):
    data = mujoco.MjData(model)
    data.qpos[:] = q
    # The bias has speeds in it too.
    data.qvel[:] = np.linspace(-1, 1, model.nv)
    mujoco.mj_forward(model, data)
    return {
        "qpos": q.tolist(),
        "qvel": data.qvel.tolist(),
        "links": links_of(model, data),
        "mass_matrix": mass_matrix(model, data),
        "bias": data.qfrc_bias.tolist(),
    }


def links_of(model, data):
    """root_from_link of each body."""
    made = {}
    root = _pose(data, 1)
    for body in range(1, model.nbody):
        made[model.body(body).name] = (np.linalg.inv(root) @ _pose(data, body)).tolist()
    return made


def _pose(data, body):
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = data.xmat[body].reshape(3, 3), data.xpos[body]
    return pose


def mass_matrix(model, data):
    """By products with unit vectors, which every version has alike."""
    full = np.zeros((model.nv, model.nv))
    for column, unit in enumerate(np.eye(model.nv)):
        mujoco.mj_mulM(model, data, full[column], unit)
    return full.tolist()


def bare_motion(model, q):
    """The tree that falls from rest at half of these values: gravity, inertia and damping alone. `clear`: how
    many of the values come before a start that is `NEAR` it goes its own way."""
    model.opt.disableflags |= int(LEFT_OUT)
    model.opt.integrator = mujoco.mjtIntegrator.mjINT_RK4
    model.opt.timestep = STEP
    model.dof_armature[:] = 0.0
    data, other = mujoco.MjData(model), mujoco.MjData(model)
    mujoco.mj_integratePos(model, data.qpos, _difference(model, q), 0.5)
    start = data.qpos.tolist()
    mujoco.mj_integratePos(model, other.qpos, _difference(model, q), 0.5)
    mujoco.mj_integratePos(model, other.qpos, np.full(model.nv, NEAR), 1.0)
    runs = [_run(model, each, round(SECONDS / STEP), SAMPLES) for each in (data, other)]
    apart = np.abs(np.array(runs[0]) - np.array(runs[1])).max(axis=1, initial=0.0)
    clear = int(np.argmax(apart > NEAR * OWN_WAY)) if (apart > NEAR * OWN_WAY).any() else SAMPLES
    return {"start": start, "seconds": SECONDS, "qpos": runs[0], "clear": clear}


def _difference(model, q):
    found = np.zeros(model.nv)
    mujoco.mj_differentiatePos(model, found, 1.0, model.qpos0, q)
    return found


def scene_motion(model, push):
    """From `home` under its controls, which are moved by `push`."""
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, model.key("home").id)
    controls = pushed(model, data.ctrl, push)
    data.ctrl[:] = controls
    first, before = [data.qpos.tolist()], data.qpos.copy()
    hundred = _run(model, data, STEPS, STEPS)
    first_second, rest = (round(time / model.opt.timestep) for time in (SECONDS, HOLD - SECONDS))
    return {
        "timestep": model.opt.timestep,
        "start": before.tolist(),
        "controls": controls.tolist(),
        "hundred": first + hundred,  # each step
        "end": _run(model, data, max(first_second - STEPS, 1), 1)[0],
        "held": _run(model, data, rest, 1)[0],
    }


def pushed(model, controls, push):
    """The controls, each moved up or down, within its range."""
    sign = np.random.default_rng(3).choice((-1.0, 1.0), model.nu)
    low, high = model.actuator_ctrlrange.T
    moves = np.array([_move(model, actuator, push) for actuator in range(model.nu)])
    return np.clip(controls + sign * np.minimum(moves, RANGE * (high - low)), low, high)


def _move(model, actuator, push):
    """What makes that share of the force; infinite where nothing limits it."""
    joint = model.actuator_trnid[actuator][0]
    gear, gain = abs(model.actuator_gear[actuator][0]), abs(model.actuator_gainprm[actuator][0])
    limits = [model.actuator_forcerange[actuator][1] * gear] if model.actuator_forcelimited[actuator] else []
    limits += [model.jnt_actfrcrange[joint][1]] if model.jnt_actfrclimited[joint] else []
    return float(push * min(limits, default=np.inf) / (gain * gear)) if push else 0.0


def _run(model, data, steps, samples):
    made = []
    for step in range(1, steps + 1):
        mujoco.mj_step(model, data)
        if step % (steps // samples) == 0:
            made.append(data.qpos.tolist())
    return made
