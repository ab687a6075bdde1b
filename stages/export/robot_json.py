"""robot.json: the model in no simulator's format, with its origins in CAD.

Poses are {xyz [m], quat (w, x, y, z)}; inertia is the 3x3 tensor about the centre of mass in the link's
axes [kg m²]. A part that is `mirrored` has the quat of R·diag(1, 1, -1), R the orthogonal matrix of its
left-handed pose. `root_pose` is the root link's in the assembly. `cad` identifies the thing in the
document: null where CAD does not have it. A part's `mass`, `com`, `inertia` and `volume` [m³] are CAD's, in
its own frame; `pose` is in its link, `world` where its occurrence stands in the assembly; `visual` and
`collision`: whether its shape is seen, and whether it collides; `estimated`: whether its mass is.

Every joint has its `dofs`, from parent to child, each with an axis (null for a ball and for free
motion) in its own frame, and the `origin` of that in the frame which the dof before it moves
(null where they are the same). Values are numbers [rad or m], a ball's quaternion, or the seven
numbers of free motion (x, y, z, quat). `mate` is the way back to the mate's own value, as CAD shows it:
zero + sign · value; of a ball or free motion the pose `zero` times the value. A ball's are its chain's,
from parent to child; `mate_quat` is the saved value as the mate has it: the inverse where the joint runs
backwards. A ball's q = 0 is its mate's zero in the URDF, but its pose at qpos0 in the MJCF, which has no
`ref` for it: `zero` has both.
`lowered` lists the joints that are several joints in the URDF, with links between them, `merged` the links
that are part of others there, at this pose in them, and `fused` likewise those that are sites in the MJCF.
`urdf` is the URDF link of a frame; of a loop, the links of its first and second frame; `mimic`: whether
<mimic> joints alone close it there; `lever` [m] is a length on the loop's own scale, `solref` MuJoCo's of
its constraints. `spring` is there where an MJCF source has one of a dof: its stiffness [N m/rad or N/m],
and the value at which it is slack. `couplings` has what closed loops make follow what: follower =
multiplier · driver + offset, off by at most `error` where the driver is in `range`; `mimic`: whether that is
exact, and so in the
URDF. `transmissions` is there where the source names what drives the joints; `actuators` where the robot
has any: `control` and `force` are ranges, `home` is the control at the keyframe of that name, `motor` one
of the library, `load` the largest force at the dof by the robot's weight, `home_load` that at home, and
`sag` how far it moves the servo's dof from a target there; `holds` is the force at the dof, with its sign,
that holds the robot in each keyframe, where one is needed. `provenance` says where a dof's limits and
dynamics come from.
`estimated` lists what Linkwright chose, of a dof too; of dofs `armatures` has the values and the reasons.
`compensated`: the links whose weight actuators carry, and the share; `compensating`: the dofs that do so.
`keyframes` are the named poses besides `cad`, which is `saved` of each dof: `values` of all dofs, also of
loops, and which of them are `given` by the user or the source. `semantics` is there where the source has an
SRDF: what that says besides, by the robot's names. `sensors` where the robot has any, in the order of
`sensordata`; `sensor_sites` are the places on links that are there for sensors alone (`size` [m] of the
`shape` in which contact is felt), `cameras` the cameras that it carries (`fovy` [deg], `resolution`
[pixels]): these look along z, x to the right, y down.
`order` has the joints, actuators and sensors of each file in its order. In
the MJCF: `qpos` and `dof` of a joint are its first number in MuJoCo's arrays and how many it has, as is
`ctrl` of an actuator; `address` and `dim` say where a sensor is in `sensordata`. In the URDF: `index` is a
joint's place among those that move in the file, `tree` that in a walk down the tree with siblings by name,
as Pinocchio has them.
`shapes` lists what is seen and what collides, of each link in the order in which its files have them
(`number` counts those of a role): a mesh `file` in the link's frame or a `primitive` (`size` as of the
`shapes` of a link, which are the user's own), `area` [m²], `volume` [m³, 0 where a mesh is not closed] and
`bounds` [m, of a mesh: the least x, y and z, and the largest] to six digits, `contact` what is given of
MuJoCo's properties, `collider` which one of its link it is a
piece of, `geom` the name that an MJCF source has for it and the attributes that no other format has,
`ellipsoid` what it is in the MJCF, where all other formats have a mesh. With `self_contact` the links collide
with each other but for the `excludes` (of `geoms`, only those pairs of colliders, by their numbers);
`touching` are others that touch at `home`, `depth` [m] deep. `colliders` says what each is `made` as and, of
those by contact, the `reason`.
These are missing where a build ends before its shapes are made.
`scene` says where the files put the robot (`pose` of its root at qpos0, and in the `keyframes`), which plane
is its `ground` (null: none), and what MuJoCo's `option` and `flag` say: all else is MuJoCo's default. It is
missing as `shapes` are. `urdf` is there where the URDF names its meshes by a `package`.
`amendments` lists what `elements` and `attributes` added to the files and set in them, `surplus` how many
degrees of freedom, actuators and equalities a file has after the robot's own by that. `files` has the paths
of the robot's other files, but for those of a Python package, which are copies.
`srdf`, `ros2`, `python`, `sdf` and `usd` are there where such files are written. Of the SRDF: `never` has for
a link of the URDF the later ones that it never meets, and `end_effectors` their names. Of a package: its
name, the version of its `writer`, and the `folder` of copies. `renamed` has the names in a format of links,
joints (by dof, also of loops) and frames that are not the robot's (in ROS 2: not the URDF's), `zeros` the
value of each dof that is not 0 where its joint of the format is (a ball's joint turns on from that pose).
`mjcf` is there where the source was an MJCF. It has what no other format has: where the source's `bodies`
are on the links, and the axes of their inertia; `attributes` of joints, sites and other things; what is
`mounted` on bodies; the elements of `sections` of the robot and of its `scene`, each with its `attributes`,
what it `names` (attribute: kind and name) and its `children`; the `order` of actuators and sensors; the
numbers in `qpos` of what moves in the scene, and of keyframes; `has_ground`: whether the scene has something
to stand on; and what its `option` and `flag` say.
"""

import json
from collections.abc import Collection, Mapping
from typing import Any

from stages.export.driving_records import actuation_records, sensing_records
from stages.export.form_records import form_records
from stages.export.geometry_records import geometry_records
from stages.export.joint_records import joint_record, loop_record
from stages.export.json_values import as_float, as_pose
from stages.export.link_records import link_record
from stages.export.mjcf.joints import free_joint_name
from stages.export.mjcf_records import mjcf_records
from stages.export.pose_records import pose_records
from stages.export.scene_records import scene_record
from stages.export.urdf.lowering import Lowered, lower
from stages.formats.numbers import TURN
from stages.formats.written import Written
from stages.robot.codec import plain
from stages.robot.model import Frame, Mobility, Provenance, Relation, Robot
from stages.robot.printable import printable_lines

FORMAT = "linkwright-robot"


def describe(
    written: Written,
    order: Mapping[str, Any] | None = None,
    formats: Mapping[str, Any] | None = None,
    files: Collection[str] = (),
) -> bytes:
    """The file. `order`: see `stages.export.order`; `formats`: the tables that the other files tell, by name;
    `files`: their paths."""
    robot, actuation, names = written.robot, written.actuation, written.urdf_names
    closed = written.urdf_form.closed
    estimated = {one.dof for one in actuation.armatures}
    table = {
        "format": FORMAT,
        "version": 1,
        "name": robot.name,
        "source": _source(robot.provenance),
        "root": robot.root.name,
        "root_pose": as_pose(robot.world_from_root),
        "base": _base(robot),
        "mass": as_float(sum(link.inertial.mass for link in robot.links)),
        "mobility": _mobility(robot.mobility),
        "links": [link_record(link) for link in robot.links],
        "joints": [
            joint_record(joint, written.start, estimated, actuation.supplied) for joint in robot.joints
        ],
        "relations": [_relation(relation) for relation in robot.relations],
        "loops": [
            loop_record(loop, names.ends[loop.name], loop.name in closed, estimated) for loop in robot.loops
        ],
        "frames": [_frame(frame, names.frames[frame.name]) for frame in robot.frames],
        "lowered": [_lowered(item) for item in lower(robot) if item.between],
    }
    table |= form_records(written.urdf_form) | _held(written)
    table |= mjcf_records(written.mjcf_form.extras)
    if robot.transmissions:
        table["transmissions"] = [plain(transmission) for transmission in robot.transmissions]
    table |= actuation_records(actuation)
    table |= pose_records(robot)
    table |= sensing_records(written.sensing)
    if order:
        table["order"] = order
    if written.geometry is not None:
        table |= geometry_records(written.geometry)
    if written.scene is not None:
        table["scene"] = scene_record(written.scene)
    for key, rows in (("amendments", written.amendments.changes), ("surplus", written.amendments.surplus)):
        if rows:
            table[key] = plain(rows)
    if files:
        table["files"] = sorted(files)
    table |= formats or {}
    return (printable_lines(json.dumps(table, indent=2, ensure_ascii=False)) + "\n").encode()


def _held(written: Written) -> dict[str, Any]:
    """The links that are part of others in the URDF, and in the MJCF, where there are some."""
    tables = {}
    for key, view in (("merged", written.as_urdf), ("fused", written.as_mjcf)):
        parts = [
            {"link": link, "into": into, "pose": as_pose(pose)}
            for link, (into, pose) in view.held.items()
            if into != link
        ]
        if parts:
            tables[key] = parts
    return tables


def _source(provenance: Provenance) -> dict[str, Any]:
    return {
        "document": provenance.document,
        "element": provenance.element,
        "microversion": provenance.microversion,
        "configuration": provenance.configuration,
    }


def _base(robot: Robot) -> dict[str, Any]:
    joint = None if robot.base.fixed else free_joint_name(robot)
    return {"fixed": robot.base.fixed, "reason": robot.base.reason, "joint": joint}


def _mobility(mobility: Mobility) -> dict[str, Any]:
    return {
        "coordinates": mobility.coordinates,
        "gruebler": mobility.gruebler,
        "dof": mobility.dof,
        "redundant": [{"loop": loop, "conditions": count} for loop, count in mobility.redundant],
    }


def _relation(relation: Relation) -> dict[str, Any]:
    return {
        "name": relation.name,
        "follower": relation.follower,
        "driver": relation.driver,
        "multiplier": as_float(relation.multiplier),
        "offset": as_float(relation.offset, TURN),
    }


def _frame(frame: Frame, urdf: str) -> dict[str, Any]:
    return {
        "name": frame.name,
        "link": frame.link,
        "urdf": urdf,
        **({"joint": frame.joint} if frame.joint else {}),
        "pose": as_pose(frame.link_from_frame),
        "cad": {"name": frame.source} if frame.source else None,
    }


def _lowered(item: Lowered) -> dict[str, Any]:
    return {
        "joint": item.joint.name,
        "joints": [joint.name for joint in item.joints],
        "links": list(item.between),
    }
