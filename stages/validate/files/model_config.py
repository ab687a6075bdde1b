"""Checks model.config, by which Gazebo finds the SDF of a folder."""

from collections.abc import Iterator
from pathlib import Path

from linkwright.stages.formats.xml import Element, Malformed, parse
from linkwright.stages.robot.check import Check, Finding
from linkwright.stages.validate.findings import differs, few
from linkwright.stages.validate.reading.documents import sentence

CODE = "C-SDF"

FILE = "model.config"


def model_config(folder: Path, robot: str) -> Iterator[Check]:
    """Checks that the file is XML, that it names the SDF of the robot with its version, and that every file
    that it names exists. Skips folders without a model.config."""
    path = folder / FILE
    if not path.is_file():
        return
    try:
        findings = list(_findings(folder, parse(path.read_bytes()), f"{robot}.sdf"))
    except Malformed as error:
        findings = [Finding("XML", "", error.place)]
    detail = sentence(tuple(findings)) if findings else "the SDF that it names is there"
    number = float(len(findings))
    yield Check(f"{FILE}: names", not findings, detail, number, 0.0, CODE, "error", few(findings))


def _findings(folder: Path, root: Element, expected: str) -> Iterator[Finding]:
    nodes_by_name = {(node.text or "").strip(): node for node in root.findall("sdf")}
    for name, node in nodes_by_name.items():
        if not name or not (folder / name).is_file():
            yield Finding("sdf", "", f'"{name}" does not exist, expected "{expected}"')
            continue
        version = _version(folder / name)
        if version and node.get("version") != version:
            yield differs("sdf", "version", node.get("version"), version)
    if expected not in nodes_by_name and all((folder / name).is_file() for name in nodes_by_name):
        yield Finding("sdf", "", f'names {", ".join(nodes_by_name) or "none"}, expected "{expected}"')


def _version(path: Path) -> str:
    """Returns the version of an SDF; "" if it cannot be read, which another check reports."""
    try:
        return str(parse(path.read_bytes()).get("version", ""))
    except Malformed:
        return ""
