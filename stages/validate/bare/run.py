"""Runs the checks of a bare file."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

from linkwright.stages.robot.check import Check, Finding
from linkwright.stages.validate.bare import (
    ENDINGS,
    mesh_units,
    mjcf_figures,
    mjcf_keys,
    mjcf_values,
    urdf_figures,
    urdf_tree,
    urdf_values,
)
from linkwright.stages.validate.bare.bodies import (
    MAX_MASS_RATIO,
    collider_findings,
    lump_inertials,
    mass_ratio_findings,
    massless_findings,
)
from linkwright.stages.validate.bare.figures import BareBody, Lump, grouped_lumps
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
    """Checks a file. Adds its document and its model to `compiled`, if it compiles."""
    document, check = read_checked(path)
    yield check
    if document is None or document.language is None:
        return
    document = replace(document, foreign=True)
    yield from check_document(document)
    trial = compile_and_simulate(document)
    if trial.model is not None:
        compiled.append(CompiledDocument(document, trial.model))
    bodies = _body_figures(document, trial.model)
    lumps = grouped_lumps(bodies)
    yield from _bare_checks(document, bodies, lumps)
    yield from _body_checks(document.path, lumps)
    yield from trial.checks


def _body_figures(document: ModelDocument, model: object) -> list[BareBody]:
    """Returns the bodies of a file; an empty list for an MJCF that does not compile."""
    if document.language == "urdf":
        return urdf_figures.figures(document)
    return [] if model is None else mjcf_figures.figures(model)


def _body_checks(path: Path, lumps: Sequence[Lump]) -> Iterator[Check]:
    """Checks bodies, each with the bodies that are fixed to it. The codes are those of a build."""
    yield from inertials.checks(path.name, lump_inertials(lumps))
    level, findings = collider_findings(lumps)
    passed = "the colliders are where the visual shapes are"
    yield check_of(path, "colliders", "C-COLLIDER", level, findings, passed)
    passed = f"neighbours' masses differ by less than {MAX_MASS_RATIO:g} to 1"
    yield check_of(path, "mass ratio", "C-MASS-RATIO", "warning", mass_ratio_findings(lumps), passed)


def _bare_checks(
    document: ModelDocument, bodies: Sequence[BareBody], lumps: Sequence[Lump]
) -> Iterator[Check]:
    """Yields a result for each entry of `BARE_CHECKS` that applies to the file's language."""
    findings_by_code: dict[str, list[Finding]] = {code: [] for code in BARE_CHECKS}
    for code, finding in _findings(document, bodies, lumps):
        findings_by_code[code].append(finding)
    for code, findings in findings_by_code.items():
        if _applies(code, document.language == "urdf"):
            check = BARE_CHECKS[code]
            yield check_of(document.path, check.name, code, check.level, findings, check.passed_text)


def _applies(code: str, urdf: bool) -> bool:
    """Tells whether a check applies to a URDF (`urdf`), or to an MJCF."""
    return code not in (("C-KEYS",) if urdf else ("C-TREE", "C-MIMIC"))


def _findings(
    document: ModelDocument, bodies: Sequence[BareBody], lumps: Sequence[Lump]
) -> Iterator[CodedFinding]:
    if document.language == "urdf":
        yield from urdf_tree.check(document)
        yield from urdf_values.check(document)
        yield from massless_findings(lumps)
    else:
        yield from mjcf_values.check(document)
        yield from mjcf_keys.check(document)
    yield from mesh_units.check(bodies)
