"""Checks of a URDF or MJCF alone: of what is wrong with a file whatever robot it is of.

- bodies: The bodies of a bare file against their shapes and each other, by the codes that a build has for
  them.
- figures: What a body of a bare file weighs and how large it is, in whatever format it is written.
- findings: What the checks of a bare file give: findings, each with the code of its check.
- judged: Judgements of single numbers that are the same in every format.
- mesh_files: The points of a mesh file of any format that a build reads, but for PLY.
- mesh_units: Whether meshes have the size of the robot: a unit that was mixed up is off by a thousand.
- mjcf_defaults: The attributes of MJCF elements with what their classes give them.
- mjcf_figures: The bodies of an MJCF by mass and size, as MuJoCo compiled it.
- mjcf_keys: The keyframes of an MJCF: as many numbers as there are coordinates, within their limits.
- mjcf_values: The numbers of an MJCF's joints, bodies and actuators, as far as they can be judged each on its
  own.
- start: A bare file in MuJoCo: whether it compiles, how it starts, and whether a second of it stays finite.
- together: The URDF and the MJCF of one robot against each other: kinematics, masses and limits, by names.
- urdf_figures: The bodies of a URDF by mass and size, from its text and its meshes.
- urdf_tree: The tree of a URDF's links: one root, one parent for each other link, no cycle; and whom joints
  follow.
- urdf_values: The numbers of a URDF's joints and links, as far as they can be judged each on its own.
"""

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Sequence

    from linkwright.stages.robot.check import Check
    from linkwright.stages.validate.bare.figures import Lump, WeighedBody
    from linkwright.stages.validate.bare.findings import Coded
    from linkwright.stages.validate.bare.together import Compiled
    from linkwright.stages.validate.reading.documents import ModelDocument

ENDINGS = (".urdf", ".xml", ".mjcf")
"""How the names of model files end."""


def check_bare(path: Path) -> "tuple[Check, ...]":
    """The checks of a URDF or MJCF (a scene too); of a folder, of each that lies in it, and of the URDF and
    the MJCF of one robot against each other."""
    from linkwright.stages.validate.bare.together import Compiled, check_together
    from linkwright.stages.validate.reading.documents import read

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
    from linkwright.stages.validate.bare.figures import lumps
    from linkwright.stages.validate.bare.start import start
    from linkwright.stages.validate.bare.together import Compiled
    from linkwright.stages.validate.files.run import check_document, opened

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


def _bodies(document: "ModelDocument", model: object) -> "list[WeighedBody]":
    """The bodies; none of an MJCF that does not compile."""
    from linkwright.stages.validate.bare import mjcf_figures, urdf_figures

    if document.language == "urdf":
        return urdf_figures.figures(document)
    return [] if model is None else mjcf_figures.figures(model)


def _weighed(path: Path, together: "Sequence[Lump]") -> "Iterator[Check]":
    """The checks of bodies, each with what is fixed to it, by the codes that a build has for them."""
    from linkwright.stages.validate.bare import bodies
    from linkwright.stages.validate.files.run import result
    from linkwright.stages.validate.model import inertials

    yield from inertials.checks(path.name, bodies.inertials(together))
    level, findings = bodies.colliders(together)
    passed = "the colliders are where the visual shapes are"
    yield result(path, "colliders", "C-COLLIDER", level, findings, passed)
    passed = f"neighbours' masses differ by less than {bodies.RATIO:g} to 1"
    yield result(path, "mass ratio", "C-MASS-RATIO", "warning", bodies.neighbours(together), passed)


def _coded(
    document: "ModelDocument", bodies: "Sequence[WeighedBody]", together: "Sequence[Lump]"
) -> "Iterator[Check]":
    """The checks of what the text and the figures say, each of which may have several findings."""
    from linkwright.stages.validate.bare.findings import CHECKS
    from linkwright.stages.validate.files.run import result

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
    document: "ModelDocument", bodies: "Sequence[WeighedBody]", together: "Sequence[Lump]"
) -> "Iterable[Coded]":
    from linkwright.stages.validate.bare import mesh_units, mjcf_keys, mjcf_values, urdf_tree, urdf_values
    from linkwright.stages.validate.bare.bodies import weightless

    if document.language == "urdf":
        yield from urdf_tree.look(document)
        yield from urdf_values.look(document)
        yield from weightless(together)
    else:
        yield from mjcf_values.look(document)
        yield from mjcf_keys.look(document)
    yield from mesh_units.look(bodies)
