"""The file by which Gazebo finds the SDF of a folder."""

from collections.abc import Iterator
from pathlib import Path

from linkwright.stages.formats.xml import Element, Malformed, parse
from linkwright.stages.robot.check import Check, Finding
from linkwright.stages.validate.findings import differs, few
from linkwright.stages.validate.reading.documents import sentence

CODE = "C-SDF"

FILE = "model.config"


def model_config(folder: Path, robot: str) -> Iterator[Check]:
    """That it is XML, and that the SDF of a robot of this name is one that it names, with its version, and
    that every other is there. None where the folder has no such file."""
    path = folder / FILE
    if not path.is_file():
        return
    try:
        found = list(_findings(folder, parse(path.read_bytes()), f"{robot}.sdf"))
    except Malformed as error:
        found = [Finding("XML", "", error.place)]
    detail = sentence(tuple(found)) if found else "the SDF that it names is there"
    number = float(len(found))
    yield Check(f"{FILE}: names", not found, detail, number, 0.0, CODE, "error", few(found))


def _findings(folder: Path, root: Element, own: str) -> Iterator[Finding]:
    every = {(node.text or "").strip(): node for node in root.findall("sdf")}
    for name, node in every.items():
        if not name or not (folder / name).is_file():
            yield Finding("sdf", "", f'"{name}" does not exist, expected "{own}"')
            continue
        version = _version(folder / name)
        if version and node.get("version") != version:
            yield differs("sdf", "version", node.get("version"), version)
    if own not in every and all((folder / name).is_file() for name in every):
        yield Finding("sdf", "", f'names {", ".join(every) or "none"}, expected "{own}"')


def _version(path: Path) -> str:
    """That of an SDF; "" where it cannot be read, which is another check's."""
    try:
        return str(parse(path.read_bytes()).get("version", ""))
    except Malformed:
        return ""
