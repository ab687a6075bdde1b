"""The scene of a robot.json."""

from stages.formats.robot_json.fields import Fields
from stages.robot.scene import Ground, Scene, Setting


def scene_of(record: Fields) -> Scene | None:
    """None where a build ended before it had a scene."""
    if not record.has("scene"):
        return None
    table = record.inside("scene")
    options = table.inside("option")
    flags = table.inside("flag")
    poses = table.inside("keyframes")
    return Scene(
        table.pose("pose"),
        tuple((name, poses.pose(name)) for name in poses.table),
        _ground(table.inside("ground")) if table.has("ground") else None,
        {name: setting_of(options, name) for name in options.table},
        {name: flags.text(name) for name in flags.table},
    )


def _ground(record: Fields) -> Ground:
    first, second, third = record.numbers("friction", 3)
    return Ground(record.pose("pose"), (first, second, third))


def setting_of(record: Fields, key: str) -> Setting:
    """A word, a number or several numbers."""
    found = record.table[key]
    if isinstance(found, str):
        return record.text(key)
    return record.numbers(key) if isinstance(found, list) else record.number(key)
