"""Runs the checks of a bare file."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path

from linkwright.stages.robot.check import Check
from linkwright.stages.validate.bare import (
    ENDINGS,
    bodies,
    mesh_units,
    mjcf_figures,
    mjcf_keys,
    mjcf_values,
    urdf_figures,
    urdf_tree,
    urdf_values,
)
from linkwright.stages.validate.bare.bodies import weightless
from linkwright.stages.validate.bare.figures import Lump, WeighedBody, lumps
from linkwright.stages.validate.bare.findings import BARE_CHECKS, CodedFinding
from linkwright.stages.validate.bare.start import compile_and_simulate
from linkwright.stages.validate.bare.urdf_against_mjcf import CompiledDocument, check_together
from linkwright.stages.validate.files.run import check_document, check_of, read_checked
from linkwright.stages.validate.model import inertials
from linkwright.stages.validate.reading.documents import ModelDocument, read


def check_bare(path: Path) -> tuple[Check, ...]:
    """Checks a URDF, an MJCF or a scene. In a folder it checks each model, and the URDF against the MJCF of
    the same robot."""
    paths = [path]
    if path.is_dir():
        paths = sorted(file for file in path.iterdir() if file.suffix.lower() in ENDINGS)
    checks: list[Check] = []
    compiled: list[CompiledDocument] = []
    for file in paths:
        document = read(file)
        # A folder may have other XML; a file with the ending of a model that is not XML is a broken model.
        if document is None or document.language is not None or not path.is_dir():
            checks += _check_file(file, compiled)
    return (*checks, *check_together(compiled))


def _check_file(path: Path, compiled: list[CompiledDocument]) -> Iterator[Check]:
    """Checks a file, whose model is added to `compiled`."""
    document, check = read_checked(path)
    yield check
    if document is None or document.language is None:
        return
    document = replace(document, foreign=True)
    yield from check_document(document)
    trial = compile_and_simulate(document)
    if trial.model is not None:
        compiled.append(CompiledDocument(document, trial.model))
    bodies = _bodies(document, trial.model)
    grouped = lumps(bodies)
    yield from _coded(document, bodies, grouped)
    yield from _weighed(document.path, grouped)
    yield from trial.checks


def _bodies(document: ModelDocument, model: object) -> list[WeighedBody]:
    """Returns the bodies; none for an MJCF that does not compile."""
    if document.language == "urdf":
        return urdf_figures.figures(document)
    return [] if model is None else mjcf_figures.figures(model)


def _weighed(path: Path, grouped: Sequence[Lump]) -> Iterator[Check]:
    """Checks bodies, each with the bodies that are fixed to it, under the codes of a build."""
    yield from inertials.checks(path.name, bodies.inertials(grouped))
    level, findings = bodies.colliders(grouped)
    passed = "the colliders are where the visual shapes are"
    yield check_of(path, "colliders", "C-COLLIDER", level, findings, passed)
    passed = f"neighbours' masses differ by less than {bodies.MAX_MASS_RATIO:g} to 1"
    yield check_of(path, "mass ratio", "C-MASS-RATIO", "warning", bodies.neighbours(grouped), passed)


def _coded(
    document: ModelDocument, bodies: Sequence[WeighedBody], grouped: "Sequence[Lump]"
) -> Iterator[Check]:
    """Checks the text and the figures; each check may have several findings."""
    by_code: dict[str, list] = {code: [] for code in BARE_CHECKS}  # type: ignore[type-arg]
    for code, finding in _findings(document, bodies, grouped):
        by_code[code].append(finding)
    for code, findings in by_code.items():
        if _applies(code, document.language == "urdf"):
            check = BARE_CHECKS[code]
            yield check_of(document.path, check.name, code, check.level, findings, check.passed_text)


def _applies(code: str, urdf: bool) -> bool:
    return code not in (("C-KEYS",) if urdf else ("C-TREE", "C-MIMIC"))


def _findings(
    document: ModelDocument, bodies: Sequence[WeighedBody], grouped: "Sequence[Lump]"
) -> Iterable[CodedFinding]:
    if document.language == "urdf":
        yield from urdf_tree.check(document)
        yield from urdf_values.check(document)
        yield from weightless(grouped)
    else:
        yield from mjcf_values.check(document)
        yield from mjcf_keys.check(document)
    yield from mesh_units.check(bodies)
