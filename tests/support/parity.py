"""The harness of the parity tests: a robot's file of any format by a reader of its own, beside the MJCF by
MuJoCo and the URDF by Pinocchio. What the file calls a link or joint, and where its zero is, robot.json says.
"""

import json
from typing import Any, ClassVar

import mujoco
import numpy as np
from scipy.spatial.transform import Rotation

from linkwright.stages.robot.motion.loops import POINTWISE_TYPES
from linkwright.stages.robot.motion.start_pose import starting_point
from tests.support.engines import Mujoco, Pinocchio
from tests.support.robots import some_values
from tests.support.sdf import Sdf, axis_of
from tests.support.usd import Usd, complaints, stage_of

OPEN = 1e6
"""MuJoCo has no range that is open on one side: an end from here on stands for none."""


def same(actual, expected, tolerance=1e-9):
    """Equal to the tolerance on the scale of the larger of 1 and the largest entry."""
    scale = max(1.0, float(np.abs(expected).max()))
    assert np.abs(actual - expected).max() < tolerance * scale


class Parity:
    """The three readers of a robot's files, which are in `folder`.

    A format adds its `reader` and what is read of the file: the total mass, the `limits` of a joint (infinite
    where it is open), whether its dynamics are those of MuJoCo's joint (`same_dynamics`), its relations
    (`count_of_relations`, `same_relation` at values of both), and whether loops are `closed` at a pose.
    """

    format: ClassVar[str]
    tolerance = 1e-9
    reader: Any

    def __init__(self, robot, files, folder):
        self.robot = robot
        start = starting_point(robot)
        self.mujoco = Mujoco(folder / f"{robot.name}.xml", {dof.name: start[dof.name] for dof in robot.dofs})
        self.pinocchio = Pinocchio(files[f"{robot.name}.urdf"])
        table = json.loads(files["robot.json"]).get(self.format, {})
        self.zeros, self.renamed = table.get("zeros", {}), table.get("renamed", {})
        self.names = [dof.name for dof in robot.dofs]

    def agree(self, rng, poses=3):
        """Everything that does not depend on loops."""
        for _ in range(poses):
            q = some_values(self.robot, rng)
            self.same_poses(q)
            if self.names:
                mass = self.reader.mass_matrix(self.values(q), [self.joint(name) for name in self.names])
                # Where a loop has dofs of its own, a share of a link's mass is on a carrier in the MJCF.
                carried = any(loop.type not in POINTWISE_TYPES for loop in self.robot.loops)
                for engine in (self.pinocchio,) if carried else (self.pinocchio, self.mujoco):
                    same(mass, engine.mass_matrix(q, self.names), self.tolerance)
        urdf = sum(inertia.mass for inertia in self.pinocchio.model.inertias)
        for total in (self.mujoco.model.body_mass.sum(), urdf):
            self.near(self.total_mass(), total)
        self.same_joints()
        self.same_relations(rng)

    def near(self, actual, expected, size=0.0):
        assert abs(actual - expected) < self.tolerance * max(1.0, abs(expected), size)

    def joint(self, name):
        return str(self.renamed.get("joints", {}).get(name, name))

    def link(self, name):
        return str(self.renamed.get("links", {}).get(name, name))

    def values(self, q):
        """Values of the robot's dofs as the file's joints count them."""
        by_joint = {}
        for name, value in q.items():
            zero = self.zeros.get(name)
            if zero is not None and isinstance(value, tuple):
                turned = rotation(zero).inv() * rotation(value)
                value = tuple(float(number) for number in np.roll(turned.as_quat(), 1))
            elif zero is not None:
                value -= zero
            by_joint[self.joint(name)] = value
        return by_joint

    def same_poses(self, q):
        """The poses by the file's own names of the links, as MuJoCo and Pinocchio have them, too."""
        actual = self.reader.poses(self.values(q))
        for engine in (self.mujoco, self.pinocchio):
            expected = engine.poses(q)
            moved = self.root_of(actual) @ np.linalg.inv(expected[self.robot.root.name])
            for link in self.robot.links:
                same(actual[self.link(link.name)], moved @ expected[link.name], self.tolerance)
        return actual

    def same_joints(self):
        """Limits and dynamics of turns and slides."""
        for dof in self.robot.dofs:
            if dof.kind not in ("turn", "slide"):
                continue
            joint = self.mujoco.model.joint(dof.name)
            zero = self.zeros.get(dof.name, 0.0)
            ends = joint.range if joint.limited else (-np.inf, np.inf)
            for end, expected in zip(self.limits(self.joint(dof.name)), ends, strict=True):
                assert np.isinf(end) == (abs(expected) >= OPEN), dof.name
                if np.isfinite(end):
                    self.near(end + zero, expected)
            self.same_dynamics(dof, joint)

    def same_relations(self, rng):
        """Where MuJoCo's equality of two joints holds, the file's own relations do."""
        model = self.mujoco.model
        rows = np.flatnonzero(model.eq_type == mujoco.mjtEq.mjEQ_JOINT)
        assert len(rows) == len(self.robot.relations) == self.count_of_relations()
        relations = {relation.name: relation for relation in self.robot.relations}
        for row in rows:
            relation = relations[model.equality(row).name]
            pair = relation.follower, relation.driver
            q = {relation.driver: float(rng.uniform(-1, 1))}
            first, second = (model.joint(end).name for end in (model.eq_obj1id[row], model.eq_obj2id[row]))
            start = {name: model.qpos0[model.joint(name).qposadr[0]] for name in pair}
            offset, slope, *higher = model.eq_data[row][:5]
            assert not any(higher)
            if first == relation.follower:
                moved = offset + slope * (q[second] - start[second])
            else:
                moved = (q[first] - start[first] - offset) / slope
            q[relation.follower] = start[relation.follower] + moved
            self.same_relation(*pair, q)

    def close_again(self, rng):
        """Whether MuJoCo finds another pose in which all loops are closed; there they are in the file."""
        q = self.closed_pose(rng)
        if q is not None:
            self.closed(q, self.same_poses({name: q[name] for name in self.names}))
        return q is not None

    def closed_pose(self, rng):
        """The values of all dofs, of loops too, in a pose that Newton's method finds."""
        model, data = self.mujoco.model, self.mujoco.data
        model.opt.jacobian = mujoco.mjtJacobian.mjJAC_DENSE
        model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONTACT | mujoco.mjtDisableBit.mjDSBL_LIMIT
        for reach in (0.3, 0.1, 0.03):
            mujoco.mj_resetData(model, data)
            mujoco.mj_integratePos(model, data.qpos, rng.uniform(-reach, reach, model.nv), 1.0)
            for _ in range(60):
                mujoco.mj_forward(model, data)
                rows = np.flatnonzero(data.efc_type == mujoco.mjtConstraint.mjCNSTR_EQUALITY)
                off = data.efc_pos[rows]
                if np.abs(off).max(initial=0.0) < 1e-13:
                    break
                jacobian = data.efc_J.reshape(data.nefc, model.nv)[rows]
                mujoco.mj_integratePos(model, data.qpos, -np.linalg.pinv(jacobian, 1e-9) @ off, 1.0)
            if np.abs(off).max(initial=0.0) < 1e-11 and np.abs(data.qpos - model.qpos0).max() > 1e-3:
                return dict(self._values_in(data.qpos))
        return None

    def _values_in(self, qpos):
        dofs = [*self.robot.dofs, *(dof for loop in self.robot.loops for dof in loop.dofs)]
        for dof in dofs:
            if mujoco.mj_name2id(self.mujoco.model, mujoco.mjtObj.mjOBJ_JOINT, dof.name) < 0:
                continue
            at = self.mujoco.model.joint(dof.name).qposadr[0]
            if dof.kind == "ball":
                turned = rotation(self.mujoco.start[dof.name]) * rotation(qpos[at : at + 4])
                yield dof.name, tuple(float(number) for number in np.roll(turned.as_quat(), 1))
            else:
                yield dof.name, float(qpos[at])

    def root_of(self, poses):
        """Where the root is among the poses of the file."""
        return poses[self.link(self.robot.root.name)]


class SdfParity(Parity):
    """The SDF by `tests.support.sdf`."""

    format = "sdf"

    def __init__(self, robot, files, folder):
        super().__init__(robot, files, folder)
        self.reader = Sdf(files[f"{robot.name}.sdf"])

    def root_of(self, poses):
        return np.eye(4)

    def total_mass(self):
        return sum(float(node.findtext("inertial/mass")) for node in self.reader.links.values())

    def limits(self, joint):
        low, high = (self.reader.joints[joint].findtext(f"axis/limit/{key}") for key in ("lower", "upper"))
        return float(low or "-inf"), float(high or "inf")

    def same_dynamics(self, dof, joint):
        node, model = self.reader.joints[self.joint(dof.name)], self.pinocchio.model
        for key, values in (("damping", joint.damping), ("friction", joint.frictionloss)):
            assert float(node.findtext(f"axis/dynamics/{key}") or 0) == values[0]
        pinned = model.joints[model.getJointId(dof.name)].idx_v
        for key, bounds in (("effort", model.effortLimit), ("velocity", model.velocityLimit)):
            text = node.findtext(f"axis/limit/{key}")
            assert text is None or float(text) == bounds[pinned]

    def count_of_relations(self):
        return sum(node.find("axis/mimic") is not None for node in self.reader.joints.values())

    def same_relation(self, follower, driver, q):
        values = self.values(q)
        nodes = {name: self.reader.joints[name].find("axis/mimic") for name in values}
        (mimic,) = (name for name, node in nodes.items() if node is not None and node.get("joint") in values)
        node = nodes[mimic]
        assert {mimic, node.get("joint")} == set(values)
        numbers = [float(node.findtext(key)) for key in ("multiplier", "reference", "offset")]
        followed = numbers[0] * (values[node.get("joint")] - numbers[1]) + numbers[2]
        self.near(followed, values[mimic])

    def closed(self, q, poses):
        free = {name: value for name, value in self.values(q).items() if name not in self.reader.loops}
        for name in self.reader.loops:
            joint = self.reader.joints[name]
            assert joint.findtext("child") != self.link(self.robot.root.name)
            first, second = self.reader.ends(name, free)
            assert stays(joint, np.linalg.inv(first) @ second, self.tolerance), name


class UsdParity(Parity):
    """The USD by `tests.support.usd`, in single precision."""

    format = "usd"
    tolerance = 1e-5

    def __init__(self, robot, files, folder):
        super().__init__(robot, files, folder)
        stage = stage_of(files, folder, robot.name)
        assert complaints(stage) == []
        self.reader = Usd(stage)

    def total_mass(self):
        return sum(self.reader.mass(body)[0] for body in self.reader.bodies)

    def limits(self, joint):
        return self.reader.limits(joint)

    def same_dynamics(self, dof, joint):
        name, model = self.joint(dof.name), self.mujoco.model
        scale = 180 / np.pi if dof.kind == "turn" else 1.0
        own = {"armature": joint.armature, "damping": joint.damping / scale, "friction": joint.frictionloss}
        for key, values in own.items():
            self.near(self.reader.value(name, f"newton:{key}") or 0.0, values[0])
        if model.jnt_actfrclimited[joint.id]:
            kind = "angular" if dof.kind == "turn" else "linear"
            force = self.reader.value(name, f"drive:{kind}:physics:maxForce")
            self.near(model.jnt_actfrcrange[joint.id][1], force)

    def count_of_relations(self):
        return sum(bool(self._mimics(name)) for name in self.reader.joints)

    def _mimics(self, joint):
        schemas = self.reader.schemas(self.reader.joints[joint].GetPrim())
        return [schema for schema in schemas if schema.startswith("PhysxMimicJointAPI:")]

    def same_relation(self, follower, driver, q):
        """Those of PhysX and of Newton."""
        kinds = {dof.name: dof.kind for dof in self.robot.dofs}
        ahead, behind = (np.degrees(q[n]) if kinds[n] == "turn" else q[n] for n in (follower, driver))
        own, other, size = self.joint(follower), self.joint(driver), max(abs(ahead), abs(behind))
        (mimic,) = self._mimics(own)
        before = f"physxMimicJoint:{mimic.partition(':')[2]}"
        gearing, offset = (self.reader.value(own, f"{before}:{key}") for key in ("gearing", "offset"))
        assert self.reader.target(own, f"{before}:referenceJoint") == other
        self.near(ahead + gearing * behind + offset, 0.0, size)
        if kinds[follower] == kinds[driver]:
            zero, slope = (self.reader.value(own, f"newton:mimicCoef{number}") for number in (0, 1))
            self.near(ahead - zero - slope * behind, 0.0, size)
            assert self.reader.target(own, "newton:mimicJoint") == other

    def closed(self, q, poses):
        """The values of the loops' own chains may be among `q`."""
        chains = {name: value for name, value in self.values(q).items() if name in self.reader.joints}
        everything = {**poses, **self.reader.poses(chains)}
        for name in self.reader.loops:
            assert self.reader.gap(name, everything) < self.tolerance


def stays(joint, moved, tolerance):
    """Whether this joint of an SDF, alone, moves its frame so (4, 4)."""
    kind, axis = joint.get("type"), axis_of(joint)
    place, turned = moved[:3, 3], Rotation.from_matrix(moved[:3, :3]).as_rotvec()
    if kind == "prismatic":
        place = place - axis * (axis @ place)
    if kind == "ball":
        turned = np.zeros(3)
    elif kind in ("revolute", "continuous"):
        turned = turned - axis * (axis @ turned)
    return bool(max(np.abs(place).max(), np.abs(turned).max()) < tolerance)


def rotation(quat):
    return Rotation.from_quat(np.roll(np.asarray(quat, dtype=float), -1))
