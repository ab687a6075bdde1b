"""The run of the checks of an SDF: no engine is needed, since its own reader has its kinematics."""

from collections.abc import Iterator
from pathlib import Path

from stages.formats.sdf.elements import SdfError
from stages.formats.sdf.names import sdf_names
from stages.formats.sdf.parse import parse_sdf
from stages.formats.written import Written
from stages.formats.xml import parse
from stages.robot.check import Check, Finding
from stages.validate.findings import few
from stages.validate.sdf.checks import CHECKS, links_and_joints
from stages.validate.sdf.contacts import contacts
from stages.validate.sdf.known import ReadSdf
from stages.validate.sdf.shapes import of_model, shapes

CODE = "C-SDF"


def _meshes(path: Path) -> Check:
    """Every mesh that the file names is there."""
    found = []
    texts = {node.text or "" for node in parse(path.read_bytes()).iterfind(".//mesh/uri")}
    for text in sorted(texts):
        inside = text.partition("://")[2].partition("/")[2] if "://" in text else text
        if not (path.parent / inside).is_file():
            found.append(Finding("mesh", "uri", f'"{text}" does not exist'))
    detail = f"missing: {', '.join(one.message for one in found[:3])}" if found else "every mesh is there"
    return Check(f"{path.name}: meshes", not found, detail, float(len(found)), 0.0, findings=few(found))


def check_file(path: Path, written: Written, *, quick: bool) -> Iterator[Check]:
    """The results. `quick`: only whether it can be read. Where a
    link or joint is missing, the checks that look for each by its name are left out."""
    try:
        model = parse_sdf(path.read_bytes())
    except SdfError as error:
        yield Check(f"{path.name}: reads", False, str(error))
        return
    yield Check(f"{path.name}: reads", True, "no errors")
    if quick:
        return
    yield _meshes(path)
    given = ReadSdf(path.name, model, written.robot, sdf_names(written.robot))
    complete = links_and_joints(given)
    yield complete
    if complete.passed:
        for check in CHECKS:
            yield from check(given)
        yield from of_model(given, written.scene)
        looks = list(shapes(given, written.geometry))
        yield from looks
        # Masks are those of the robot's colliders only where there are as many.
        if all(check.passed for check in looks):
            yield from contacts(given, written.geometry)
