"""A robot as three readers see it: ours by its own kinematics, the peer's URDF and MJCF by two engines.

Link frames are each tool's own choice, so what is compared does not depend on them: masses, centres of
mass, inertia, axes and marked frames, all in the world, at any values of the joints.
"""

import xml.etree.ElementTree as ET
from dataclasses import dataclass, field

import mujoco
import numpy as np

from linkwright.stages.robot.model.poses import from_parts, rotation_from_rpy
from linkwright.stages.robot.motion.kinematics import link_poses
from tests.support.pinocchio import pin


@dataclass
class Seen:
    """In the world: {link: (mass [kg], centre of mass [m] (3,), inertia about it (3, 3))}, {joint: axis
    (3,)}, {frame: pose (4, 4)}."""

    links: dict[str, tuple[float, np.ndarray, np.ndarray]] = field(default_factory=dict)
    axes: dict[str, np.ndarray] = field(default_factory=dict)
    frames: dict[str, np.ndarray] = field(default_factory=dict)

    def add(self, link, pose, mass, com, inertia):
        turned = pose[:3, :3]
        self.links[link] = mass, pose[:3, :3] @ com + pose[:3, 3], turned @ inertia @ turned.T


def ours(robot, q):
    """Our robot; of a loop the origins of its two sides as the peer calls its frames."""
    poses = {name: robot.world_from_root @ pose for name, pose in link_poses(robot, q).items()}
    seen = Seen()
    for link in robot.links:
        inertial = link.inertial
        seen.add(link.name, poses[link.name], inertial.mass, inertial.com, inertial.inertia)
    for joint in robot.joints:
        for dof in joint.dofs:
            seen.axes[dof.name] = (poses[joint.parent] @ joint.parent_from_joint)[:3, :3] @ dof.axis
    for frame in robot.frames:
        seen.frames[frame.name] = poses[frame.link] @ frame.link_from_frame
    for loop in robot.loops:
        seen.frames[f"{loop.name}_1"] = poses[loop.link_a] @ loop.a_from_frame
        seen.frames[f"{loop.name}_2"] = poses[loop.link_b] @ loop.b_from_frame
    return seen


def of_urdf(text, q):
    """The peer's URDF; a frame there is a link X on a joint X_frame."""
    model = pin.buildModelFromXML(text)
    data = model.createData()
    values = pin.neutral(model)
    for name, value in q.items():
        joint = model.joints[model.getJointId(name)]
        turned = [np.cos(value), np.sin(value)] if joint.nq == 2 else [value]
        values[joint.idx_q : joint.idx_q + joint.nq] = turned
    pin.framesForwardKinematics(model, data, values)
    poses = {f.name: data.oMf[i].homogeneous for i, f in enumerate(model.frames) if f.type == pin.BODY}
    root = ET.fromstring(text)
    seen = Seen()
    joints = {joint.get("name") for joint in root.iter("joint")}
    for link in root.findall("link"):
        name = link.get("name")
        if f"{name}_frame" in joints:
            seen.frames[name] = poses[name]
            continue
        origin, inertia = link.find("inertial/origin"), link.find("inertial/inertia")
        xx, xy, xz, yy, yz, zz = (
            float(inertia.get(key)) for key in ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
        )
        turned = rotation_from_rpy(tuple(map(float, origin.get("rpy").split())))
        tensor = turned @ np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]) @ turned.T
        com = np.array([float(number) for number in origin.get("xyz").split()])
        seen.add(name, poses[name], float(link.find("inertial/mass").get("value")), com, tensor)
    for joint in root.iter("joint"):
        if joint.get("type") != "fixed":
            axis = np.array([float(number) for number in joint.find("axis").get("xyz").split()])
            seen.axes[joint.get("name")] = poses[joint.find("child").get("link")][:3, :3] @ axis
    return seen


def of_mjcf(text, q):
    """The peer's MJCF, without its meshes."""
    root = ET.fromstring(text)
    for parent in list(root.iter()):
        for child in list(parent):
            if child.tag in ("geom", "asset"):
                parent.remove(child)
    model = mujoco.MjModel.from_xml_string(ET.tostring(root, encoding="unicode"))
    data = mujoco.MjData(model)
    for name, value in q.items():
        data.joint(name).qpos[:] = value
    mujoco.mj_forward(model, data)
    seen = Seen()
    for number in range(1, model.nbody):
        name = model.body(number).name
        axes = data.ximat[number].reshape(3, 3)
        tensor = axes @ np.diag(model.body_inertia[number]) @ axes.T
        seen.links[name] = float(model.body_mass[number]), data.xipos[number].copy(), tensor
    for number in range(model.njnt):
        if model.jnt_type[number] != mujoco.mjtJoint.mjJNT_FREE:
            seen.axes[model.joint(number).name] = data.xaxis[number].copy()
    for number in range(model.nsite):
        rotation = data.site_xmat[number].reshape(3, 3)
        seen.frames[model.site(number).name] = from_parts(rotation, data.site_xpos[number])
    return seen


def limits_of(text):
    """{joint: (lower, upper)} of a URDF or an MJCF; None where it turns without end."""
    root = ET.fromstring(text)
    limits = {}
    for joint in root.iter("joint"):
        name, kind, limit = joint.get("name"), joint.get("type"), joint.find("limit")
        if name is None or kind == "fixed":
            continue
        if joint.get("range"):
            low, high = joint.get("range").split()
        elif limit is not None and limit.get("lower"):
            low, high = limit.get("lower"), limit.get("upper")
        else:
            limits[name] = None
            continue
        limits[name] = float(low), float(high)
    return limits


def differences(first, other):
    """How far two views are apart, by what they show: masses and inertia relative, the rest absolute.

    Frames count where both have them; KeyError where links or joints are not the same.
    """
    worst = {}
    for name in first.links.keys() | other.links.keys():
        (mass, com, inertia), (other_mass, other_com, other_inertia) = first.links[name], other.links[name]
        worst[f"mass of {name}"] = abs(mass - other_mass) / mass
        worst[f"centre of mass of {name}"] = float(np.abs(com - other_com).max())
        worst[f"inertia of {name}"] = float(np.abs(inertia - other_inertia).max() / np.abs(inertia).max())
    for name in first.axes.keys() | other.axes.keys():
        worst[f"axis of {name}"] = float(np.abs(first.axes[name] - other.axes[name]).max())
    for name in first.frames.keys() & other.frames.keys():
        worst[f"frame {name}"] = float(np.abs(first.frames[name] - other.frames[name]).max())
    return worst
