"""Writes robot.json, from the records that `stages.formats.robot_json` defines."""

import json
from collections import Counter
from collections.abc import Collection, Iterator, Mapping
from types import MappingProxyType
from typing import Any

from linkwright.stages.export.mjcf.joints import free_joint_name
from linkwright.stages.export.provenance import provenance
from linkwright.stages.export.urdf.lowering import lower, unset_limits
from linkwright.stages.formats.robot_json import FORMAT, VERSION
from linkwright.stages.formats.robot_json.codec import write
from linkwright.stages.formats.robot_json.files import (
    MergedLinkRecord,
    OrderRecord,
    SplitJointRecord,
    UrdfPackageRecord,
)
from linkwright.stages.formats.robot_json.joints import (
    BallZeroRecord,
    DofRecord,
    FrameRecord,
    JointRecord,
    LoopRecord,
)
from linkwright.stages.formats.robot_json.robot import BaseRecord, RobotRecord
from linkwright.stages.formats.robot_json.scene import KeyframeRecord
from linkwright.stages.formats.robot_json.shapes import ColliderRecord, ShapeRecord
from linkwright.stages.formats.robot_json.values import PoseRecord
from linkwright.stages.formats.written import FormatView, Written
from linkwright.stages.robot.model.geometry import Geometry
from linkwright.stages.robot.model.poses import at_rest
from linkwright.stages.robot.model.robot import Dof, Joint, Loop, Robot
from linkwright.stages.robot.motion.start_pose import SAVED, keyframes
from linkwright.stages.robot.text.printable import printable_lines


def describe(
    written: Written,
    order: OrderRecord | None = None,
    formats: Mapping[str, Any] = MappingProxyType({}),
    files: Collection[str] = (),
) -> bytes:
    """Returns the content of robot.json. `formats`: key → record of a format; `files`: the paths of all
    files."""
    robot, geometry = written.robot, written.geometry
    estimated = {armature.dof for armature in written.actuation.armatures}
    frames = written.urdf_names.frames
    package = written.urdf_form.package
    record = RobotRecord.from_model(
        robot,
        format=FORMAT,
        version=VERSION,
        root=robot.root.name,
        base=BaseRecord.from_model(robot.base, joint=None if robot.base.fixed else free_joint_name(robot)),
        total_mass=sum(link.inertial.mass for link in robot.links),
        joints=[_joint(written, joint, estimated) for joint in robot.joints],
        loops=[_loop(written, loop, estimated) for loop in robot.loops],
        frames=[FrameRecord.from_model(frame, urdf=frames[frame.name]) for frame in robot.frames],
        lowered=[
            SplitJointRecord(item.joint.name, tuple(joint.name for joint in item.joints), item.added_links)
            for item in lower(robot)
            if item.added_links
        ],
        couplings=written.urdf_form.couplings,
        urdf=UrdfPackageRecord(package) if package else None,
        merged=_merged_links(written.as_urdf),
        fused=_merged_links(written.as_mjcf),
        mjcf=written.mjcf_form.extras,
        actuation=written.actuation,
        keyframes=list(_keyframes(robot)),
        sensing=written.sensing,
        order=order,
        scene=written.scene,
        amendments=written.amendments.changes,
        surplus=written.amendments.surplus,
        files=tuple(sorted(files)),
        **({} if geometry is None else _shapes(geometry)),
        **formats,
    )
    return (printable_lines(json.dumps(write(record), indent=2, ensure_ascii=False)) + "\n").encode()


def _joint(written: Written, joint: Joint, estimated: Collection[str]) -> JointRecord:
    """Returns the record of a joint. `estimated`: the dofs whose armature is estimated."""
    start = written.start
    dofs = [
        DofRecord.from_model(
            dof,
            mate_quat=_mate_quat(dof, joint.backwards),
            unset=unset_limits(dof),
            provenance=provenance(dof, dof.name in estimated, written.actuation.supplied),
            estimated=("armature",) if dof.name in estimated else (),
            qpos0=start[dof.name],
            zero=BallZeroRecord(at_rest("ball"), start[dof.name]) if dof.kind == "ball" else None,
        )
        for dof in joint.dofs
    ]
    return JointRecord.from_model(joint, dofs=dofs)


def _mate_quat(dof: Dof, backwards: bool = False) -> tuple[float, ...] | None:
    """Returns the quaternion (w, x, y, z) of a ball's saved value, in the direction of its mate; None for
    other dofs, and without a saved value."""
    if dof.kind != "ball" or not isinstance(dof.saved, tuple):
        return None
    w, x, y, z = dof.saved
    return (w, -x, -y, -z) if backwards else dof.saved


def _loop(written: Written, loop: Loop, estimated: Collection[str]) -> LoopRecord:
    dofs = [
        DofRecord.from_model(
            dof, mate_quat=_mate_quat(dof), provenance=provenance(dof, dof.name in estimated)
        )
        for dof in loop.dofs
    ]
    ends, closed = written.urdf_names.ends[loop.name], written.urdf_form.closed
    return LoopRecord.from_model(loop, urdf=ends, mimic=loop.name in closed, dofs=dofs)


def _merged_links(view: FormatView) -> tuple[MergedLinkRecord, ...]:
    """Returns the links that a format merges into others."""
    holders = ((link, *holder) for link, holder in view.held.items())
    return tuple(
        MergedLinkRecord(link, into, PoseRecord.from_model(pose))
        for link, into, pose in holders
        if into != link
    )


def _keyframes(robot: Robot) -> Iterator[KeyframeRecord]:
    values_by_name = {keyframe.name: keyframe.given for keyframe in robot.keyframes}
    for name, values in keyframes(robot).items():
        if name != SAVED:
            yield KeyframeRecord(name, values_by_name.get(name, ()), values)


def _shapes(geometry: Geometry) -> dict[str, Any]:
    """Returns the tables of shapes and colliders, with numbered rows."""
    row_counts: Counter[tuple[str, ...]] = Counter()

    def number(*key: str) -> int:
        """Returns the number of rows with this key so far, and counts another."""
        row_counts[key] += 1
        return row_counts[key] - 1

    return {
        "shapes": [
            ShapeRecord.from_model(shape, number=number(shape.link, shape.role)) for shape in geometry.shapes
        ],
        "colliders": [
            ColliderRecord(
                collider.link, number(collider.link), collider.parts, collider.rung, collider.reason
            )
            for collider in geometry.colliders
        ],
        "self_contact": geometry.self_contact,
        "excludes": geometry.excludes,
        "touching": geometry.touching,
        "whole_visuals": geometry.whole_visuals,
    }
