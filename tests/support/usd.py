"""A USD as a reader of its own has it: kinematics and mass matrix from its joints alone, by `pxr` and numpy.

Nothing of the product is used. A joint says where its frame is on both bodies: at zero the frames coincide.
Angles are in degrees in the file and in radians here.
"""

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation


class _Pxr:
    """The modules of `pxr`, imported where a test first uses them; it is skipped where there are none."""

    def __getattr__(self, name):
        pytest.importorskip("pxr")
        return __import__("pxr", fromlist=[name]).__dict__[name]


pxr = _Pxr()

UNITS = {"X": (1.0, 0.0, 0.0), "Y": (0.0, 1.0, 0.0), "Z": (0.0, 0.0, 1.0)}


def stage_of(files, folder, name="robot"):
    """The stage of the files of a robot of this name, written into `folder`."""
    for path, data in files.items():
        (folder / path).parent.mkdir(parents=True, exist_ok=True)
        (folder / path).write_bytes(data)
    return pxr.Usd.Stage.Open(str(folder / f"{name}.usda"))


def complaints(stage):
    """What the validators of USD say of a stage."""
    registry = pxr.UsdValidation.ValidationRegistry()
    found = pxr.UsdValidation.ValidationContext(registry.GetOrLoadAllValidators()).Validate(stage)
    return [f"{error.GetName()}: {error.GetMessage()}" for error in found]


def parsed(stage, kind):
    """What the parser of UsdPhysics finds of a kind, such as `Articulation`; Newton reads by it."""
    physics = pxr.UsdPhysics
    newer = getattr(physics, "UsdPhysicsLoadStageFromPrimRange", None)
    found = (newer or physics.LoadUsdPhysicsFromRange)(stage, ["/"])
    return [
        description
        for key, (_, many) in found.items()
        if key == getattr(physics.ObjectType, kind)
        for description in many
    ]


class Usd:
    """The robot of a stage: the stage's default prim."""

    def __init__(self, stage):
        physics = pxr.UsdPhysics
        self.stage, self.root = stage, stage.GetDefaultPrim()
        assert pxr.UsdGeom.GetStageUpAxis(stage) == "Z"
        assert pxr.UsdGeom.GetStageMetersPerUnit(stage) == physics.GetStageKilogramsPerUnit(stage) == 1.0
        every = list(stage.Traverse())
        self.bodies = {prim.GetName(): prim for prim in every if prim.HasAPI(physics.RigidBodyAPI)}
        assert all(body.GetParent() == self.root for body in self.bodies.values()), "bodies are not flat"
        joints = {prim.GetName(): physics.Joint(prim) for prim in every if prim.IsA(physics.Joint)}
        self.loops = {
            name: joint for name, joint in joints.items() if joint.GetExcludeFromArticulationAttr().Get()
        }
        self.joints = {name: joint for name, joint in joints.items() if name not in self.loops}
        self.roots = [prim for prim in every if prim.HasAPI(physics.ArticulationRootAPI)]
        cache = pxr.UsdGeom.XformCache()
        self.stands = {
            name: _matrix(cache.GetLocalToWorldTransform(prim)) for name, prim in self.bodies.items()
        }
        self.above = {}
        for name, joint in self.joints.items():
            child = self.ends(joint)[1]
            assert child not in self.above, f"two joints of the tree hold {child}"
            self.above[child] = name

    def ends(self, joint):
        """The names of the prims that a joint is on; the first may be the robot's own."""
        (first,) = joint.GetBody0Rel().GetTargets()
        (second,) = joint.GetBody1Rel().GetTargets()
        return first.name, second.name

    def frames(self, joint):
        """Its frame (4, 4) on both."""
        return (
            _pose(joint.GetLocalPos0Attr().Get(), joint.GetLocalRot0Attr().Get()),
            _pose(joint.GetLocalPos1Attr().Get(), joint.GetLocalRot1Attr().Get()),
        )

    def poses(self, values, free=None):
        """world_from_body (4, 4) by the names of bodies. `values`: by joint, of a ball (w, x, y, z) in
        the axes of its second body; `free`: the pose of bodies that no joint holds, else where they stand."""
        found = {}

        def pose(body):
            if body == self.root.GetName() and body not in self.bodies:
                return np.eye(4)
            if body not in found:
                if body not in self.above:
                    found[body] = (free or self.stands).get(body, self.stands[body])
                else:
                    name = self.above[body]
                    joint = self.joints[name]
                    first, second = self.frames(joint)
                    moved = _motion(joint.GetPrim(), values.get(name, 0.0), second)
                    found[body] = pose(self.ends(joint)[0]) @ first @ moved @ np.linalg.inv(second)
            return found[body]

        return {body: pose(body) for body in self.bodies}

    def mass(self, body):
        """Mass, centre of mass (3,) and inertia about it (3, 3) in the body's axes."""
        api = pxr.UsdPhysics.MassAPI(self.bodies[body])
        axes = _rotation(api.GetPrincipalAxesAttr().Get())
        moments = np.array(api.GetDiagonalInertiaAttr().Get(), dtype=float)
        assert (moments > 0).all()
        assert 2 * moments.max() <= moments.sum() * (1 + 1e-6)
        return (
            float(api.GetMassAttr().Get()),
            np.array(api.GetCenterOfMassAttr().Get(), dtype=float),
            axes @ np.diag(moments) @ axes.T,
        )

    def mass_matrix(self, values, joints):
        """(n, n) of the speeds of these joints: Σ Jᵀ M J over the bodies; of a ball the angular velocity in
        the axes of its second body."""
        poses = self.poses(values)
        columns = {name: self._twists(name, poses) for name in joints}
        total = np.zeros((sum(len(column) for column in columns.values()),) * 2)
        for body, pose in poses.items():
            mass, com, inertia = self.mass(body)
            at, turned = pose[:3, :3] @ com + pose[:3, 3], pose[:3, :3]
            moving = self._moving(body)
            rows = []
            for name, twists in columns.items():
                for spin, speed, place in twists:
                    on = name in moving
                    rows.append(
                        np.concatenate([spin, speed + np.cross(spin, at - place)]) if on else np.zeros(6)
                    )
            spatial = np.zeros((6, 6))
            spatial[:3, :3], spatial[3:, 3:] = turned @ inertia @ turned.T, mass * np.eye(3)
            jacobian = np.array(rows).reshape(-1, 6).T
            total += jacobian.T @ spatial @ jacobian
        return total

    def _moving(self, body):
        names = set()
        while body in self.above:
            names.add(self.above[body])
            body = self.ends(self.joints[self.above[body]])[0]
        return names

    def _twists(self, name, poses):
        joint = self.joints[name]
        place = poses[self.ends(joint)[1]] @ self.frames(joint)[1]
        kind, zero = joint.GetPrim().GetTypeName(), np.zeros(3)
        if kind == "PhysicsSphericalJoint":
            turned = poses[self.ends(joint)[1]]
            return [(turned[:3, axis], zero, place[:3, 3]) for axis in range(3)]
        axis = place[:3, :3] @ UNITS[joint.GetPrim().GetAttribute("physics:axis").Get()]
        return [(zero, axis, place[:3, 3]) if "Prismatic" in kind else (axis, zero, place[:3, 3])]

    def gap(self, loop, poses):
        """How far a loop is from closed [m, rad], in the directions that its joint holds."""
        joint = self.loops[loop]
        prim = joint.GetPrim()
        first, second = (
            poses[body] @ frame for body, frame in zip(self.ends(joint), self.frames(joint), strict=True)
        )
        relative = np.linalg.inv(first) @ second
        offset, turn = relative[:3, 3], Rotation.from_matrix(relative[:3, :3]).as_rotvec()
        kind = prim.GetTypeName()
        if kind == "PhysicsSphericalJoint":
            turn = np.zeros(3)
        elif kind in ("PhysicsRevoluteJoint", "PhysicsPrismaticJoint"):
            axis = np.array(UNITS[prim.GetAttribute("physics:axis").Get()])
            if kind == "PhysicsRevoluteJoint":
                turn = np.cross(axis, relative[:3, :3] @ axis)
            else:
                offset = offset - axis * (offset @ axis)
        elif kind == "PhysicsJoint":
            locked = {
                (motion, axis)
                for motion in ("trans", "rot")
                for axis in "XYZ"
                if (limit := limits_of(prim, f"limit:{motion}{axis}:physics:")) and limit[0] > limit[1]
            }
            offset = np.array([offset[i] for i, axis in enumerate("XYZ") if ("trans", axis) in locked] or [0])
            loose = [i for i, axis in enumerate("XYZ") if ("rot", axis) not in locked]
            assert len(loose) <= 1
            if loose:
                axis = np.eye(3)[loose[0]]
                turn = np.cross(axis, relative[:3, :3] @ axis)
        return max(float(np.linalg.norm(offset)), float(np.linalg.norm(turn)))

    def limits(self, joint):
        """[rad or m], infinite where it is open."""
        prim = (self.joints | self.loops)[joint].GetPrim()
        low, high = (prim.GetAttribute(f"physics:{end}Limit").Get() for end in ("lower", "upper"))
        scale = math.pi / 180 if prim.GetTypeName() == "PhysicsRevoluteJoint" else 1.0
        return low * scale, high * scale

    def value(self, joint, name):
        """An attribute of a joint, None where it is not written."""
        attribute = (self.joints | self.loops)[joint].GetPrim().GetAttribute(name)
        return attribute.Get() if attribute else None

    def target(self, joint, name):
        """The name of what a relationship of a joint is to."""
        (path,) = (self.joints | self.loops)[joint].GetPrim().GetRelationship(name).GetTargets()
        return str(path.name)

    def schemas(self, prim):
        """The applied schemas, also those that are not known here."""
        return list(prim.GetPrimTypeInfo().GetAppliedAPISchemas())


def limits_of(prim, before):
    """The ends of a LimitAPI, None where there is none."""
    low, high = (prim.GetAttribute(f"{before}{end}") for end in ("low", "high"))
    return (low.Get() if low else -math.inf, high.Get() if high else math.inf) if low or high else None


def _motion(prim, value, second):
    """What a joint moves its frame by; `second` (4, 4): that on its second body."""
    out = np.eye(4)
    kind = prim.GetTypeName()
    if kind == "PhysicsSphericalJoint":
        assert prim.GetAttribute("physics:axis").Get() == "X"
        if isinstance(value, tuple):
            turned = Rotation.from_quat(np.roll(value, -1)).as_matrix()
            out[:3, :3] = second[:3, :3].T @ turned @ second[:3, :3]
    elif kind in ("PhysicsRevoluteJoint", "PhysicsPrismaticJoint"):
        axis = np.array(UNITS[prim.GetAttribute("physics:axis").Get()])
        if kind == "PhysicsRevoluteJoint":
            out[:3, :3] = Rotation.from_rotvec(value * axis).as_matrix()
        else:
            out[:3, 3] = value * axis
    else:
        assert kind == "PhysicsFixedJoint", kind
    return out


def _rotation(quat):
    return Rotation.from_quat([*quat.GetImaginary(), quat.GetReal()]).as_matrix()


def _pose(position, quat):
    out = np.eye(4)
    out[:3, :3], out[:3, 3] = _rotation(quat), position
    return out


def _matrix(matrix):
    """Gf's matrices act on rows."""
    return np.array(matrix).T
