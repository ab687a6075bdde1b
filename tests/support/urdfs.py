"""URDFs as sources in tests: from a text to a robot, and held against Pinocchio's reading of that text.

What the reader changes on purpose, and tells, is changed in the text that Pinocchio reads too: inertias
that were mended, and masses of links that move without any.
"""

import math
from dataclasses import dataclass
from hashlib import sha256

import numpy as np
from lxml import etree

from linkwright.stages.graph import build_robot
from linkwright.stages.robot.bundle import FileBundle
from linkwright.stages.robot.codec import decode_robot, encode_robot
from tests.support.building import plan_of
from tests.support.engines import Mujoco, Pinocchio

SCALAR = ("revolute", "continuous", "prismatic")


def urdf_bundle(text, policy="refuse", meshes=None, srdf=b""):
    """The bundle of a URDF's text; `meshes`: triangles in the compact form by mesh key; `srdf`: the text of
    an SRDF beside it, empty without one."""
    bodies = {"robot.urdf": text, **{f"mesh/{key}": data for key, data in (meshes or {}).items()}}
    bodies |= {"robot.srdf": srdf} if srdf else {}
    requests = {request: sha256(data).hexdigest() for request, data in bodies.items()}
    return FileBundle(
        kind="urdf",
        root={"document": "robot.urdf", "microversion": "m", "element": "", "configuration": ""},
        definition=requests["robot.urdf"],
        requests=requests,
        blobs={requests[request]: data for request, data in bodies.items()},
        options={"bad_inertia": policy},
    )


def urdf_robot(text, plan=None, policy="refuse", srdf=""):
    """The robot that the graph stage makes of a URDF and the SRDF beside it, once through the codec."""
    data = text.encode() if isinstance(text, str) else text
    bundle = urdf_bundle(data, policy, srdf=srdf.encode())
    return decode_robot(encode_robot(build_robot(bundle, plan or plan_of())))


@dataclass(frozen=True, slots=True)
class Apart:
    """How far files are from the URDF that they were made of: poses [m, and of rotation matrices], mass
    matrix and gravity torque on the scale of the larger of 1 and their largest entry."""

    poses: float
    mass_matrix: float
    gravity: float

    @property
    def worst(self):
        return max(self.poses, self.mass_matrix, self.gravity)


def parity(text, robot, files, folder, count=3):
    """The exported URDF by Pinocchio and the MJCF in `folder` by MuJoCo, against Pinocchio on `text`, at
    `count` random values of all joints; links, frames and joints by the names that the file has."""
    original = Pinocchio(as_told(text, robot))
    found = (Pinocchio(files[f"{robot.name}.urdf"]), Mujoco(folder / f"{robot.name}.xml"))
    random = np.random.default_rng(7)
    scalars = {
        dof.name: joint.mate.name
        for joint in robot.joints
        for dof in joint.dofs
        if dof.kind in ("turn", "slide")
    }
    ours, theirs = list(scalars), list(scalars.values())
    apart = np.zeros(3)
    for _ in range(count):
        q = {name: float(random.uniform(-2, 2)) for name in ours}
        true_q = {scalars[name]: value for name, value in q.items()}
        true_poses = original.poses(true_q)
        base = np.linalg.inv(true_poses[robot.root.path[0]])
        for engine in found:
            poses = engine.poses(q)
            root = np.linalg.inv(poses[robot.root.name])
            for link in robot.links:
                off = root @ poses[link.name] - base @ true_poses[link.path[0]]
                apart[0] = max(apart[0], np.abs(off).max())
            for frame in robot.frames:
                off = root @ poses[frame.link] @ frame.link_from_frame - base @ true_poses[frame.source]
                apart[0] = max(apart[0], np.abs(off).max())
            if ours:
                apart[1] = max(
                    apart[1], relative(engine.mass_matrix(q, ours), original.mass_matrix(true_q, theirs))
                )
                apart[2] = max(apart[2], relative(engine.gravity(q, ours), original.gravity(true_q, theirs)))
    return Apart(*map(float, apart))


def relative(actual, expected):
    return float(np.abs(actual - expected).max() / max(1.0, np.abs(expected).max()))


def as_told(text, robot):
    """The URDF with the inertials that the robot's diagnostics say were changed; without what else
    keeps Pinocchio from reading it: shapes."""
    root = etree.fromstring(text)
    estimated = {d.where for d in robot.diagnostics if d.code in ("W-INERTIA", "W-INERTIA-LEAST")}
    carried = [d for d in robot.diagnostics if d.code.endswith("-URDF-MASSLESS")]
    estimated |= {name for d in carried for name in d.message.rsplit(": ", 1)[1].split(", ")}
    links = {link.path[0]: link for link in robot.links if link.path}
    merged = {frame.source: frame.link for frame in robot.frames}
    for node in root.findall("link"):
        name = node.get("name")
        link = links.get(name)
        into = merged.get(name)
        changed = link is not None and name in estimated
        carried_by = next((link for link in robot.links if link.name == into), None)
        if changed or (carried_by is not None and carried_by.path[0] in estimated):
            for old in node.findall("inertial"):
                node.remove(old)
        if changed and link is not None:
            _write(node, link.inertial)
        for shape in (*node.findall("visual"), *node.findall("collision")):
            node.remove(shape)
    return etree.tostring(root)


def _write(node, inertial):
    if inertial.mass == 0:
        return
    holder = etree.SubElement(node, "inertial")
    etree.SubElement(holder, "origin", xyz=" ".join(map(repr, map(float, inertial.com))))
    etree.SubElement(holder, "mass", value=repr(inertial.mass))
    i = inertial.inertia
    numbers = {"ixx": i[0, 0], "ixy": i[0, 1], "ixz": i[0, 2], "iyy": i[1, 1], "iyz": i[1, 2], "izz": i[2, 2]}
    etree.SubElement(holder, "inertia", **{key: repr(float(value)) for key, value in numbers.items()})


def same_bounds(text, robot, urdf):
    """What the exported URDF has otherwise than `text`: ranges, effort, velocity and mimics, by joint.

    A range that the file leaves out, bounds at zero and placeholders are none, which the reader tells."""
    names = {joint.name: joint.mate.name for joint in robot.joints}
    theirs, ours = _bounds(text), _bounds(urdf)
    wrong = []
    for name, true_name in names.items():
        if name not in ours:
            continue
        for key, value in theirs[true_name].items():
            found = ours[name].get(key)
            if found is None or abs(found - value) > 1e-9 * max(1.0, abs(value)):
                wrong.append(f"{true_name}: {key} is {found}, not {value}")
    true_mimics = {name: (names_of(robot)[driver], *rest) for name, (driver, *rest) in _mimics(text).items()}
    mimics = {names[name]: value for name, value in _mimics(urdf).items()}
    for name, (driver, factor, offset) in true_mimics.items():
        other = mimics.get(name, ("", math.nan, math.nan))
        fits = other[0] == driver and abs(other[1] - factor) + abs(other[2] - offset) < 1e-9
        if not fits:
            wrong.append(f"{name}: mimic is {other}")
    return wrong if len(mimics) == len(true_mimics) else [*wrong, "the number of mimics"]


def lost_names(text, urdf):
    """The links and joints of `text` that the exported URDF lacks by name, as "joint elbow"."""
    before, after = (
        {f"{node.tag} {node.get('name')}" for node in etree.fromstring(data).iterfind("*")}
        for data in (text, urdf)
    )
    return sorted(name for name in before - after if name.startswith(("link ", "joint ")))


def names_of(robot):
    """The robot's name of each joint by the file's."""
    return {joint.mate.name: joint.name for joint in robot.joints}


_STAND_INS = (1e3, 1e4, 1e5, 1e6)
"""Efforts and velocities of turns that stand for none."""


def _bounds(text):
    found = {}
    for node in etree.fromstring(text).findall("joint"):
        if node.get("type") not in SCALAR:
            found[node.get("name")] = {}
            continue
        limit = node.find("limit")
        bounds = {} if limit is None else {key: float(value) for key, value in limit.attrib.items()}
        own = {
            key: bounds[key]
            for key in ("effort", "velocity")
            if bounds.get(key, 0) > 0 and bounds[key] not in _STAND_INS
        }
        low, high = bounds.get("lower", 0.0), bounds.get("upper", 0.0)
        stands_in = low == -high and high in (10.0, 100.0, 1000.0, 1e16)
        if node.get("type") in ("revolute", "prismatic") and limit is not None and (low, high) != (0, 0):
            # A joint whose range is nothing keeps the play that engines need.
            play = 1e-6 if low == high else 0.0
            own |= {} if stands_in else {"lower": low - play, "upper": high + play}
        for key in ("damping", "friction"):
            dynamics = node.find("dynamics")
            if dynamics is not None and dynamics.get(key) is not None:
                own[key] = float(dynamics.get(key))
        found[node.get("name")] = own
    return found


def _mimics(text):
    """Each follower's driver, factor and offset, of a chain the last driver's."""
    direct = {}
    for node in etree.fromstring(text).findall("joint"):
        mimic = node.find("mimic")
        if mimic is not None and node.get("type") in SCALAR:
            numbers = float(mimic.get("multiplier", "1")), float(mimic.get("offset", "0"))
            direct[node.get("name")] = (mimic.get("joint"), *numbers)
    whole = {}
    for name, (driver, factor, offset) in direct.items():
        while driver in direct:
            driver, more, shift = direct[driver]
            factor, offset = factor * more, factor * shift + offset
        whole[name] = driver, factor, offset
    return whole
