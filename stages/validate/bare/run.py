"""The run of the checks of a bare file."""

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
from linkwright.stages.validate.bare.findings import CHECKS, Coded
from linkwright.stages.validate.bare.start import start
from linkwright.stages.validate.bare.together import Compiled, check_together
from linkwright.stages.validate.files.run import check_document, opened, result
from linkwright.stages.validate.model import inertials
from linkwright.stages.validate.reading.documents import ModelDocument, read


def check_bare(path: Path) -> tuple[Check, ...]:
    """The checks of a URDF or MJCF (a scene too); of a folder, of each that lies in it, and of the URDF and
    the MJCF of one robot against each other."""
    paths = [path]
    if path.is_dir():
        paths = sorted(one for one in path.iterdir() if one.suffix.lower() in ENDINGS)
    checks: list[Check] = []
    compiled: list[Compiled] = []
    for one in paths:
        document = read(one)
        # Other XML may lie beside models; what is no XML, with the ending of a model, is one that broke.
        if document is None or document.language is not None or not path.is_dir():
            checks += _check_file(one, compiled)
    return (*checks, *check_together(compiled))


def _check_file(path: Path, compiled: list[Compiled]) -> Iterator[Check]:
    """The checks of one file, whose model is added to those that were `compiled`."""
    document, check = opened(path)
    yield check
    if document is None or document.language is None:
        return
    document = replace(document, foreign=True)
    yield from check_document(document)
    started = start(document)
    if started.model is not None:
        compiled.append(Compiled(document, started.model))
    bodies = _bodies(document, started.model)
    together = lumps(bodies)
    yield from _coded(document, bodies, together)
    yield from _weighed(document.path, together)
    yield from started.checks


def _bodies(document: ModelDocument, model: object) -> list[WeighedBody]:
    """The bodies; none of an MJCF that does not compile."""
    if document.language == "urdf":
        return urdf_figures.figures(document)
    return [] if model is None else mjcf_figures.figures(model)


def _weighed(path: Path, together: Sequence[Lump]) -> Iterator[Check]:
    """The checks of bodies, each with what is fixed to it, by the codes that a build has for them."""
    yield from inertials.checks(path.name, bodies.inertials(together))
    level, findings = bodies.colliders(together)
    passed = "the colliders are where the visual shapes are"
    yield result(path, "colliders", "C-COLLIDER", level, findings, passed)
    passed = f"neighbours' masses differ by less than {bodies.RATIO:g} to 1"
    yield result(path, "mass ratio", "C-MASS-RATIO", "warning", bodies.neighbours(together), passed)


def _coded(
    document: ModelDocument, bodies: Sequence[WeighedBody], together: "Sequence[Lump]"
) -> Iterator[Check]:
    """The checks of what the text and the figures say, each of which may have several findings."""
    found: dict[str, list] = {code: [] for code in CHECKS}  # type: ignore[type-arg]
    for code, finding in _looks(document, bodies, together):
        found[code].append(finding)
    for code, findings in found.items():
        if _applies(code, document.language == "urdf"):
            check = CHECKS[code]
            yield result(document.path, check.name, code, check.level, findings, check.passed)


def _applies(code: str, urdf: bool) -> bool:
    return code not in (("C-KEYS",) if urdf else ("C-TREE", "C-MIMIC"))


def _looks(
    document: ModelDocument, bodies: Sequence[WeighedBody], together: "Sequence[Lump]"
) -> Iterable[Coded]:
    if document.language == "urdf":
        yield from urdf_tree.look(document)
        yield from urdf_values.look(document)
        yield from weightless(together)
    else:
        yield from mjcf_values.look(document)
        yield from mjcf_keys.look(document)
    yield from mesh_units.look(bodies)
