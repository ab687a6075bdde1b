"""USD: the layer of a robot, as UsdPhysics has it (openusd.org, "Rigid Body Physics in USD"), with what only
PhysX or only Newton knows in their own attributes (`physx...`, `newton:...`; of joints PhysX's of both its
older and its newer schema).

    <robot>             Xform
        <link>          rigid bodies, none in another: Isaac's older importers want that
            visuals     instances of the meshes' layer
            collisions  convex, not drawn unless guides are
            <frame>     Xforms and cameras
        joints          in the order of the robot's, then of the loops
        materials
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import PurePosixPath

import numpy as np

from linkwright.stages.export.usd.bodies import body_poses, write_mass
from linkwright.stages.export.usd.joint_prims import write_facts, write_frames, write_joint
from linkwright.stages.export.usd.joints import UsdJoint, added_links
from linkwright.stages.export.usd.layer import Layer, Prim
from linkwright.stages.export.usd.shapes import write_colliders, write_materials, write_visuals
from linkwright.stages.formats.usd.drives import Drives
from linkwright.stages.formats.usd.joint_facts import JointFacts, driven, mimic, state
from linkwright.stages.formats.usd.names import UsdNames, identifiers
from linkwright.stages.robot.dynamics.inertia import SPECK
from linkwright.stages.robot.model.geometry import Geometry
from linkwright.stages.robot.model.poses import from_parts
from linkwright.stages.robot.model.robot import Array, Configuration, Robot
from linkwright.stages.robot.model.sensing import Sensing, SensorCamera
from linkwright.stages.robot.text.names import free

_FROM_IMAGE = np.diag([1.0, -1.0, -1.0])
"""camera_from_prim (3, 3): cameras of USD look along −z, with y up; ours along z, with y down."""

FOCAL = 24.0
"""Of cameras: the distance of the image [tenths of the scene's unit], which sets the scale of its sides."""


@dataclass(frozen=True, slots=True, eq=False)
class UsdPlan:
    """How a robot is said in USD. `home`: the values of all dofs in which it stands, at `world_from_root`
    (4, 4); `zeros`: of balls whose joints turn on from there."""

    names: UsdNames
    joints: tuple[UsdJoint, ...]
    drives: Drives
    sensing: Sensing
    home: Configuration
    zeros: Configuration
    world_from_root: Array


def write_usd(
    robot: Robot, geometry: Geometry, plan: UsdPlan, meshes: Mapping[str, str], layer: str
) -> Layer:
    """The robot's layer. `meshes`: paths in `layer`, a file beside this one, by the names of mesh files."""
    made = _Writer(robot, geometry, plan, meshes, layer)
    made.write()
    return made.layer


class _Writer:
    def __init__(
        self, robot: Robot, geometry: Geometry, plan: UsdPlan, meshes: Mapping[str, str], layer: str
    ) -> None:
        self.robot, self.geometry, self.plan = robot, geometry, plan
        self.meshes, self.meshes_layer = meshes, f"./{PurePosixPath(layer)}"
        self.layer = Layer(plan.names.robot, "Xform")
        self.bodies: dict[str, Prim] = {}
        self.colliders: dict[str, list[Prim]] = {}

    def write(self) -> None:
        names, joints, root = self.plan.names, self.plan.joints, self.layer.root
        if names.robot != self.robot.name:
            root.call(self.robot.name)
        plan = self.plan
        poses = body_poses(self.robot, names, plan.home, plan.zeros, joints, plan.world_from_root)
        shapes = self.geometry.by_link()
        # Written first and read last: a material is there before it is bound.
        for link in self.robot.links:
            body = self._body(names.links[link.name], link.name, poses)
            write_mass(body, link.inertial)
        for name, _ in added_links(self.robot, names, joints):
            write_mass(self._body(name, name, poses), SPECK)
        scope = root.child(names.scopes["joints"], "Scope")
        looks = write_materials(root.child(names.scopes["materials"], "Scope"), self.geometry)
        for link in self.robot.links:
            body = self.bodies[names.links[link.name]]
            taken = self._places(body, link.name)
            if shapes[link.name, "visual"]:
                above = body.child(free("visuals", taken), "Scope")
                write_visuals(above, shapes[link.name, "visual"], looks, self.meshes, self.meshes_layer)
            if shapes[link.name, "collision"]:
                above = body.child(free("collisions", taken), "Scope")
                above.token("purpose", "guide")
                own = shapes[link.name, "collision"]
                self.colliders[link.name] = write_colliders(above, own, looks, self.meshes, self.meshes_layer)
        self._hold(scope, poses)
        written = {joint.name: self._joint(scope, joint) for joint in joints}
        self._follow(written)
        self._filter()

    def _body(self, name: str, called: str, poses: Mapping[str, Array]) -> Prim:
        body = self.layer.root.child(name, "Xform", "PhysicsRigidBodyAPI")
        if called != name:
            body.call(called)
        body.place(poses[name])
        self.bodies[name] = body
        return body

    def _places(self, body: Prim, link: str) -> set[str]:
        """The frames, sites of sensors and cameras on a link, and their names."""
        sensing = self.plan.sensing
        frames = [(one.name, one.link_from_frame) for one in self.robot.frames if one.link == link]
        frames += [(one.name, one.link_from_site) for one in sensing.sites if one.link == link]
        own = identifiers(name for name, _ in frames)
        for name, pose in dict(frames).items():
            frame = body.child(own[name], "Xform")
            if own[name] != name:
                frame.call(name)
            frame.place(pose)
        taken = set(own.values())
        cameras = {one.name: one for one in sensing.cameras if one.link == link}
        for name, prim in identifiers(cameras, taken).items():
            _camera(body.child(prim, "Camera"), cameras[name])
            taken.add(prim)
        return taken

    def _hold(self, scope: Prim, poses: Mapping[str, Array]) -> None:
        """The root of the articulation: of a fixed robot the joint that holds it, else its root link; and
        that of each link that moves freely from it."""
        names = self.plan.names
        first = names.links[self.robot.root.name]
        roots = [self.bodies[first]]
        if self.robot.base.fixed:
            base = scope.child(names.base, "PhysicsFixedJoint")
            # The robot's own prim is no body: it is what the world is for a robot that is put somewhere.
            base.point_to("physics:body0", self.layer.root)
            base.point_to("physics:body1", self.bodies[first])
            write_frames(base, poses[first], np.eye(4))
            roots = [base]
        above = {joint.parent for joint in self.robot.joints if joint.type != "free"}
        roots += [
            self.bodies[names.links[joint.child]]
            for joint in self.robot.joints
            if joint.type == "free" and joint.child in above
        ]
        for root in roots:
            root.apply("PhysicsArticulationRootAPI", "PhysxArticulationAPI", "NewtonArticulationRootAPI")
            root.set("physxArticulation:enabledSelfCollisions", "bool", self.geometry.self_contact)
            root.set("newton:selfCollisionEnabled", "bool", self.geometry.self_contact)

    def _joint(self, scope: Prim, joint: UsdJoint) -> Prim:
        prim = scope.child(joint.name, f"Physics{joint.type}Joint")
        called = self._called(joint)
        if called != joint.name:
            prim.call(called)
        first = self.layer.root if joint.first is None else self.bodies[joint.first]
        prim.point_to("physics:body0", first)
        prim.point_to("physics:body1", self.bodies[joint.second])
        write_frames(prim, joint.first_from_joint, joint.second_from_joint)
        write_joint(prim, joint)
        dof = joint.dof
        if dof is not None and not joint.closes and joint.type != "Spherical":
            value, drive = self.plan.home[dof.name], self.plan.drives.of.get(dof.name)
            assert not isinstance(value, tuple)
            facts = state(dof, value) | (driven(dof, drive) if drive is not None else JointFacts())
            write_facts(prim, facts, {})
        return prim

    def _follow(self, written: Mapping[str, Prim]) -> None:
        """The relations, on their followers. `written`: the joints by their names."""
        of = {joint.dof.name: joint for joint in self.plan.joints if joint.dof is not None}
        prims = {dof: written[joint.name] for dof, joint in of.items()}
        for relation in self.robot.relations:
            follower, driver = of[relation.follower], of[relation.driver]
            assert follower.dof is not None
            assert driver.dof is not None
            facts = mimic(relation, follower.dof, driver.dof, (follower.axis, driver.axis))
            write_facts(prims[relation.follower], facts, prims)

    def _called(self, joint: UsdJoint) -> str:
        names = {own: name for name, own in self.plan.names.joints.items()}
        return names[joint.name]

    def _filter(self) -> None:
        """What must not collide, but for the bodies that a joint of the tree holds together, which never do;
        of a loop's PhysX needs to be told."""
        joined = {frozenset((joint.first, joint.second)) for joint in self.plan.joints if not joint.closes}
        pairs: dict[str, tuple[Prim, list[Prim]]] = {}
        links = self.plan.names.links
        for one in self.geometry.excludes:
            if frozenset((links[one.link_a], links[one.link_b])) in joined:
                continue
            found = [(self.bodies[links[one.link_a]], self.bodies[links[one.link_b]])]
            if one.geoms:
                first, second = self.colliders[one.link_a], self.colliders[one.link_b]
                found = [(first[a], second[b]) for a, b in one.geoms]
            for a, b in found:
                pairs.setdefault(a.path, (a, []))[1].append(b)
        for prim, others in pairs.values():
            prim.apply("PhysicsFilteredPairsAPI")
            prim.point_to("physics:filteredPairs", *others)


def _camera(prim: Prim, camera: SensorCamera) -> None:
    if prim.path.rpartition("/")[2] != camera.name:
        prim.call(camera.name)
    prim.place(camera.link_from_camera @ from_parts(_FROM_IMAGE, np.zeros(3)))
    width, height = camera.resolution
    tall = 2 * FOCAL * math.tan(math.radians(camera.fovy) / 2)
    prim.token("projection", "perspective")
    prim.number("focalLength", FOCAL)
    prim.number("verticalAperture", tall)
    prim.number("horizontalAperture", tall * width / height)
    prim.floats("clippingRange", "float2", (0.01, 100.0))
