"""An SDF as a reader of its own has it: poses by `relative_to`, and a Pinocchio model made by hand.

Nothing of the product is used. Joints count from the pose in which the file's links stand; the joint that
comes second to a link closes a loop, and does not belong to the tree.
"""

import numpy as np
from lxml import etree
from scipy.spatial.transform import Rotation

from tests.support.pinocchio import pin


class Sdf:
    """The model of an SDF's text, its root held where the model is."""

    def __init__(self, text):
        self.root = etree.fromstring(text)
        (self.top,) = self.root.findall("model")
        self.links = {link.get("name"): link for link in self.top.findall("link")}
        self.joints = {joint.get("name"): joint for joint in self.top.findall("joint")}
        self.frames = {frame.get("name"): frame for frame in self.top.findall("frame")}
        every = [*self.links, *self.joints, *self.frames]
        assert len(set(every)) == len(every), "a name is taken twice"
        for node in self.root.iter():
            names = [element.get("name") for element in node if element.get("name") is not None]
            assert len(set(names)) == len(names), (node.tag, names)
        self._places = {}
        self.loops = []
        self.model = pin.Model()
        self._frames = {0: np.eye(4)}
        self._held = {}
        self._build()
        self.data = self.model.createData()

    def place(self, name):
        """model_from_frame (4, 4) of a link, joint or frame as the file has it."""
        if name in ("", "__model__"):
            return np.eye(4)
        if name not in self._places:
            if name in self.links:
                node, unless = self.links[name], ""
            elif name in self.joints:
                node = self.joints[name]
                unless = node.findtext("child")
            else:
                node = self.frames[name]
                unless = node.get("attached_to")
            self._places[name] = self._pose(node, unless)
        return self._places[name]

    def _pose(self, node, unless):
        pose = node.find("pose")
        above = self.place((pose.get("relative_to") if pose is not None else None) or unless)
        return above if pose is None else above @ transform(pose.text)

    def _build(self):
        waiting = list(self.joints)
        held = {node.findtext("child") for node in self.joints.values()}
        for name in self.links:
            if name not in held:
                canonical = name == self.top.get("canonical_link")
                number = 0 if canonical else self._add(0, pin.JointModelFreeFlyer(), self.place(name), name)
                self._carry(name, number, self.place(name))
        while waiting:
            # The first in the file that hangs on something.
            name = next(joint for joint in waiting if self._above(joint) in (*self._held, "world"))
            waiting.remove(name)
            self._join(name)

    def _above(self, joint):
        return str(self.joints[joint].findtext("parent"))

    def _join(self, name):
        node, child, place = self.joints[name], self.joints[name].findtext("child"), self.place(name)
        if child in self._held:
            self.loops.append(name)
            return
        above = 0 if self._above(name) == "world" else self._held[self._above(name)][0]
        kind = node.get("type")
        if kind == "fixed":
            self._carry(child, above, self.place(child))
            return
        axis = axis_of(node)
        made = {
            "ball": pin.JointModelSpherical,
            "prismatic": lambda: pin.JointModelPrismaticUnaligned(axis),
        }.get(kind, lambda: pin.JointModelRevoluteUnaligned(axis))
        assert kind in ("ball", "prismatic", "revolute", "continuous"), kind
        self._carry(child, self._add(above, made(), place, name), self.place(child))

    def _add(self, above, kind, place, name):
        # Pinocchio's joints are placed in the frame of the joint above.
        number = self.model.addJoint(above, kind, pin.SE3(np.linalg.inv(self._frames[above]) @ place), name)
        self._frames[number] = place
        return int(number)

    def _carry(self, link, number, place):
        in_joint = np.linalg.inv(self._frames[number]) @ place
        self._held[link] = number, in_joint
        inertial = self.links[link].find("inertial")
        keys = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
        get = {key: float(inertial.findtext(f"inertia/{key}")) for key in keys}
        tensor = np.array(
            [
                [get["ixx"], get["ixy"], get["ixz"]],
                [get["ixy"], get["iyy"], get["iyz"]],
                [get["ixz"], get["iyz"], get["izz"]],
            ]
        )
        com = transform(inertial.findtext("pose"))
        tensor = com[:3, :3] @ tensor @ com[:3, :3].T
        body = pin.Inertia(float(inertial.findtext("mass")), com[:3, 3], tensor)
        self.model.appendBodyToJoint(number, body, pin.SE3(in_joint))

    def _q(self, values):
        q = pin.neutral(self.model)
        for name, value in values.items():
            joint = self.model.joints[self.model.getJointId(name)]
            numbers = [value] if not isinstance(value, tuple) else [*value[:-4], *value[-3:], value[-4]]
            assert joint.nq == len(numbers), name
            q[joint.idx_q : joint.idx_q + joint.nq] = numbers
        return q

    def poses(self, values):
        """model_from_link (4, 4) of the links."""
        pin.forwardKinematics(self.model, self.data, self._q(values))
        return {link: self.data.oMi[joint].homogeneous @ at for link, (joint, at) in self._held.items()}

    def ends(self, joint, values):
        """model_from_frame (4, 4) of a joint's frame as its parent has it, and as its child has it."""
        moved, at = self.poses(values), self.place(joint)
        parent, child = self._above(joint), self.joints[joint].findtext("child")
        first, second = (moved[link] @ np.linalg.inv(self.place(link)) @ at for link in (parent, child))
        return first, second

    def mass_matrix(self, values, joints):
        """(n, n) of the speeds of these joints; a ball's is its angular velocity in the child's axes."""
        upper = np.triu(pin.crba(self.model, self.data, self._q(values)))
        full = upper + np.triu(upper, 1).T
        order = []
        for name in joints:
            joint = self.model.joints[self.model.getJointId(name)]
            order += range(joint.idx_v, joint.idx_v + joint.nv)
        return full[np.ix_(order, order)]


def transform(text):
    """The (4, 4) transform of an SDF's pose: x y z roll pitch yaw."""
    numbers = np.array([float(word) for word in (text or "").split()])
    pose = np.eye(4)
    pose[:3, :3] = Rotation.from_euler("xyz", numbers[3:]).as_matrix()
    pose[:3, 3] = numbers[:3]
    return pose


def axis_of(node):
    """The axis (3,) of a joint, in its own frame."""
    text = node.findtext("axis/xyz")
    return None if text is None else np.array([float(word) for word in text.split()])
