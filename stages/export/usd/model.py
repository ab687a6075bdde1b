"""Writes the layer of a robot in terms of UsdPhysics (openusd.org, "Rigid Body Physics in USD"). Attributes
`physx...`, `newton:...` and `mjc:...` hold what only PhysX, Newton or MuJoCo knows; joints have those of both
PhysX's older and newer schema.

    <robot>             Xform
        <link>          rigid bodies, none in another: Isaac's older importers want that
            visuals     instances of the meshes' layer
            collisions  convex, not drawn unless guides are
            <frame>     Xforms and cameras
        joints          in the order of the robot's, then of the loops
        materials
        actuators       in MuJoCo's schema, where there are any
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
    UsdMeshes,
    write_colliders,
    write_materials,
    write_visuals,
)
from linkwright.stages.formats.usd.drives import Drives
from linkwright.stages.formats.usd.joint_facts import JointFacts, joint_drive, joint_mimic, joint_state
from linkwright.stages.formats.usd.names import UsdNames, identifiers
from linkwright.stages.robot.dynamics.inertia import SPECK
from linkwright.stages.robot.model.actuation import Actuator
from linkwright.stages.robot.model.geometry import Geometry
from linkwright.stages.robot.model.poses import from_parts
from linkwright.stages.robot.model.robot import Array, Configuration, Robot
from linkwright.stages.robot.model.sensing import Sensing, SensorCamera
from linkwright.stages.robot.text.names import free

_FROM_IMAGE = np.diag([1.0, -1.0, -1.0])
"""camera_from_prim (3, 3): cameras of USD look along −z, with y up; ours along z, with y down."""

FOCAL = 24.0
"""The focal length of cameras [tenths of the scene's unit], which sets the scale of the image's sides."""


@dataclass(frozen=True, slots=True, eq=False)
class UsdPlan:
    """The parts of a robot in terms of USD."""

    names: UsdNames
    joints: tuple[UsdJoint, ...]
    drives: Drives
    actuators: tuple[Actuator, ...]
    sensing: Sensing

    home: Configuration
    """The values of all dofs in the pose in which the robot stands."""

    zeros: Configuration
    """The values of balls at which their joints are at zero."""

    world_from_root: Array
    """The pose (4, 4) in which the robot stands."""


def write_usd(robot: Robot, geometry: Geometry, plan: UsdPlan, meshes: UsdMeshes) -> Layer:
    """Returns the robot's layer."""
    writer = _LayerWriter(robot, geometry, plan, meshes)
    writer.write()
    return writer.layer


class _LayerWriter:
    """The writer of a robot's layer, with the prims of its bodies and colliders."""

    def __init__(self, robot: Robot, geometry: Geometry, plan: UsdPlan, meshes: UsdMeshes) -> None:
        self.robot, self.geometry, self.plan = robot, geometry, plan
        self.meshes, self.seen = meshes, ShownMeshes(meshes)
        self.layer = Layer(plan.names.robot, "Xform")
        self.bodies: dict[str, Prim] = {}
        self.colliders: dict[str, list[Prim]] = {}

    def write(self) -> None:
        """Writes the whole layer."""
        names, joints, root = self.plan.names, self.plan.joints, self.layer.root
        if names.robot != self.robot.name:
            root.call(self.robot.name)
        plan = self.plan
        poses = body_poses(self.robot, names, plan.home, plan.zeros, joints, plan.world_from_root)
        shapes = self.geometry.by_link()
        # The bodies come first, and a material before it is bound.
        for link in self.robot.links:
            body = self._body(names.links[link.name], link.name, poses)
            write_mass(body, link.inertial)
        for name, _ in added_links(self.robot, names, joints):
            write_mass(self._body(name, name, poses), SPECK)
        scope = root.child(names.scopes["joints"], "Scope")
        robot_materials = write_materials(root.child(names.scopes["materials"], "Scope"), self.geometry)
        names_on_link = {
            link: self._places(self.bodies[prim_name], link) for link, prim_name in names.links.items()
        }
        for link in self.robot.links:
            link_shapes = shapes[link.name, "visual"]
            if link_shapes:
                body, place = self.bodies[names.links[link.name]], poses[names.links[link.name]]
                above = body.child(free("visuals", names_on_link[link.name]), "Scope")
                write_visuals(above, link_shapes, robot_materials, self.meshes, self.seen, place)
        for link in self.robot.links:
            link_shapes = shapes[link.name, "collision"]
            if link_shapes:
                body, place = self.bodies[names.links[link.name]], poses[names.links[link.name]]
                above = body.child(free("collisions", names_on_link[link.name]), "Scope")
                above.token("purpose", "guide")
                colliders = write_colliders(
                    above, link_shapes, robot_materials, self.meshes, self.seen, place
                )
                self.colliders[link.name] = colliders
        self._hold(scope, poses)
        prims_by_joint = {joint.name: self._joint(scope, joint) for joint in joints}
        joints_by_dof = {joint.dof.name: joint for joint in joints if joint.dof is not None}
        prims = {dof: prims_by_joint[joint.name] for dof, joint in joints_by_dof.items()}
        self._follow(joints_by_dof, prims)
        if plan.actuators:
            above = root.child(names.scopes["actuators"], "Scope")
            write_actuators(above, plan.actuators, prims)
        self._filter()

    def _body(self, name: str, called: str, poses: Mapping[str, Array]) -> Prim:
        body = self.layer.root.child(name, "Xform", "PhysicsRigidBodyAPI")
        if called != name:
            body.call(called)
        body.place(poses[name])
        self.bodies[name] = body
        return body

    def _places(self, body: Prim, link: str) -> set[str]:
        """Writes the frames, sites of sensors and cameras on a link, and returns their names."""
        sensing = self.plan.sensing
        frames = [(frame.name, frame.link_from_frame) for frame in self.robot.frames if frame.link == link]
        frames += [(site.name, site.link_from_site) for site in sensing.sites if site.link == link]
        prim_names = identifiers(name for name, _ in frames)
        for name, pose in dict(frames).items():
            frame = body.child(prim_names[name], "Xform")
            if prim_names[name] != name:
                frame.call(name)
            frame.place(pose)
        used_names = set(prim_names.values())
        cameras = {camera.name: camera for camera in sensing.cameras if camera.link == link}
        for name, prim in identifiers(cameras, used_names).items():
            _camera(body.child(prim, "Camera"), cameras[name])
            used_names.add(prim)
        return used_names

    def _hold(self, scope: Prim, poses: Mapping[str, Array]) -> None:
        """Writes the root of the articulation: the joint that holds a fixed robot, or the root link of any
        other. A link that moves freely and carries others is a root as well."""
        names = self.plan.names
        root_link = names.links[self.robot.root.name]
        roots = [self.bodies[root_link]]
        if self.robot.base.fixed:
            base = scope.child(names.base, "PhysicsFixedJoint")
            # The robot's own prim is not a body. It stands for the world if the robot is placed in a scene.
            base.point_to("physics:body0", self.layer.root)
            base.point_to("physics:body1", self.bodies[root_link])
            write_frames(base, poses[root_link], np.eye(4))
            roots = [base]
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

    def _joint(self, scope: Prim, joint: UsdJoint) -> Prim:
        prim = scope.child(joint.name, f"Physics{joint.type}Joint")
        robot_name = self._called(joint)
        if robot_name != joint.name:
            prim.call(robot_name)
        first = self.layer.root if joint.first is None else self.bodies[joint.first]
        prim.point_to("physics:body0", first)
        prim.point_to("physics:body1", self.bodies[joint.second])
        write_frames(prim, joint.first_from_joint, joint.second_from_joint)
        write_joint(prim, joint)
        dof = joint.dof
        if dof is not None and not joint.closes and joint.type != "Spherical":
            value, drive = self.plan.home[dof.name], self.plan.drives.of.get(dof.name)
            assert not isinstance(value, tuple)
            facts = joint_state(dof, value) | (joint_drive(dof, drive) if drive is not None else JointFacts())
            write_facts(prim, facts, {})
        return prim

    def _follow(self, joints: Mapping[str, UsdJoint], prims: Mapping[str, Prim]) -> None:
        """Writes the relations, on their followers. `joints`, `prims`: by their dofs."""
        for relation in self.robot.relations:
            follower, driver = joints[relation.follower], joints[relation.driver]
            assert follower.dof is not None
            assert driver.dof is not None
            facts = joint_mimic(relation, follower.dof, driver.dof, (follower.axis, driver.axis))
            write_facts(prims[relation.follower], facts, prims)

    def _called(self, joint: UsdJoint) -> str:
        names = {prim_name: name for name, prim_name in self.plan.names.joints.items()}
        return names[joint.name]

    def _filter(self) -> None:
        """Writes the pairs that must not collide. Bodies that a joint of the tree joins never collide, but
        those of a loop must be listed for PhysX."""
        joined = {frozenset((joint.first, joint.second)) for joint in self.plan.joints if not joint.closes}
        pairs: dict[str, tuple[Prim, list[Prim]]] = {}
        links = self.plan.names.links
        for exclude in self.geometry.excludes:
            if frozenset((links[exclude.link_a], links[exclude.link_b])) in joined:
                continue
            prims = [(self.bodies[links[exclude.link_a]], self.bodies[links[exclude.link_b]])]
            if exclude.geoms:
                first, second = self.colliders[exclude.link_a], self.colliders[exclude.link_b]
                prims = [(first[a], second[b]) for a, b in exclude.geoms]
            for a, b in prims:
                pairs.setdefault(a.path, (a, []))[1].append(b)
        for prim, targets in pairs.values():
            prim.apply("PhysicsFilteredPairsAPI")
            prim.point_to("physics:filteredPairs", *targets)


def _camera(prim: Prim, camera: SensorCamera) -> None:
    if prim.path.rpartition("/")[2] != camera.name:
        prim.call(camera.name)
    prim.place(camera.link_from_camera @ from_parts(_FROM_IMAGE, np.zeros(3)))
    width, height = camera.resolution
    aperture = 2 * FOCAL * math.tan(math.radians(camera.fovy) / 2)
    prim.token("projection", "perspective")
    prim.number("focalLength", FOCAL)
    prim.number("verticalAperture", aperture)
    prim.number("horizontalAperture", aperture * width / height)
    prim.floats("clippingRange", "float2", (0.01, 100.0))
