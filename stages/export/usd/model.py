"""Writes the layer of a robot in terms of UsdPhysics (openusd.org, "Rigid Body Physics in USD"). Attributes
`physx...`, `newton:...` and `mjc:...` are read only by PhysX, Newton or MuJoCo; joints have the attributes of
both the older and the newer schema of PhysX.

    <robot>             Xform
        <link>          rigid bodies, not nested, as older importers of Isaac require
            visuals     instances of the meshes' layer
            collisions  convex, with the purpose `guide`: not drawn by default
            <frame>     Xforms and cameras
        joints          in the order of the robot's joints, then of its loops
        materials
        actuators       in MuJoCo's schema, if the robot has actuators
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from linkwright.stages.export.usd.actuator_prims import write_actuators
from linkwright.stages.export.usd.bodies import body_poses, write_mass
from linkwright.stages.export.usd.joint_prims import write_facts, write_frames, write_joint
from linkwright.stages.export.usd.joints import UsdJoint, added_links
from linkwright.stages.export.usd.layer import Layer, Prim
from linkwright.stages.export.usd.shapes import (
    ShownMeshes,
    UsdMaterials,
    UsdMeshes,
    write_colliders,
    write_materials,
    write_visuals,
)
from linkwright.stages.formats.usd.drives import Drives
from linkwright.stages.formats.usd.joint_facts import JointFacts, joint_drive, joint_mimic, joint_state
from linkwright.stages.formats.usd.names import UsdNames, identifiers
from linkwright.stages.robot.dynamics.inertia import TINY_INERTIAL
from linkwright.stages.robot.model.actuation import Actuator
from linkwright.stages.robot.model.geometry import Geometry
from linkwright.stages.robot.model.poses import from_parts
from linkwright.stages.robot.model.robot import Array, Configuration, Robot
from linkwright.stages.robot.model.sensing import Sensing, SensorCamera
from linkwright.stages.robot.text.names import free_name

_CAMERA_FROM_PRIM = np.diag([1.0, -1.0, -1.0])
"""camera_from_prim (3, 3): USD's cameras look along −z with y up; the robot's look along z with y down."""

_CLIPPING_RANGE = (0.01, 100.0)
"""The nearest and the farthest distance [m] that cameras show. USD's default hides everything nearer than 1
m."""

_FOCAL_LENGTH = 24.0
"""The focal length of cameras [tenths of the scene's unit], which sets the scale of the image's sides."""


@dataclass(frozen=True, slots=True, eq=False)
class UsdPlan:
    """How a robot is written as USD: names, joints, actuators and poses."""

    names: UsdNames
    joints: tuple[UsdJoint, ...]
    drives: Drives
    actuators: tuple[Actuator, ...]
    sensing: Sensing

    home: Configuration
    """The values of all dofs in the pose in which the robot is written."""

    ball_zeros: Configuration
    """The values of balls at which their joints in the USD are at zero."""

    world_from_root: Array
    """The pose (4, 4) of the root link in the world."""


def usd_layer(robot: Robot, geometry: Geometry, plan: UsdPlan, meshes: UsdMeshes) -> Layer:
    """Builds the layer of a robot."""
    writer = _LayerWriter(robot, geometry, plan, meshes)
    writer.write()
    return writer.layer


class _LayerWriter:
    """The writer of a robot's layer, with the prims of its bodies and colliders."""

    def __init__(self, robot: Robot, geometry: Geometry, plan: UsdPlan, meshes: UsdMeshes) -> None:
        self.robot, self.geometry, self.plan = robot, geometry, plan
        self.shapes, self.meshes, self.shown_meshes = geometry.by_link(), meshes, ShownMeshes(meshes)
        self.layer = Layer(plan.names.robot, "Xform")
        self.poses = body_poses(
            robot, plan.names, plan.home, plan.ball_zeros, plan.joints, plan.world_from_root
        )
        self.bodies: dict[str, Prim] = {}
        self.colliders: dict[str, list[Prim]] = {}

    def write(self) -> None:
        """Writes the whole layer."""
        names, root = self.plan.names, self.layer.root
        if names.robot != self.robot.name:
            root.set_display_name(self.robot.name)
        # Bodies are written before the prims that refer to them, and materials before they are bound.
        self._write_bodies()
        joint_scope = root.child(names.scopes["joints"], "Scope")
        materials = write_materials(root.child(names.scopes["materials"], "Scope"), self.geometry)
        used_names = {
            link: self._write_frames_and_cameras(self.bodies[prim_name], link)
            for link, prim_name in names.links.items()
        }
        self._write_visuals(materials, used_names)
        self._write_colliders(materials, used_names)
        self._write_articulation_roots(joint_scope)
        prims_by_dof = self._write_joints(joint_scope)
        self._write_mimics(prims_by_dof)
        if self.plan.actuators:
            scope = root.child(names.scopes["actuators"], "Scope")
            write_actuators(scope, self.plan.actuators, prims_by_dof)
        self._write_filtered_pairs()

    def _write_bodies(self) -> None:
        """Writes the bodies of the robot's links, and of the links between the dofs of a joint or loop."""
        names = self.plan.names
        for link in self.robot.links:
            write_mass(self._add_body(names.links[link.name], link.name), link.inertial)
        for name, _ in added_links(self.robot, names, self.plan.joints):
            write_mass(self._add_body(name, name), TINY_INERTIAL)

    def _add_body(self, name: str, robot_name: str) -> Prim:
        """Writes a body with its pose. `robot_name`: its name in the robot."""
        body = self.layer.root.child(name, "Xform", "PhysicsRigidBodyAPI")
        if robot_name != name:
            body.set_display_name(robot_name)
        body.place(self.poses[name])
        self.bodies[name] = body
        return body

    def _write_visuals(self, materials: UsdMaterials, used_names: Mapping[str, set[str]]) -> None:
        """Writes the visual shapes. `used_names`: link → the names of the other prims in its body."""
        for link in self.robot.links:
            shapes = self.shapes[link.name, "visual"]
            if shapes:
                prim_name = self.plan.names.links[link.name]
                scope = self.bodies[prim_name].child(free_name("visuals", used_names[link.name]), "Scope")
                body_pose = self.poses[prim_name]
                write_visuals(scope, shapes, materials, self.meshes, self.shown_meshes, body_pose)

    def _write_colliders(self, materials: UsdMaterials, used_names: Mapping[str, set[str]]) -> None:
        """Writes the colliders. `used_names`: link → the names of the other prims in its body."""
        for link in self.robot.links:
            shapes = self.shapes[link.name, "collision"]
            if shapes:
                prim_name = self.plan.names.links[link.name]
                scope = self.bodies[prim_name].child(free_name("collisions", used_names[link.name]), "Scope")
                scope.token("purpose", "guide")
                self.colliders[link.name] = write_colliders(
                    scope, shapes, materials, self.meshes, self.shown_meshes, self.poses[prim_name]
                )

    def _write_frames_and_cameras(self, body: Prim, link: str) -> set[str]:
        """Writes the frames, sites of sensors and cameras on a link, and returns their names."""
        sensing = self.plan.sensing
        frames = [(frame.name, frame.link_from_frame) for frame in self.robot.frames if frame.link == link]
        frames += [(site.name, site.link_from_site) for site in sensing.sites if site.link == link]
        prim_names = identifiers(name for name, _ in frames)
        for name, pose in dict(frames).items():
            frame = body.child(prim_names[name], "Xform")
            if prim_names[name] != name:
                frame.set_display_name(name)
            frame.place(pose)
        used_names = set(prim_names.values())
        cameras = {camera.name: camera for camera in sensing.cameras if camera.link == link}
        for name, prim in identifiers(cameras, used_names).items():
            _write_camera(body.child(prim, "Camera"), cameras[name])
            used_names.add(prim)
        return used_names

    def _write_articulation_roots(self, joint_scope: Prim) -> None:
        """Marks the roots of articulations: the joint that fixes the robot, or the root link of a floating
        robot, and each free link that has joints of its own."""
        names = self.plan.names
        root_link = self.bodies[names.links[self.robot.root.name]]
        roots = [self._write_base_joint(joint_scope) if self.robot.base.fixed else root_link]
        parents = {joint.parent for joint in self.robot.joints if joint.type != "free"}
        roots += [
            self.bodies[names.links[joint.child]]
            for joint in self.robot.joints
            if joint.type == "free" and joint.child in parents
        ]
        for root in roots:
            root.apply("PhysicsArticulationRootAPI", "PhysxArticulationAPI", "NewtonArticulationRootAPI")
            root.set("physxArticulation:enabledSelfCollisions", "bool", self.geometry.self_contact)
            root.set("newton:selfCollisionEnabled", "bool", self.geometry.self_contact)

    def _write_base_joint(self, joint_scope: Prim) -> Prim:
        """Writes the joint that fixes the root link to the world."""
        names = self.plan.names
        root_link = names.links[self.robot.root.name]
        base_joint = joint_scope.child(names.base_joint, "PhysicsFixedJoint")
        # The robot's own prim is not a body, so UsdPhysics treats it as the world, even if the robot is
        # placed in a scene.
        base_joint.point_to("physics:body0", self.layer.root)
        base_joint.point_to("physics:body1", self.bodies[root_link])
        write_frames(base_joint, self.poses[root_link], np.eye(4))
        return base_joint

    def _write_joints(self, scope: Prim) -> dict[str, Prim]:
        """Writes the joints, and returns the prim of each dof's joint."""
        robot_names = {prim_name: name for name, prim_name in self.plan.names.joints.items()}
        prims_by_dof = {}
        for joint in self.plan.joints:
            prim = self._write_joint(scope, joint, robot_names[joint.name])
            if joint.dof is not None:
                prims_by_dof[joint.dof.name] = prim
        return prims_by_dof

    def _write_joint(self, scope: Prim, joint: UsdJoint, robot_name: str) -> Prim:
        """Writes a joint with its bodies, frames, limits, state and drive. `robot_name`: its name in the
        robot."""
        prim = scope.child(joint.name, f"Physics{joint.type}Joint")
        if robot_name != joint.name:
            prim.set_display_name(robot_name)
        prim.point_to("physics:body0", self.bodies[joint.first])
        prim.point_to("physics:body1", self.bodies[joint.second])
        write_frames(prim, joint.first_from_joint, joint.second_from_joint)
        write_joint(prim, joint)
        dof = joint.dof
        if dof is not None and not joint.closes and joint.type != "Spherical":
            value, drive = self.plan.home[dof.name], self.plan.drives.by_dof.get(dof.name)
            assert not isinstance(value, tuple)
            facts = joint_state(dof, value) | (joint_drive(dof, drive) if drive is not None else JointFacts())
            write_facts(prim, facts, {})
        return prim

    def _write_mimics(self, prims_by_dof: Mapping[str, Prim]) -> None:
        """Writes each relation on the joint of its follower. `prims_by_dof`: the prim of each dof's joint."""
        joints = {joint.dof.name: joint for joint in self.plan.joints if joint.dof is not None}
        for relation in self.robot.relations:
            follower, driver = joints[relation.follower], joints[relation.driver]
            assert follower.dof is not None
            assert driver.dof is not None
            facts = joint_mimic(relation, follower.dof, driver.dof, (follower.axis, driver.axis))
            write_facts(prims_by_dof[relation.follower], facts, prims_by_dof)

    def _write_filtered_pairs(self) -> None:
        """Writes the pairs of bodies, or of colliders, that must not collide. Bodies that a joint of the tree
        connects never collide, so they are left out. Bodies that a loop connects are listed, for PhysX."""
        connected = {frozenset((joint.first, joint.second)) for joint in self.plan.joints if not joint.closes}
        targets_by_path: dict[str, tuple[Prim, list[Prim]]] = {}
        links = self.plan.names.links
        for exclude in self.geometry.excludes:
            if frozenset((links[exclude.link_a], links[exclude.link_b])) in connected:
                continue
            prim_pairs = [(self.bodies[links[exclude.link_a]], self.bodies[links[exclude.link_b]])]
            if exclude.geoms:
                colliders_a, colliders_b = self.colliders[exclude.link_a], self.colliders[exclude.link_b]
                prim_pairs = [(colliders_a[row], colliders_b[column]) for row, column in exclude.geoms]
            for first, second in prim_pairs:
                targets_by_path.setdefault(first.path, (first, []))[1].append(second)
        for prim, targets in targets_by_path.values():
            prim.apply("PhysicsFilteredPairsAPI")
            prim.point_to("physics:filteredPairs", *targets)


def _write_camera(prim: Prim, camera: SensorCamera) -> None:
    """Writes the pose, the field of view and the resolution's aspect of a camera."""
    if prim.path.rpartition("/")[2] != camera.name:
        prim.set_display_name(camera.name)
    prim.place(camera.link_from_camera @ from_parts(_CAMERA_FROM_PRIM, np.zeros(3)))
    width, height = camera.resolution
    aperture = 2 * _FOCAL_LENGTH * math.tan(math.radians(camera.fovy) / 2)
    prim.token("projection", "perspective")
    prim.number("focalLength", _FOCAL_LENGTH)
    prim.number("verticalAperture", aperture)
    prim.number("horizontalAperture", aperture * width / height)
    prim.floats("clippingRange", "float2", _CLIPPING_RANGE)
