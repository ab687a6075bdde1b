"""`python -m tests.benchmarks.standing [FOLDER]`: whether the legged robots of example-robot-data stand.

Each is built with `actuators=position root.base=free mesh=hull`, in the pose of its SRDF, or else with all
joints at zero (or the nearest end of their limits), and the exported scene.xml is simulated for 10 s with the
controls of `home`. A robot can stand where forces of the ground balance its weight at that pose, and no joint
needs more than its effort. A row says how far the base and the joints moved, or why the robot cannot stand.
Ends with exit status 1 where one that can does not.
"""

import argparse
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

import mujoco
import numpy as np
from lxml import etree

from linkwright.stages.export.ground.footing import ground_contacts, mass_and_center, weight_shares
from linkwright.stages.export.ground.standing import stand
from linkwright.stages.fetch.urdf.gather import gather
from linkwright.stages.graph import build_robot
from linkwright.stages.mesh import make_geometry
from linkwright.stages.robot.errors import LinkwrightError
from linkwright.stages.robot.motion.start_pose import home
from tests.benchmarks.example_robots import SETTLES, installed
from tests.support.building import plan_of, write

SECONDS = 10.0

MARGIN = 0.01
"""How far [m] the centre of mass of a robot that can stand is from the edge of its footing."""

BASE, TILT, JOINT = 0.02, 0.05, 0.05
"""How far the base [m, rad] and the joints [rad, m] of a robot that stands may move: its feet give way a
little."""

KEYS = {"mesh": {"collider": "hull"}, "root": {"base": "free"}, "actuators": {"*": "position"}}

STANDING = {
    "a1_description/urdf/a1": "a1_description/srdf/a1 standing",
    "alexander_description/urdf/alexander_v1.lowerBodyOnly": "alexander_description/srdf/alexander default",
    "anymal_b_simple_description/robots/anymal": "anymal_b_simple_description/srdf/anymal standing",
    "anymal_b_simple_description/robots/anymal-kinova": (
        "anymal_b_simple_description/srdf/anymal-kinova standing_with_arm_up"
    ),
    "anymal_c_simple_description/urdf/anymal": "anymal_c_simple_description/srdf/anymal standing",
    "b1_description/urdf/b1": "b1_description/srdf/b1 standing",
    "b1_description/urdf/b1-z1": "b1_description/srdf/b1-z1 standing_with_arm_home",
    "bolt_description/robots/bolt": "bolt_description/srdf/bolt standing",
    "centauro_description/urdf/centauro": "centauro_description/srdf/centauro homing_nominal",
    "g1_description/urdf/g1_29dof_rev_1_0": "",
    "g1_description/urdf/g1_29dof_with_hand_rev_1_0": "",
    "go1_description/urdf/go1": "go1_description/srdf/go1 standing",
    "go2_description/urdf/go2": "go2_description/srdf/go2 standing",
    "human_description/robots/human": "",
    "hyq_description/robots/hyq_no_sensors": "hyq_description/srdf/hyq standing",
    "icub_description/robots/icub": "icub_description/srdf/icub half_sitting",
    "icub_description/robots/icub_reduced": "icub_description/srdf/icub half_sitting",
    "laikago_description/urdf/laikago": "",
    "quadruped_description/urdf/quadruped": "",
    "romeo_description/urdf/romeo": "romeo_description/srdf/romeo half_sitting",
    "romeo_description/urdf/romeo_laas_small": "romeo_description/srdf/romeo_small half_sitting",
    "romeo_description/urdf/romeo_small": "romeo_description/srdf/romeo_small half_sitting",
    "simple_humanoid_description/urdf/simple_humanoid": "",
    "simple_humanoid_description/urdf/simple_humanoid_classical": "",
    "solo_description/robots/solo": "solo_description/srdf/solo standing",
    "solo_description/robots/solo12": "solo_description/srdf/solo standing",
    "talos_data/robots/talos_full_v2": "talos_data/srdf/talos half_sitting",
    "talos_data/robots/talos_full_v2_box": "talos_data/srdf/talos half_sitting",
    "talos_data/robots/talos_reduced": "talos_data/srdf/talos half_sitting",
    "talos_data/robots/talos_reduced_box": "talos_data/srdf/talos half_sitting",
    "talos_data/robots/talos_reduced_corrected": "talos_data/srdf/talos half_sitting",
}
"""URDF of a robot on legs → its SRDF and the state in it, "" for none whose values the URDF allows."""


@dataclass(frozen=True, slots=True)
class Stand:
    """What became of a robot at one pose. `cannot`: why it cannot stand there, "" where it can; `moved`: what
    moved too far in the simulation, "" for nothing."""

    mass: float
    gains: tuple[float, float]
    armatures: tuple[float, float]
    base: float
    joint: float
    cannot: str
    moved: str


def main():
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("folder", nargs="?", type=Path, help="where example-robot-data lies")
    parser.add_argument("--only", default="", help="robots whose name has this in it")
    asked = parser.parse_args()
    share = asked.folder or installed()
    print(f"{'robot':36} {'pose':20} {'kg':>6} {'kp':>12} {'armature':>16} {'base':>9} {'joints':>9}")
    stood, unable, fell = 0, 0, 0
    for urdf, state in STANDING.items():
        if asked.only not in urdf:
            continue
        name = f"{urdf.split('_')[0]} {Path(urdf).name}"
        pose, outcome = _best(share, urdf, state)
        if isinstance(outcome, str):
            unable += 1
            print(f"{name:36} {'':20} not built: {outcome}", flush=True)
            continue
        stood += not (outcome.cannot or outcome.moved)
        unable += bool(outcome.cannot)
        fell += bool(outcome.moved and not outcome.cannot)
        print(_line(name, pose, outcome), flush=True)
    print(f"{stood} stand for {SECONDS:g} s; {unable} cannot, by the reasons above; {fell} can and do not")
    return 1 if fell else 0


def _line(name, pose, stand):
    figures = f"{name:36} {pose:20} {stand.mass:6.1f} {_span(stand.gains):>12} {_span(stand.armatures):>16}"
    if stand.cannot:
        return f"{figures} cannot stand: {stand.cannot}"
    end = stand.moved and f"FELL: {stand.moved}"
    return f"{figures} {1e3 * stand.base:6.1f} mm {1e3 * stand.joint:9.2f} {end}"


def _span(ends):
    return f"{ends[0]:.2g}..{ends[1]:.2g}"


def _best(share, urdf, state):
    """The first pose in which the robot stands, else the last, with what became of it."""
    place = next(share.rglob(f"{urdf}.urdf"))
    pose, outcome = "", None
    for pose, values in _poses(share, state):
        try:
            outcome = _tried(place, values)
        except LinkwrightError as error:
            return pose, str(error).splitlines()[0]
        if not outcome.cannot and not outcome.moved:
            break
    assert outcome is not None
    return pose, outcome


def _poses(share, state):
    """(name, values by joint): that of the SRDF, and zero."""
    if state:
        srdf, name = state.split()
        root = etree.parse(str(next(share.rglob(f"{srdf}.srdf")))).getroot()
        values = {
            joint.get("name"): joint.get("value").split()
            for group in root.iter("group_state")
            if group.get("name") == name
            for joint in group.iter("joint")
        }
        yield name, {joint: float(value[0]) for joint, value in values.items() if len(value) == 1}
    yield "zero", {}


def _tried(urdf, values):
    robot, bundle, source = _read(urdf, KEYS)
    limits = {dof.name: dof.limits for dof in robot.dofs}
    home = {name: limits[name].clip(value) for name, value in values.items() if name in limits}
    if home:
        robot, bundle, source = _read(urdf, {**KEYS, "keyframes": {"home": home}})
    plan = plan_of(source=source, **KEYS)
    geometry = make_geometry(robot, bundle, plan, lambda kind, key, make: make())
    with tempfile.TemporaryDirectory() as folder:
        exported = write(robot, Path(folder), plan, geometry)
        model = mujoco.MjModel.from_xml_path(f"{folder}/scene.xml")
    return _stand(robot, exported, model, _unsteady(robot, geometry, plan) or _weak(robot, exported))


def _read(urdf, keys):
    """The robot, its bundle, and the settings of the source that it takes."""
    source = {"kind": "urdf", "path": str(urdf)}
    while True:
        plan = plan_of(source=source, **keys)
        try:
            bundle, _ = gather(plan.source, {})
            return build_robot(bundle, plan), bundle, source
        except LinkwrightError as error:
            codes = {problem.code for problem in error.problems}
            settings = dict(SETTLES[start] for code in codes for start in SETTLES if code.startswith(start))
            if not settings or settings.items() <= source.items():
                raise
            source |= settings


def _stand(robot, exported, model, cannot):
    assert exported.written.actuation is not None
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, model.key("home").id)
    home = data.qpos.copy()
    if not cannot:
        mujoco.mj_step(model, data, round(SECONDS / model.opt.timestep))
    actuators, armatures = exported.written.actuation.actuators, exported.written.actuation.armatures
    turned = np.zeros(3)
    mujoco.mju_subQuat(turned, data.qpos[3:7].copy(), home[3:7].copy())
    base, tilt = float(np.linalg.norm(data.qpos[:3] - home[:3])), float(np.linalg.norm(turned))
    joints = np.abs(data.qpos[7:] - home[7:])
    far = [f"the base by {base:.2g} m"] if base > BASE else []
    far += [f"the base turned by {tilt:.2g} rad"] if tilt > TILT else []
    far += [
        f"{model.joint(joint).name} by {joints[at - 7]:.2g}"
        for joint, at in enumerate(model.jnt_qposadr.tolist())
        if at >= 7 and joints[at - 7] > JOINT
    ]
    gains = [actuator.kp for actuator in actuators if actuator.kp is not None]
    added = [armature.value for armature in armatures] or [0.0]
    return Stand(
        sum(link.inertial.mass for link in robot.links),
        (min(gains), max(gains)),
        (min(added), max(added)),
        base,
        float(joints.max()),
        cannot,
        ", ".join(far[:3]),
    )


def _unsteady(robot, geometry, plan):
    """Why forces of the ground do not hold the robot at home, and a little beside it; "" where they do."""
    if not geometry.shapes or all(shape.role != "collision" for shape in geometry.shapes):
        return "it has no colliders"
    standing, pose = stand(robot, geometry, plan), home(robot)
    contacts = list(ground_contacts(robot, geometry, standing.world_from_root, plan.ground, pose))
    points = np.array([point for _, point in contacts])
    up = standing.world_from_root[:3, :3].T @ [0.0, 0.0, 1.0]
    _, center = mass_and_center(robot, pose)
    links = sorted({link for link, _ in contacts})
    if not weight_shares(points, center, up).any():
        return f"its centre of mass is not above what touches the ground: {', '.join(links)}"
    around = [MARGIN * np.array([np.cos(angle), np.sin(angle), 0]) for angle in np.arange(16) * np.pi / 8]
    if not all(
        weight_shares(points, center + standing.world_from_root[:3, :3].T @ off, up).any() for off in around
    ):
        edge = f"its centre of mass is within {1e3 * MARGIN:g} mm of the edge of what touches the ground"
        return f"{edge}: {', '.join(links)}"
    return ""


def _weak(robot, exported):
    """The joints that need all of their effort, or more, at home."""
    assert exported.written.actuation is not None
    effort = {dof.name: dof.dynamics.effort for dof in robot.dofs}
    weak = [
        f"{actuator.name} holds no more than {limit:g} N m"
        for actuator in exported.written.actuation.actuators
        if (limit := effort[actuator.dof]) is not None
        and abs(actuator.force_at("home")) >= max(limit * (1.0 - 1e-9), 1e-6)
    ]
    return ", ".join(weak[:3])


if __name__ == "__main__":
    sys.exit(main())
