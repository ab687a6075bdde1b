"""What a robot.json has of the SRDF of its source."""

from stages.formats.robot_json.fields import Fields
from stages.robot.semantics import (
    NOTHING_MORE,
    DisabledPair,
    EndEffector,
    JointGroup,
    RobotSemantics,
    VirtualJoint,
)


def semantics_of(record: Fields) -> RobotSemantics:
    if not record.has("semantics"):
        return NOTHING_MORE
    table = record.inside("semantics")
    virtual = None
    if table.has("virtual_joint"):
        joint = table.inside("virtual_joint")
        virtual = VirtualJoint(joint.text("name"), joint.text("parent_frame"))
    return RobotSemantics(
        groups=tuple(
            JointGroup(one.text("name"), one.texts("joints"), one.text("base"), one.text("tip"))
            for one in table.records("groups")
        ),
        end_effectors=tuple(
            EndEffector(*(one.text(key) for key in ("name", "group", "parent_link", "parent_group")))
            for one in table.records("end_effectors")
        ),
        passive=table.texts("passive"),
        disabled=tuple(
            DisabledPair(*(one.text(key) for key in ("link_a", "link_b", "reason")))
            for one in table.records("disabled")
        ),
        virtual_joint=virtual,
    )
