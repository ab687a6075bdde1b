"""Reads an MJCF into a mechanism: bodies and joints at qpos0, followers at the values of their drivers."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np

from linkwright.stages.formats.mjcf.model import Mjcf, MjcfBody, MjcfGeom
from linkwright.stages.graph.cad_only_keys import report_unused
from linkwright.stages.graph.dofs import reversed_dofs
from linkwright.stages.graph.mechanism import (
    WORLD_LINK,
    Connection,
    Marker,
    Mechanism,
    RelationSpec,
    RigidBody,
)
from linkwright.stages.graph.mjcf.actuation import actuators_of, sensors_of
from linkwright.stages.graph.mjcf.base import base_of, floats, link_bodies_of, root_of, tree_closure_joints
from linkwright.stages.graph.mjcf.equalities import closing_sites, connections, joints_of_closures
from linkwright.stages.graph.mjcf.extras import extras_of
from linkwright.stages.graph.mjcf.joints import SINGLE_JOINT_TYPES, Chain, body_joint, chain_of
from linkwright.stages.graph.mjcf.keyframes import keyframes_of
from linkwright.stages.graph.mjcf.naming import MjcfFileNames, names_of
from linkwright.stages.graph.relation_steps import followed_values
from linkwright.stages.graph.section import GraphSections
from linkwright.stages.robot import codec
from linkwright.stages.robot.bundle import Bundle
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.dynamics.inertia import ZERO, moved
from linkwright.stages.robot.errors import ProtocolError
from linkwright.stages.robot.model.poses import inverse
from linkwright.stages.robot.model.robot import (
    Array,
    Configuration,
    JointType,
    MateRef,
    Part,
    Primitive,
    Provenance,
    Value,
    frozen,
)
from linkwright.stages.robot.motion.kinematics import chain

NO_JOINT = "the MJCF has no joint between it and the world"


@dataclass(frozen=True, slots=True, eq=False)
class _Pose:
    """Poses (4, 4) in the world by the number of the body: of each body, of its link, and of the frame in
    which its chain of dofs starts."""

    world_from_body: Mapping[int, Array]
    world_from_link: Mapping[int, Array]
    world_from_start: Mapping[int, Array]


def read_mechanism(bundle: Bundle, keys: GraphSections, log: Diagnostics) -> tuple[Mechanism, GraphSections]:
    """Reads a compiled MJCF. Raises ProtocolError if the bundle does not contain one."""
    mjcf = _decode(bundle)
    log.add(mjcf.diagnostics)
    report_unused(keys, "MJCF", log)
    equalities = joints_of_closures(mjcf.closures)
    tree_equalities = tree_closure_joints(mjcf, equalities)
    for equality in tree_equalities:
        text = "without this equality its bodies would float apart: it became a joint between them"
        log.report(
            "W-MJCF-TREE", text, equality.closure.name or mjcf.name, "connect the two bodies by a joint"
        )
    names = names_of(mjcf, equalities, tree_equalities, closing_sites(equalities) | {WORLD_LINK}, log)
    chains, saved = _chains(mjcf, names)
    pose = _pose_of(mjcf, chains, saved)
    link_bodies = link_bodies_of(mjcf, equalities, keys.root.base == "free")
    index_of = {body: number for number, body in enumerate(link_bodies)}
    if 0 not in index_of:
        base = base_of(mjcf)
        index_of |= {} if base is None else {0: index_of[base]}
    loop_equalities = (
        (joint, *names.loops[index])
        for index, joint in enumerate(equalities)
        if len({index_of[body] for body in joint.closure.bodies}) > 1
    )
    closing = connections(loop_equalities, index_of, pose.world_from_body)
    root = root_of(mjcf, link_bodies)
    keyframes = keyframes_of(mjcf, names, root, log)
    link_from_body = {
        body: frozen(inverse(pose.world_from_link[body]) @ pose.world_from_body[body]) for body in link_bodies
    }
    mechanism = Mechanism(
        bodies=tuple(_body(mjcf, number, names, pose, index_of) for number in link_bodies),
        connections=(*_tree(mjcf, names, chains, pose, index_of), *closing),
        relations=tuple(_relations(mjcf, names)),
        markers=tuple(_markers(mjcf, names, pose, index_of, log)),
        provenance=Provenance(**bundle.root),
        root=index_of[root],
        has_saved_pose=False,
        actuators=actuators_of(mjcf, names),
        sensors=sensors_of(mjcf, names),
        keyframes=keyframes,
        mjcf=extras_of(mjcf, names, equalities, keyframes, link_from_body),
    )
    return mechanism, keys


def _decode(bundle: Bundle) -> Mjcf:
    try:
        mjcf = codec.load(Mjcf, bundle.body(bundle.definition))
        _require_tree(mjcf)
    except (AttributeError, IndexError, KeyError, TypeError, ValueError) as error:
        msg = f"the bundle does not hold a model: {type(error).__name__}: {error}"
        raise ProtocolError(msg, hint="make the bundle again") from None
    return mjcf


def _require_tree(mjcf: Mjcf) -> None:
    """Raises ValueError if a number refers to no element: a bundle may come from anyone."""
    joints = sum(len(body.joints) for body in mjcf.bodies)
    numbers = [number for closure in mjcf.closures for number in closure.bodies]
    ends = [number for relation in mjcf.relations for number in (relation.follower, relation.driver)]
    ends += [number for keyframe in mjcf.keyframes for number in (*dict(keyframe.values), *keyframe.moved)]
    in_range = all(0 <= number < len(mjcf.bodies) for number in numbers)
    in_range = in_range and all(0 <= number < joints for number in ends)
    if not in_range or any(not 0 <= body.parent < max(1, i) for i, body in enumerate(mjcf.bodies)):
        msg = "it refers to an element that does not exist"
        raise ValueError(msg)
    if len(mjcf.bodies) < 2:
        msg = "it has no body"
        raise ValueError(msg)


def _chains(mjcf: Mjcf, names: MjcfFileNames) -> tuple[dict[int, Chain], Configuration]:
    """Returns each body's dofs at qpos0 (followers at the values of their drivers), and those values."""
    chains = {number: chain_of(body, names.dofs[number]) for number, body in enumerate(mjcf.bodies)}
    saved = {dof.name: dof.saved for body_chain in chains.values() for dof in body_chain.dofs}
    saved |= followed_values(_relations(mjcf, names), saved)
    for number, body_chain in chains.items():
        dofs = tuple(replace(dof, saved=saved[dof.name]) for dof in body_chain.dofs)
        chains[number] = replace(body_chain, dofs=dofs)
    return chains, saved


def _pose_of(mjcf: Mjcf, chains: Mapping[int, Chain], saved: Mapping[str, Value]) -> _Pose:
    bodies: dict[int, Array] = {0: np.eye(4)}
    links: dict[int, Array] = {0: np.eye(4)}
    starts: dict[int, Array] = {}
    for number, body in enumerate(mjcf.bodies[1:], start=1):
        body_chain = chains[number]
        starts[number] = bodies[body.parent] @ body_chain.parent_from_start
        links[number] = starts[number] if floats(body) else starts[number] @ chain(body_chain.dofs, saved)
        bodies[number] = links[number] @ inverse(body_chain.body_from_link)
    return _Pose(bodies, links, starts)


def _body(
    mjcf: Mjcf, number: int, names: MjcfFileNames, pose: _Pose, numbers: Mapping[int, int]
) -> RigidBody:
    body = mjcf.bodies[number]
    name = names.links[number]
    fixed_reason = ""
    if number == 0:
        fixed_reason = "it is the world of the MJCF"
    elif 0 in numbers and numbers[0] == numbers[number]:
        fixed_reason = NO_JOINT
    world_from_body = pose.world_from_body[number]
    return RigidBody(
        name=name,
        path=(body.name or name,) if number else (),
        parts=tuple(_parts(body, name, world_from_body)),
        titles=frozenset({name, body.name or name}),
        fixed_reason=fixed_reason,
        world_from_body=pose.world_from_link[number],
        floating_joint=_free_joint(mjcf, number, names),
        own_inertial=None if body.inertial is None else moved(body.inertial, world_from_body),
        shapes=tuple(_primitive(geom, world_from_body) for geom in body.geoms if geom.kind != "mesh"),
    )


def _free_joint(mjcf: Mjcf, number: int, names: MjcfFileNames) -> str | None:
    """Returns the name of the joint by which a body floats, "" for an unnamed joint; None for other
    bodies."""
    body = mjcf.bodies[number]
    if not floats(body):
        return None
    if not body.joints[0].name:
        return ""
    return names.dofs[number][0]


def _parts(body: MjcfBody, name: str, world_from_body: Array) -> Iterator[Part]:
    meshes = [geom for geom in body.geoms if geom.mesh is not None]
    width = len(str(len(meshes)))
    for number_of_geom, geom in enumerate(meshes, start=1):
        assert geom.mesh is not None
        world_from_part = frozen(world_from_body @ geom.body_from_geom)
        yield Part(
            path=(body.name or name, "geom", f"{number_of_geom:0{width}d}"),
            name=f"{name}/{geom.form.name or f'geom {number_of_geom}'}",
            part_id=geom.mesh.part,
            mesh=geom.mesh,
            link_from_part=world_from_part,
            world_from_part=world_from_part,
            inertial=ZERO,
            volume=0.0,
            collides=geom.collides,
            seen=geom.seen,
            form=geom.form,
        )


def _primitive(geom: MjcfGeom, world_from_body: Array) -> Primitive:
    assert geom.kind != "mesh"
    pose = frozen(world_from_body @ geom.body_from_geom)
    look = geom.colour, geom.seen, geom.collides, geom.form
    return Primitive(geom.kind, geom.size, pose, *look)


def _tree(
    mjcf: Mjcf, names: MjcfFileNames, chains: Mapping[int, Chain], pose: _Pose, numbers: Mapping[int, int]
) -> Iterator[Connection]:
    """Yields the joints between each body and its parent, except those of floating bodies and of the base."""
    for number, body in enumerate(mjcf.bodies[1:], start=1):
        parent = numbers.get(body.parent)
        if parent is None or parent == numbers[number] or floats(body):
            continue
        dofs = chains[number].dofs
        name, kind, is_backwards = _joint_meaning(number, body, names, chains[number])
        frames = (pose.world_from_link[number], frozen(pose.world_from_start[number]))
        bodies = (numbers[number], parent)
        if is_backwards:
            frames, bodies, dofs = frames[::-1], bodies[::-1], reversed_dofs(dofs)
        types = "+".join(joint.type for joint in body.joints) or "fixed"
        title = ", ".join(joint.name or dof.name for joint, dof in zip(body.joints, chains[number].dofs))
        yield Connection(
            name=name,
            type=kind,
            bodies=bodies,
            world_from_frames=(frozen(frames[0]), frozen(frames[1])),
            dofs=dofs,
            residual=0.0,
            ref=MateRef((), name, title or name, types),
            title=title or name,
        )


def _joint_meaning(
    number: int, body: MjcfBody, names: MjcfFileNames, dofs_chain: Chain
) -> tuple[str, JointType, bool]:
    """Returns the name and the type of a body's joints as a single joint, and whether its dofs run backwards
    (see `BodyJoint`)."""
    name = names.joints[number]
    if not dofs_chain.dofs:
        return name, "fixed", False
    if len(dofs_chain.dofs) == 1:
        return name, SINGLE_JOINT_TYPES[body.joints[0].type], False
    combined_joint = body_joint(dofs_chain.dofs)
    return combined_joint.name or name, combined_joint.type, combined_joint.backwards


def _relations(mjcf: Mjcf, names: MjcfFileNames) -> Iterator[RelationSpec]:
    joints = [name for number in range(len(mjcf.bodies)) for name in names.dofs[number]]
    for index, relation in enumerate(mjcf.relations):
        yield RelationSpec(
            title=names.relations[index],
            name=names.relations[index],
            type="MIMIC",
            connections=(joints[relation.driver], joints[relation.follower]),
            ratio=relation.multiplier,
            length=0.0,
            reverse=False,
            offset=relation.offset,
        )


def _markers(
    mjcf: Mjcf, names: MjcfFileNames, pose: _Pose, numbers: Mapping[int, int], log: Diagnostics
) -> Iterator[Marker]:
    """Yields a marker for each site that becomes a frame. Reports W-FRAME for sites of a world that is no
    link."""
    lost_sites = []
    for (number, index), name in sorted(names.frames.items()):
        site = mjcf.bodies[number].sites[index]
        if number not in numbers:
            lost_sites.append(site.name)
            continue
        frame = frozen(pose.world_from_body[number] @ site.body_from_site)
        yield Marker(name, site.name, numbers[number], frame, site.name)
    if lost_sites:
        text = (
            f"sites of the world are left out, since the world is not a link: {', '.join(sorted(lost_sites))}"
        )
        log.report("W-FRAME", text, mjcf.name, "put them on a body")
