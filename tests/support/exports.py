"""The files of a robot, in memory, and MuJoCo's model of them."""

import mujoco

from linkwright.stages.export import export
from linkwright.stages.validate import validate
from tests.support.building import NO_MESHES, plan_of


def exported(robot, geometry=NO_MESHES, **keys):
    """The export of a robot with these keys of the configuration (`plan_of`)."""
    return export(robot, geometry, plan_of(**keys))


def compiled(outcome):
    """The exported MJCF and its meshes as MuJoCo compiles them."""
    text = outcome.files[f"{outcome.written.robot.name}.xml"].decode()
    meshes = {path: data for path, data in outcome.files.items() if not path.endswith(".xml")}
    return mujoco.MjModel.from_xml_string(text, meshes)


def messages_of(outcome, code):
    """The messages of the diagnostics with this code."""
    return [diagnostic.message for diagnostic in outcome.diagnostics if diagnostic.code == code]


def losses_of(outcome, file):
    """What a file cannot say: code → message."""
    return {note.code: note.message for note in outcome.diagnostics if note.where.startswith(file)}


def failing(folder, outcome, plan):
    """The names of the checks that the files in a folder fail."""
    return [check.name for check in validate(folder, outcome.written, plan) if check.fails]
