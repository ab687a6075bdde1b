"""Writes a robot as URDF: its tree of links and joints.

Element rules are those of urdfdom's 1.0 format. The frame of a link is that of the joint above it; `rpy` are
angles about the fixed axes x, y, z. `stages.export.losses` lists what is lost.
"""

from linkwright.stages.export.paints import Paint, materials
from linkwright.stages.export.urdf.bodies import write_link, write_origin, write_shapes
from linkwright.stages.export.urdf.form import package_of
from linkwright.stages.export.urdf.joints import write_joint
from linkwright.stages.export.urdf.lowering import lower
from linkwright.stages.export.urdf.section import UrdfFormatSection
from linkwright.stages.formats.numbers import LENGTH, TURN, number, spaced
from linkwright.stages.formats.urdf.names import UrdfNames
from linkwright.stages.formats.written import Written
from linkwright.stages.formats.xml import Element, element, parse, to_bytes
from linkwright.stages.robot.dynamics.inertia import TINY_INERTIAL, ZERO
from linkwright.stages.robot.model.geometry import Geometry
from linkwright.stages.robot.model.robot import Inertial, Robot


def write_urdf(written: Written, keys: UrdfFormatSection | None = None) -> bytes:
    """Returns the robot as URDF, with paths and inertials as `keys` choose."""
    keys = keys or UrdfFormatSection()
    robot, holders, geometry = written.as_urdf.robot, written.as_urdf.held, written.shapes.with_whole_visuals
    assets = _assets_of(keys, robot.name)
    frame_inertial = TINY_INERTIAL if keys.frame_inertia == "tiny" else ZERO
    root = element(None, "robot", name=robot.name)
    # By default MuJoCo strips the mesh paths, fuses a fixed root with the world and discards the visuals. It
    # cannot read visuals that are GLB files, so it discards these.
    mujoco = element(root, "mujoco")
    discards_visuals = "true" if geometry.whole_visuals else "false"
    element(mujoco, "compiler", strippath="false", fusestatic="false", discardvisual=discards_visuals)
    material_names = _write_materials(root, geometry, assets)
    links_with_shapes = {holders[shape.link][0] for shape in geometry.shapes}
    shapes = geometry.by_link()
    links_by_holder: dict[str, list[str]] = {}
    for name, (holder, _) in holders.items():
        links_by_holder.setdefault(holder, []).append(name)
    for link in robot.links:
        # A root called `world` is the world itself, to which no engine gives a mass.
        needs_inertial = link.inertial.mass == 0 and link.name != "world"
        inertial = frame_inertial if needs_inertial else link.inertial
        node = write_link(root, link.name, inertial, link.name in links_with_shapes)
        write_shapes(
            node,
            [(name, holders[name][1]) for name in links_by_holder[link.name]],
            shapes,
            material_names,
            assets,
        )
    chains = lower(robot)
    for chain in chains:
        for name in chain.added_links:
            write_link(root, name, TINY_INERTIAL, False)
    relations = {relation.follower: relation for relation in robot.relations}
    for joint in (joint for chain in chains for joint in chain.joints):
        node = write_joint(root, joint)
        relation = relations.get(joint.name)
        if relation is not None:
            offset = number(relation.offset, least=LENGTH if joint.type == "prismatic" else TURN)
            element(
                node,
                "mimic",
                joint=relation.driver,
                multiplier=number(relation.multiplier),
                offset=None if offset == "0" else offset,
            )
    _write_frames(root, robot, written.urdf_names, frame_inertial)
    for text in robot.controls:
        root.append(parse(text.encode()))
    return to_bytes(root)


def _assets_of(keys: UrdfFormatSection, robot: str) -> str:
    """Returns the prefix of mesh paths in the URDF of a robot of this name."""
    package = package_of(keys, robot)
    return f"package://{package}/assets/" if package else "assets/"


def _write_materials(root: Element, geometry: Geometry, assets: str) -> dict[Paint, str]:
    """Writes the materials, and returns their names. `assets`: the prefix of image paths."""
    names = materials(geometry)
    for (colour, texture), name in names.items():
        node = element(root, "material", name=name)
        element(node, "color", rgba=spaced(colour))
        if texture:
            element(node, "texture", filename=f"{assets}{texture}")
    return names


def _write_frames(root: Element, robot: Robot, names: UrdfNames, frame_inertial: Inertial) -> None:
    """Writes frames, and both sides of every loop, as links on fixed joints, with this inertial."""
    markers = [(names.frames[frame.name], frame.link, frame.link_from_frame) for frame in robot.frames]
    for loop in robot.loops:
        first, second = names.ends[loop.name]
        markers.append((first, loop.link_a, loop.a_from_frame))
        markers.append((second, loop.link_b, loop.b_from_frame))
    for name, parent, pose in markers:
        write_link(root, name, frame_inertial, False)
        node = element(root, "joint", name=names.holders[name], type="fixed")
        write_origin(node, pose)
        element(node, "parent", link=parent)
        element(node, "child", link=name)
