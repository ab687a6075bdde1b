"""Whether the names by which tables of a robot.json refer to each other are there."""

from collections import Counter
from collections.abc import Collection, Iterable

from stages.formats.robot_json.fields import Fields, RobotJsonError
from stages.robot.model import Robot

OF_LINKS = {
    "loops": ("link_a", "link_b"),
    "frames": ("link",),
    "merged": ("link", "into"),
    "fused": ("link", "into"),
    "sensor_sites": ("link",),
    "cameras": ("link",),
    "shapes": ("link",),
    "colliders": ("link",),
    "excludes": ("link_a", "link_b"),
    "touching": ("link_a", "link_b"),
    "compensated": ("link",),
}
"""Table → its fields that name links."""

OF_DOFS = {
    "relations": ("follower", "driver"),
    "couplings": ("follower", "driver"),
    "actuators": ("dof",),
    "armatures": ("dof",),
}
"""Table → its fields that name dofs."""


def require_names(record: Fields, robot: Robot) -> None:
    """RobotJsonError for a name of a link or dof that there is not, and for one that is there twice."""
    links = [link.name for link in robot.links]
    loops = [dof.name for loop in robot.loops for dof in loop.dofs]
    dofs = [dof.name for dof in robot.dofs]
    for what, names in (("links", links), ("joints", [*dofs, *loops])):
        twice = sorted(name for name, number in Counter(names).items() if number > 1)
        if twice:
            msg = f"{what}: {twice[0]!r} is there twice"
            raise RobotJsonError(msg)
    for tables, known, kind in ((OF_LINKS, set(links), "link"), (OF_DOFS, {*dofs, *loops}, "joint")):
        for table, keys in tables.items():
            _require(record.records(table), keys, known, kind)


def _require(rows: Iterable[Fields], keys: Iterable[str], known: Collection[str], kind: str) -> None:
    for row in rows:
        for key in keys:
            if row.text(key) not in known:
                msg = f"{row.place}.{key}: there is no {kind} {row.text(key)!r}"
                raise RobotJsonError(msg)
