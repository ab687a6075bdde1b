"""An SDF, an MJCF and a URDF of one robot, compared by three readers: `tests.support.sdf` on the first,
MuJoCo and Pinocchio on the others. What the SDF calls a joint, and where its zero is, robot.json says.
"""

import json
from collections.abc import Iterator, Mapping
from pathlib import Path

import mujoco
import numpy as np
from scipy.spatial.transform import Rotation

from linkwright.stages.robot.model.robot import Robot, Value
from linkwright.stages.robot.motion.loops import POINTWISE
from linkwright.stages.robot.motion.start_pose import starting_point
from tests.support.engines import Mujoco, Pinocchio
from tests.support.robots import some_values
from tests.support.sdf import Sdf, axis_of

TOLERANCE = 1e-9
OPEN = 1e6
"""MuJoCo has no range that is open on one side: an end from here on stands for none."""


class Three:
    """The three readers of a robot's files, which lie in `folder`."""

    def __init__(self, robot: Robot, files: Mapping[str, bytes], folder: Path) -> None:
        self.robot = robot
        start = starting_point(robot)
        self.sdf = Sdf(files["robot.sdf"])
        self.mujoco = Mujoco(folder / "robot.xml", {dof.name: start[dof.name] for dof in robot.dofs})
        self.pinocchio = Pinocchio(files["robot.urdf"])
        told = json.loads(files["robot.json"])["sdf"]
        self.zeros, self.renamed = told["zeros"], told["renamed"]
        self.names = [dof.name for dof in robot.dofs]

    def agree(self, rng: np.random.Generator, poses: int = 3) -> None:
        """Everything that does not depend on loops."""
        for _ in range(poses):
            q = some_values(self.robot, rng)
            self.same_poses(q)
            if self.names:
                mass = self.sdf.mass_matrix(self.values(q), [self.joint(name) for name in self.names])
                # Where a loop has dofs of its own, a share of a link's mass is on a carrier in the MJCF.
                carried = any(loop.type not in POINTWISE for loop in self.robot.loops)
                for engine in (self.pinocchio,) if carried else (self.pinocchio, self.mujoco):
                    same(mass, engine.mass_matrix(q, self.names))
        self.same_masses()
        self.same_joints()
        self.same_relations(rng)

    def joint(self, name: str) -> str:
        return str(self.renamed["joints"].get(name, name))

    def link(self, name: str) -> str:
        return str(self.renamed["links"].get(name, name))

    def values(self, q: Mapping[str, Value]) -> dict[str, Value]:
        """Values of the robot's dofs as the SDF's joints count them."""
        found: dict[str, Value] = {}
        for name, value in q.items():
            zero = self.zeros.get(name)
            if zero is not None and isinstance(value, tuple):
                turned = rotation(zero).inv() * rotation(value)
                value = tuple(float(one) for one in np.roll(turned.as_quat(), 1))
            elif zero is not None:
                value -= zero
            found[self.joint(name)] = value
        return found

    def same_poses(self, q: Mapping[str, Value]) -> None:
        found = self.sdf.poses(self.values(q))
        for engine in (self.mujoco, self.pinocchio):
            expected = engine.poses(q)
            from_root = np.linalg.inv(expected[self.robot.root.name])
            for link in self.robot.links:
                same(found[self.link(link.name)], from_root @ expected[link.name])

    def same_masses(self) -> None:
        total = sum(float(node.findtext("inertial/mass")) for node in self.sdf.links.values())
        urdf = sum(one.mass for one in self.pinocchio.model.inertias)
        for other in (self.mujoco.model.body_mass.sum(), urdf):
            assert abs(total - other) < TOLERANCE * max(1.0, other)

    def same_joints(self) -> None:
        """Limits, effort, velocity, damping and friction of turns and slides."""
        for dof in self.robot.dofs:
            if dof.kind not in ("turn", "slide"):
                continue
            node, joint = self.sdf.joints[self.joint(dof.name)], self.mujoco.model.joint(dof.name)
            zero = self.zeros.get(dof.name, 0.0)
            ends = [end if end is None else end + zero for end in limits(node)]
            low, high = joint.range if joint.limited else (-np.inf, np.inf)
            for found, expected in zip(ends, (low, high), strict=True):
                assert (found is None) == (abs(expected) >= OPEN), dof.name
                assert found is None or abs(found - expected) < TOLERANCE * max(1.0, abs(expected))
            for key, values in (("damping", joint.damping), ("friction", joint.frictionloss)):
                assert float(node.findtext(f"axis/dynamics/{key}") or 0) == values[0]
            pinned = self.pinocchio.model.joints[self.pinocchio.model.getJointId(dof.name)]
            for key, bounds in (
                ("effort", self.pinocchio.model.effortLimit),
                ("velocity", self.pinocchio.model.velocityLimit),
            ):
                text = node.findtext(f"axis/limit/{key}")
                assert text is None or float(text) == bounds[pinned.idx_v]

    def same_relations(self, rng: np.random.Generator) -> None:
        """Where MuJoCo's equality of two joints holds, the SDF's mimic does."""
        model = self.mujoco.model
        mimics = {name: node.find("axis/mimic") for name, node in self.sdf.joints.items()}
        mimics = {name: node for name, node in mimics.items() if node is not None}
        assert len(mimics) == len(self.robot.relations)
        rows = np.flatnonzero(model.eq_type == mujoco.mjtEq.mjEQ_JOINT)
        assert len(rows) == len(mimics)
        for row in rows:
            pair = [model.joint(index).name for index in (model.eq_obj1id[row], model.eq_obj2id[row])]
            own = [self.joint(name) for name in pair]
            follower = own[0] if own[0] in mimics and mimics[own[0]].get("joint") == own[1] else own[1]
            node = mimics[follower]
            assert {follower, node.get("joint")} == set(own)
            numbers = [float(node.findtext(key)) for key in ("multiplier", "reference", "offset")]
            driver = float(rng.uniform(-1, 1))
            moved = {node.get("joint"): driver, follower: numbers[0] * (driver - numbers[1]) + numbers[2]}
            q = [moved[one] + self.zeros.get(name, 0.0) for one, name in zip(own, pair, strict=True)]
            first, second = (
                value - model.qpos0[model.joint(name).qposadr[0]] for value, name in zip(q, pair, strict=True)
            )
            expected = np.polynomial.polynomial.polyval(second, model.eq_data[row][:5])
            assert abs(first - expected) < TOLERANCE * max(1.0, abs(expected))

    def close_again(self, rng: np.random.Generator) -> bool:
        """Whether MuJoCo finds another pose in which all loops are closed; there they are in the SDF."""
        q = self.closed_pose(rng)
        if q is None:
            return False
        self.same_poses({name: q[name] for name in self.names})
        values = self.values(q)
        for name in self.sdf.loops:
            assert self.sdf.joints[name].findtext("child") != self.link(self.robot.root.name)
            free = {one: value for one, value in values.items() if one not in self.sdf.loops}
            first, second = self.sdf.ends(name, free)
            assert stays(self.sdf.joints[name], np.linalg.inv(first) @ second), name
        return True

    def closed_pose(self, rng: np.random.Generator) -> dict[str, Value] | None:
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

    def _values_in(self, qpos: np.ndarray) -> Iterator[tuple[str, Value]]:
        dofs = [*self.robot.dofs, *(dof for loop in self.robot.loops for dof in loop.dofs)]
        for dof in dofs:
            if mujoco.mj_name2id(self.mujoco.model, mujoco.mjtObj.mjOBJ_JOINT, dof.name) < 0:
                continue
            at = self.mujoco.model.joint(dof.name).qposadr[0]
            if dof.kind == "ball":
                turned = rotation(self.mujoco.start[dof.name]) * rotation(qpos[at : at + 4])
                yield dof.name, tuple(float(one) for one in np.roll(turned.as_quat(), 1))
            else:
                yield dof.name, float(qpos[at])


def stays(joint: object, moved: np.ndarray) -> bool:
    """Whether this joint of an SDF, alone, moves its frame so (4, 4)."""
    kind, axis = joint.get("type"), axis_of(joint)
    place, turned = moved[:3, 3], Rotation.from_matrix(moved[:3, :3]).as_rotvec()
    if kind == "prismatic":
        place = place - axis * (axis @ place)
    if kind == "ball":
        turned = np.zeros(3)
    elif kind in ("revolute", "continuous"):
        turned = turned - axis * (axis @ turned)
    return max(np.abs(place).max(), np.abs(turned).max()) < TOLERANCE


def limits(joint: object) -> tuple[float | None, float | None]:
    """The ends of an SDF joint's range; None where it is open."""
    low, high = (joint.findtext(f"axis/limit/{key}") for key in ("lower", "upper"))
    return None if low is None else float(low), None if high is None else float(high)


def rotation(quat: object) -> Rotation:
    return Rotation.from_quat(np.roll(np.asarray(quat, dtype=float), -1))


def same(found: np.ndarray, expected: np.ndarray) -> None:
    """Equal to 1e-9 on the scale of the larger of 1 and the largest entry."""
    scale = max(1.0, float(np.abs(expected).max()))
    assert np.abs(found - expected).max() < TOLERANCE * scale
