"""SDF: the model, and the file by which Gazebo finds it."""

from typing import TYPE_CHECKING, Any

from stages.export.writer import Exported, WriterInput

if TYPE_CHECKING:
    from stages.export.sdf.model import SdfPlan


class SdfWriter:
    """`<name>.sdf` and `model.config`."""

    reads: tuple[str, ...] = ()
    modules: tuple[str, ...] = ("stages.export.sdf.model",)

    def paths(self, robot: str) -> tuple[str, ...]:
        return (f"{robot}.sdf", "model.config")

    def write(self, given: WriterInput) -> Exported:
        from stages.export.sdf.keys import SdfFormatKeys
        from stages.export.sdf.model import write_config, write_sdf
        from stages.export.sdf.unsupported import unsupported

        plan = _plan(given)
        model, config = self.paths(given.robot.name)
        keys = given.keys.export.sdf or SdfFormatKeys()
        files = {
            model: write_sdf(given.robot, given.geometry, keys, plan),
            config: write_config(given.robot.name),
        }
        losses = tuple(unsupported(given.robot, given.geometry, given.actuation, plan))
        return Exported(files, losses, record={"sdf": _record(plan)})


def _record(plan: "SdfPlan") -> dict[str, Any]:
    """What robot.json tells of the SDF."""
    from stages.export.json_values import as_value

    renamed: dict[str, dict[str, str]] = {"links": {}, "joints": {}, "frames": {}}
    for kind, name, own in plan.names.changed:
        renamed[f"{kind}s"][name] = own
    zeros = {name: as_value(value) for name, value in plan.lowered.moved.items()}
    return {"renamed": renamed, "zeros": zeros}


def _plan(given: WriterInput) -> "SdfPlan":
    from stages.export.sdf.contacts import sdf_contacts
    from stages.export.sdf.lowering import lower
    from stages.export.sdf.model import SdfPlan
    from stages.export.sdf.sensors import sensors_of
    from stages.formats.sdf.names import sdf_names

    robot, geometry = given.robot, given.geometry
    names = sdf_names(robot)
    lowered = lower(robot, given.start, names)
    # Engines leave out by themselves what a joint of their tree joins, but not what closes a loop.
    link = {own: name for name, own in names.links.items()}
    tree = [joint for joint in lowered.joints if joint.carries and {joint.parent, joint.child} <= link.keys()]
    joined = {frozenset((link[joint.parent], link[joint.child])) for joint in tree}
    held = [joint.child for joint in robot.joints if joint.type != "free"]
    solid = sorted({shape.link for shape in geometry.shapes if shape.role == "collision"})
    return SdfPlan(
        names,
        lowered,
        sensors_of(robot, given.sensing, held, solid),
        sdf_contacts(geometry, joined),
        given.standing.placed(lowered.stands),
    )


WRITER = SdfWriter()
