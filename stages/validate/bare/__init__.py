"""Checks of a URDF or MJCF alone: of what is wrong with a file whatever robot it is of."""

from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

    from stages.robot.check import Check
    from stages.validate.bare.findings import Coded
    from stages.validate.bare.together import Compiled
    from stages.validate.documents import ModelDocument

ENDINGS = (".urdf", ".xml", ".mjcf")
"""How the names of model files end."""


def check_bare(path: Path) -> "tuple[Check, ...]":
    """The checks of a URDF or MJCF (a scene too); of a folder, of each that lies in it, and of the URDF and
    the MJCF of one robot against each other."""
    from stages.validate.bare.together import Compiled, check_together
    from stages.validate.documents import read

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


def _check_file(path: Path, compiled: "list[Compiled]") -> "Iterator[Check]":
    """The checks of one file, whose model is added to those that were `compiled`."""
    from stages.validate.bare.start import start
    from stages.validate.bare.together import Compiled
    from stages.validate.files.run import check_document, opened

    document, check = opened(path)
    yield check
    if document is None or document.language is None:
        return
    yield from check_document(document, strange=True)
    started = start(document)
    if started.model is not None:
        compiled.append(Compiled(document, started.model))
    yield from _coded(document, started.model)
    yield from started.checks


def _coded(document: "ModelDocument", model: object) -> "Iterator[Check]":
    """The checks of what the text and the figures say, each of which may have several findings."""
    from stages.validate.bare.findings import CHECKS
    from stages.validate.files.run import result

    found: dict[str, list] = {code: [] for code in CHECKS}  # type: ignore[type-arg]
    for code, finding in _looks(document, model):
        found[code].append(finding)
    for code, findings in found.items():
        if _applies(code, document.language == "urdf"):
            check = CHECKS[code]
            yield result(document.path, check.name, code, check.level, findings, check.passed)


def _applies(code: str, urdf: bool) -> bool:
    return code not in (("C-KEYS",) if urdf else ("C-TREE", "C-MIMIC"))


def _looks(document: "ModelDocument", model: object) -> "Iterable[Coded]":
    from stages.validate.bare import (
        mjcf_figures,
        mjcf_keys,
        mjcf_values,
        plausible,
        urdf_figures,
        urdf_tree,
        urdf_values,
    )

    if document.language == "urdf":
        yield from urdf_tree.look(document)
        yield from urdf_values.look(document)
        yield from plausible.look(urdf_figures.figures(document))
    else:
        yield from mjcf_values.look(document)
        yield from mjcf_keys.look(document)
        if model is not None:
            yield from plausible.look(mjcf_figures.figures(model))
