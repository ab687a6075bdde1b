"""Reads a URDF into a mechanism: links become bodies, joints become connections, all at zero."""

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import cast

import numpy as np

from linkwright.stages.formats.urdf.model import Urdf, UrdfJoint, UrdfLink, UrdfShape, mesh_key
from linkwright.stages.formats.urdf.parse import parse
from linkwright.stages.graph.cad_only_keys import report_unused
from linkwright.stages.graph.mechanism import (
    WORLD_LINK,
    Connection,
    Marker,
    Mechanism,
    RelationSpec,
    RigidBody,
)
from linkwright.stages.graph.section import GraphSections
from linkwright.stages.graph.urdf.dummy_links import UrdfFrame, is_massless, with_carriers, without_dummies
from linkwright.stages.graph.urdf.inertias import Policy, with_repaired_inertias
from linkwright.stages.graph.urdf.naming import UrdfFileNames, names_of
from linkwright.stages.graph.urdf.srdf import with_srdf
from linkwright.stages.graph.urdf.structure import SCALAR_TYPES, check_structure, top_ancestors
from linkwright.stages.robot.bundle import Bundle, FileBundle
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.dynamics.inertia import ZERO, moved
from linkwright.stages.robot.errors import Diagnostic
from linkwright.stages.robot.model.poses import at_rest
from linkwright.stages.robot.model.robot import (
    Array,
    Dof,
    DofKind,
    Dynamics,
    JointType,
    Limits,
    MateRef,
    MeshRef,
    Part,
    Primitive,
    Provenance,
    frozen,
)
from linkwright.stages.robot.motion.kinematics import chain

TYPES: Mapping[str, JointType] = {
    "fixed": "fixed",
    "revolute": "revolute",
    "continuous": "revolute",
    "prismatic": "prismatic",
    "planar": "planar",
    "floating": "free",
}

UNSTATED_BASE = Diagnostic(
    "I-URDF-BASE",
    "a URDF does not say whether its base is fixed: it is treated as free",
    hint="if it is fixed to the ground: root=fixed",
)


def read_mechanism(
    bundle: FileBundle, keys: GraphSections, log: Diagnostics
) -> tuple[Mechanism, GraphSections]:
    """Reads a URDF; raises AssemblyError with all problems of its structure at once.

    Links without a body become frames, and impossible inertias are repaired as the source's key
    `bad_inertia` asks. The joints are at zero, followers at their mimic's values.
    """
    urdf = parse(bundle.body(bundle.definition), bundle.root["document"])
    log.add(urdf.diagnostics)
    check_structure(urdf, keys.root.disconnected != "error", log)
    report_unused(keys, "URDF", log)
    log.raise_errors()
    file_urdf = urdf
    urdf, frames = without_dummies(urdf, log)
    policy = cast(Policy, bundle.options.get("bad_inertia", "refuse"))
    urdf = with_repaired_inertias(urdf, policy, bundle, log)
    urdf = with_carriers(urdf, policy != "refuse", log)
    root = _root(urdf)
    names = names_of(urdf, frames, log)
    dofs = _with_saved_values({joint.name: tuple(_dofs(joint, names, log)) for joint in urdf.joints}, urdf)
    world_from_link = _poses(urdf, dofs)
    index_of_link = {link.name: number for number, link in enumerate(urdf.links)}
    mechanism = Mechanism(
        bodies=tuple(_body(link, world_from_link[link.name], names, bundle, log) for link in urdf.links),
        connections=tuple(
            _connection(joint, dofs, names, index_of_link, world_from_link) for joint in urdf.joints
        ),
        relations=tuple(_relations(urdf, names, log)),
        markers=tuple(_marker(frame, names, index_of_link, world_from_link) for frame in frames),
        provenance=Provenance(**bundle.root),
        root=index_of_link[root],
        has_saved_pose=False,
        transmissions=urdf.transmissions,
        controls=urdf.controls,
        unstated_base=UNSTATED_BASE,
        demands_limits=True,
    )
    return with_srdf(mechanism, bundle, (file_urdf, frames, names), log), keys


def _root(urdf: Urdf) -> str:
    """Returns the link without a parent; of several, that with the most links below it, then the first by
    name."""
    parents = {joint.child: joint.parent for joint in urdf.joints}
    top = top_ancestors(parents)
    count = Counter(top.get(link.name, link.name) for link in urdf.links)
    return min(count, key=lambda name: (-count[name], name))


def _dofs(joint: UrdfJoint, names: UrdfFileNames, log: Diagnostics) -> Iterator[Dof]:
    dof_names = names.dofs[joint.name]
    zero = frozen(np.zeros(3))
    if joint.type in SCALAR_TYPES:
        kind: DofKind = "slide" if joint.type == "prismatic" else "turn"
        yield _dof(dof_names[0], kind, joint.axis, _limits(joint, log), _dynamics(joint, log))
    elif joint.type == "floating":
        yield _dof(dof_names[0], "free", zero, Limits(), Dynamics())
    elif joint.type == "planar":
        axes = (*_cross_axes(joint.axis), joint.axis)
        kinds: tuple[DofKind, ...] = ("slide", "slide", "turn")
        for name, planar_kind, axis in zip(dof_names, kinds, axes, strict=True):
            yield _dof(name, planar_kind, axis, Limits(), Dynamics())


def _dof(name: str, kind: DofKind, axis: Array, limits: Limits, dynamics: Dynamics) -> Dof:
    return Dof(name, kind, frozen(axis + 0.0), frozen(np.eye(4)), limits, dynamics, at_rest(kind))


def _cross_axes(normal: Array) -> tuple[Array, Array]:
    """Returns two unit vectors (3,) that are right-handed with `normal` (3,): x and y, turned by the shortest
    rotation from z to `normal` (Duff et al., "Building an Orthonormal Basis, Revisited", 2017)."""
    x, y, z = (float(value) for value in normal)
    sign = 1.0 if z >= 0 else -1.0
    a = -1.0 / (sign + z)
    b = x * y * a
    first_axis = np.array([1.0 + sign * x * x * a, sign * b, -sign * x])
    return first_axis, np.array([b, sign + y * y * a, -y])


def _limits(joint: UrdfJoint, log: Diagnostics) -> Limits:
    """Returns the limits in the file. A range [0, 0], which a missing range looks like, counts as no limit
    (W-URDF-RANGE)."""
    if joint.type == "continuous" or joint.limits is None:
        return Limits()
    if (joint.limits.lower, joint.limits.upper) == (0.0, 0.0):
        text = "its range is missing or [0, 0], which would lock it: treated as a joint without limits"
        hint = "give it in the file or in joints:, or make the joint fixed or continuous"
        log.report("W-URDF-RANGE", text, joint.name, hint)
        return Limits()
    return joint.limits


def _dynamics(joint: UrdfJoint, log: Diagnostics) -> Dynamics:
    """Reports W-URDF-BOUND for a limit of effort or velocity that is not above zero, which is ignored."""
    bounds = {"effort": joint.effort, "velocity": joint.velocity}
    for name, value in bounds.items():
        if value is not None and value <= 0:
            text = f"its {name} limit {value:g} would not let it move: ignored"
            log.report("W-URDF-BOUND", text, joint.name, "give it in the file or in joints:")
            bounds[name] = None
    return Dynamics(joint.damping, joint.friction, joint.armature, **bounds)


def _with_saved_values(dofs: Mapping[str, tuple[Dof, ...]], urdf: Urdf) -> dict[str, tuple[Dof, ...]]:
    """Returns the dofs with followers at their mimic's values for drivers at zero."""
    mimics = {joint.name: joint.mimic for joint in urdf.joints if joint.mimic and joint.type in SCALAR_TYPES}

    values: dict[str, float] = {}
    for name in mimics:
        path = []
        while name in mimics and name not in values:
            path.append(name)
            name = mimics[name].joint
        for follower in reversed(path):
            mimic = mimics[follower]
            values[follower] = mimic.multiplier * values.get(mimic.joint, 0.0) + mimic.offset
    return {
        name: tuple(replace(dof, saved=values[name]) for dof in joint_dofs) if name in values else joint_dofs
        for name, joint_dofs in dofs.items()
    }


def _poses(urdf: Urdf, dofs: Mapping[str, Sequence[Dof]]) -> dict[str, Array]:
    """Returns world_from_link (4, 4) of every link at the saved values of the dofs; every root is at the
    origin."""
    joints_below: dict[str, list[UrdfJoint]] = {}
    for joint in urdf.joints:
        joints_below.setdefault(joint.parent, []).append(joint)
    children = {joint.child for joint in urdf.joints}
    poses = {link.name: np.eye(4) for link in urdf.links if link.name not in children}
    pending = list(poses)
    while pending:
        parent = pending.pop()
        for joint in joints_below.get(parent, ()):
            motion = chain(dofs[joint.name], {dof.name: dof.saved for dof in dofs[joint.name]})
            poses[joint.child] = poses[parent] @ joint.parent_from_joint @ motion
            pending.append(joint.child)
    return poses


def _body(
    link: UrdfLink, world_from_link: Array, names: UrdfFileNames, bundle: Bundle, log: Diagnostics
) -> RigidBody:
    name = names.links[link.name]
    weightless = is_massless(link.inertial)
    shapes = (*((shape, True) for shape in link.visuals), *((shape, False) for shape in link.collisions))
    return RigidBody(
        name=name,
        path=(link.name,),
        parts=tuple(_parts(link, world_from_link, bundle)),
        titles=frozenset({name, link.name}),
        fixed_reason="its root link is called world" if name == WORLD_LINK else "",
        world_from_body=frozen(world_from_link),
        own_inertial=None if weightless or link.inertial is None else moved(link.inertial, world_from_link),
        shapes=tuple(
            _primitive(shape, visual, world_from_link)
            for shape, visual in shapes
            if shape.kind != "mesh" and _has_size(shape, link, log)
        ),
    )


def _parts(link: UrdfLink, world_from_link: Array, bundle: Bundle) -> Iterator[Part]:
    """Yields the meshes, sorted by their paths."""
    roles = (("collision", link.collisions), ("visual", link.visuals))
    for role, shapes in roles:
        width = len(str(len(shapes)))
        for count, shape in enumerate(shapes, start=1):
            if shape.kind != "mesh":
                continue
            key = mesh_key(shape)
            digest = bundle.requests.get(f"mesh/{key}")
            pose = frozen(world_from_link @ shape.link_from_shape)
            yield Part(
                path=(link.name, role, f"{count:0{width}d}"),
                name=f"{link.name}/{role} {count}",
                part_id=key,
                mesh=MeshRef(digest, key) if digest else None,
                link_from_part=pose,
                world_from_part=pose,
                inertial=ZERO,
                volume=0.0,
                collides=role == "collision",
                seen=role == "visual",
            )


def _has_size(shape: UrdfShape, link: UrdfLink, log: Diagnostics) -> bool:
    if min(shape.size) > 0:
        return True
    text = (
        f"its {shape.kind} of {' x '.join(f'{length:g}' for length in shape.size)} m has no extent: left out"
    )
    log.report("W-URDF-SHAPE", text, link.name, "give it a size, or remove it")
    return False


def _primitive(shape: UrdfShape, visual: bool, world_from_link: Array) -> Primitive:
    assert shape.kind != "mesh"
    pose = frozen(world_from_link @ shape.link_from_shape)
    return Primitive(shape.kind, shape.size, pose, shape.colour, visual=visual, collision=not visual)


def _connection(
    joint: UrdfJoint,
    dofs: Mapping[str, tuple[Dof, ...]],
    names: UrdfFileNames,
    numbers: Mapping[str, int],
    world_from_link: Mapping[str, Array],
) -> Connection:
    return Connection(
        name=names.joints[joint.name],
        type=TYPES[joint.type],
        bodies=(numbers[joint.child], numbers[joint.parent]),
        world_from_frames=(
            frozen(world_from_link[joint.child]),
            frozen(world_from_link[joint.parent] @ joint.parent_from_joint),
        ),
        dofs=dofs[joint.name],
        residual=0.0,
        ref=MateRef((), joint.name, joint.name, joint.type),
        title=joint.name,
    )


def _relations(urdf: Urdf, names: UrdfFileNames, log: Diagnostics) -> Iterator[RelationSpec]:
    for joint in urdf.joints:
        if joint.mimic is None:
            continue
        if joint.type not in SCALAR_TYPES:
            text = f"a joint of type {joint.type} cannot follow another joint: its <mimic> is left out"
            log.report("W-URDF-MIMIC", text, joint.name, "remove it")
            continue
        yield RelationSpec(
            title=names.relations[joint.name],
            name=names.relations[joint.name],
            type="MIMIC",
            connections=(names.joints[joint.mimic.joint], names.joints[joint.name]),
            ratio=joint.mimic.multiplier,
            length=0.0,
            reverse=False,
            offset=joint.mimic.offset,
        )


def _marker(
    frame: UrdfFrame, names: UrdfFileNames, numbers: Mapping[str, int], world_from_link: Mapping[str, Array]
) -> Marker:
    pose = frozen(world_from_link[frame.link] @ frame.link_from_frame)
    name, joint = names.frames[frame.name], names.joints[frame.joint]
    return Marker(name, frame.name, numbers[frame.link], pose, frame.name, joint)
