"""A USD, an MJCF and a URDF of one robot, compared by three readers: `tests.support.usd` on the first, MuJoCo
and Pinocchio on the others. What the USD calls a link or joint, robot.json says."""

import json
from collections.abc import Mapping, Sequence
from pathlib import Path

import mujoco
import numpy as np
from scipy.spatial.transform import Rotation

from linkwright.stages.robot.model.robot import Robot, Value
from linkwright.stages.robot.motion.loops import POINTWISE
from linkwright.stages.robot.motion.start_pose import starting_point
from tests.support.engines import Mujoco, Pinocchio
from tests.support.robots import some_values
from tests.support.usd import Usd, complaints, stage_of

TOLERANCE = 1e-5
"""Of single precision, on the scale of the largest entry, at least 1."""

OPEN = 1e6
"""MuJoCo has no range that is open on one side: an end from here on stands for none."""


class UsdParity:
    """The three readers of a robot's files, which are written into `folder`."""

    def __init__(self, robot: Robot, files: Mapping[str, bytes], folder: Path) -> None:
        self.robot = robot
        start = starting_point(robot)
        stage = stage_of(files, folder, robot.name)
        assert complaints(stage) == []
        self.usd = Usd(stage)
        self.mujoco = Mujoco(folder / f"{robot.name}.xml", {dof.name: start[dof.name] for dof in robot.dofs})
        self.pinocchio = Pinocchio(files[f"{robot.name}.urdf"])
        told = json.loads(files["robot.json"]).get("usd", {})
        renamed, self.zeros = told.get("renamed", {}), told.get("zeros", {})
        self.links, self.joints = renamed.get("links", {}), renamed.get("joints", {})
        self.names = [dof.name for dof in robot.dofs]

    def agree(self, rng: np.random.Generator, poses: int = 2) -> None:
        """Everything that does not depend on loops."""
        for _ in range(poses):
            q = some_values(self.robot, rng)
            self.same_poses(q)
            if self.names:
                order = [self.joints.get(name, name) for name in self.names]
                mass = self.usd.mass_matrix(self.values(q), order)
                # Where a loop has dofs of its own, a share of a link's mass is on a carrier in the MJCF.
                carried = any(loop.type not in POINTWISE for loop in self.robot.loops)
                for engine in (self.pinocchio,) if carried else (self.pinocchio, self.mujoco):
                    same(mass, engine.mass_matrix(q, self.names))
        total = sum(self.usd.mass(body)[0] for body in self.usd.bodies)
        assert abs(total - self.mujoco.model.body_mass.sum()) < TOLERANCE * max(1.0, total)
        self.same_joints()
        self.same_relations(rng)

    def values(self, q: Mapping[str, Value]) -> dict[str, Value]:
        return {self.joints.get(name, name): value for name, value in counted(q, self.zeros).items()}

    def same_poses(self, q: Mapping[str, Value]) -> dict[str, np.ndarray]:
        """The poses by the names of the USD's bodies, as MuJoCo and Pinocchio have them, too."""
        found = self.usd.poses(self.values(q))
        root = found[self.links.get(self.robot.root.name, self.robot.root.name)]
        for engine in (self.mujoco, self.pinocchio):
            expected = engine.poses(q)
            moved = root @ np.linalg.inv(expected[self.robot.root.name])
            for link in self.robot.links:
                same(found[self.links.get(link.name, link.name)], moved @ expected[link.name])
        return found

    def same_joints(self) -> None:
        """Limits, armature, damping, friction and effort of turns and slides."""
        model = self.mujoco.model
        for dof in self.robot.dofs:
            if dof.kind not in ("turn", "slide"):
                continue
            name, joint = self.joints.get(dof.name, dof.name), model.joint(dof.name)
            low, high = joint.range if joint.limited else (-np.inf, np.inf)
            for found, expected in zip(self.usd.limits(name), (low, high), strict=True):
                assert np.isinf(found) == (abs(expected) >= OPEN), dof.name
                assert np.isinf(found) or abs(found - expected) < TOLERANCE * max(1.0, abs(expected))
            scale = 180 / np.pi if dof.kind == "turn" else 1.0
            for key, value in (
                ("armature", joint.armature[0]),
                ("damping", joint.damping[0] / scale),
                ("friction", joint.frictionloss[0]),
            ):
                assert abs((self.usd.value(name, f"newton:{key}") or 0.0) - value) < TOLERANCE * max(1, value)
            if model.jnt_actfrclimited[joint.id]:
                kind = "angular" if dof.kind == "turn" else "linear"
                most = self.usd.value(name, f"drive:{kind}:physics:maxForce")
                assert abs(most - model.jnt_actfrcrange[joint.id][1]) < TOLERANCE * max(1.0, most)

    def same_relations(self, rng: np.random.Generator) -> None:
        """Where MuJoCo's equality of two joints holds, those of PhysX and of Newton do."""
        model, kinds = self.mujoco.model, {dof.name: dof.kind for dof in self.robot.dofs}
        rows = np.flatnonzero(model.eq_type == mujoco.mjtEq.mjEQ_JOINT)
        assert len(rows) == len(self.robot.relations)
        relations = {relation.name: relation for relation in self.robot.relations}
        for row in rows:
            relation = relations[model.equality(row).name]
            pair = relation.follower, relation.driver
            q = {relation.driver: float(rng.uniform(-1, 1))}
            first, second = (
                model.joint(index).name for index in (model.eq_obj1id[row], model.eq_obj2id[row])
            )
            start = {name: model.qpos0[model.joint(name).qposadr[0]] for name in pair}
            coefficients = model.eq_data[row][:2]
            if first == relation.follower:
                moved = coefficients @ (1.0, q[second] - start[second])
            else:
                moved = (q[first] - start[first] - coefficients[0]) / coefficients[1]
            q[relation.follower] = start[relation.follower] + moved
            shown = {name: np.degrees(q[name]) if kinds[name] == "turn" else q[name] for name in pair}
            own, driver = (self.joints.get(name, name) for name in pair)
            prim = self.usd.joints[own].GetPrim()
            (mimic,) = (one for one in self.usd.schemas(prim) if one.startswith("PhysxMimicJointAPI:"))
            before = f"physxMimicJoint:{mimic.partition(':')[2]}"
            gearing, offset = (self.usd.value(own, f"{before}:{key}") for key in ("gearing", "offset"))
            assert self.usd.target(own, f"{before}:referenceJoint") == driver
            size = max(1.0, *map(abs, shown.values()))
            assert abs(shown[pair[0]] + gearing * shown[pair[1]] + offset) < TOLERANCE * size
            if kinds[pair[0]] == kinds[pair[1]]:
                zero, one = (self.usd.value(own, f"newton:mimicCoef{number}") for number in (0, 1))
                assert abs(shown[pair[0]] - zero - one * shown[pair[1]]) < TOLERANCE * size
                assert self.usd.target(own, "newton:mimicJoint") == driver

    def closed(self, q: Mapping[str, Value]) -> None:
        """At a pose that closes the loops, the joints of the loops are closed: the values of their own chains
        may be among `q`."""
        poses = self.same_poses({name: q[name] for name in self.names})
        chains = {name: value for name, value in self.values(q).items() if name in self.usd.joints}
        poses |= self.usd.poses(chains)
        for name in self.usd.loops:
            assert self.usd.gap(name, poses) < TOLERANCE


def counted(q: Mapping[str, Value], zeros: Mapping[str, Sequence[float]]) -> dict[str, Value]:
    """Values as the USD's joints count them: a ball of `zeros` turns on from there."""
    found = dict(q)
    for name in zeros.keys() & q.keys():
        zero, value = (Rotation.from_quat(np.roll(one, -1)) for one in (zeros[name], q[name]))
        found[name] = tuple(float(part) for part in np.roll((zero.inv() * value).as_quat(), 1))
    return found


def same(found: np.ndarray, expected: np.ndarray) -> None:
    scale = max(1.0, float(np.abs(expected).max()))
    assert np.abs(found - expected).max() < TOLERANCE * scale
