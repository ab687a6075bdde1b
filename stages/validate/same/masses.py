"""Mass, centre of mass and inertia of each link are those of its parts in CAD.

The expected values are summed independently over the parts, by second moments, not taken from the links
that the files were written from. A link whose inertial the user gave must have that.
"""

from collections.abc import Iterator

import numpy as np

from linkwright.stages.robot.check import Check, Finding
from linkwright.stages.validate.findings import differs, worst_first
from linkwright.stages.validate.model.lumps import UNITS, Lump, differences, expected_lump
from linkwright.stages.validate.same.found import FormatWords, ReadRobot


def masses(read: ReadRobot) -> Iterator[Check]:
    """A result for each quantity."""
    worst, where = dict.fromkeys(UNITS, 0.0), dict.fromkeys(UNITS, "")
    findings: dict[str, list[tuple[float, Finding]]] = {key: [] for key in UNITS}
    exact, error = read.precision.mass, 0.0
    for link in read.robot.links:
        found, expected = read.lump(link.name), expected_lump(link, read.precision.least)
        largest = float(np.abs(expected[2]).max())
        allowed = read.axes_error(largest) if largest else 0.0
        error = max(error, allowed)
        for key, value in differences(found, expected, allowed).items():
            if not value < worst[key]:
                worst[key], where[key] = value, link.name
            if not value <= exact:
                element = read.element("link", link.name)
                findings[key].append((value, _finding(element, key, found, expected, read.words, exact)))
    for name, value, finding in read.odd_masses():
        if not value < worst["mass"]:
            worst["mass"], where["mass"] = value, name
        if not value <= exact:
            findings["mass"].append((value, finding))
    for key, unit in UNITS.items():
        if key == "inertia" and error > exact:
            unit += ", beyond the error of this MuJoCo's principal axes"
        detail = f"{key} of each link against CAD's parts ({unit}); worst: {where[key]}"
        yield read.within(key, worst[key], exact, detail, worst_first(findings[key]))


def _finding(
    element: str, key: str, found: Lump, expected: Lump, words: FormatWords, exact: float
) -> Finding:
    if key == "mass":
        return differs(element, words.mass, found[0], expected[0], "kg")
    if key == "centre of mass":
        return differs(element, words.com, found[1], expected[1], "m")
    if words.moments is None:
        rows, columns = np.triu_indices(3)
        pairs = [one[2][rows, columns] for one in (found, expected)]
        most = int(np.abs(pairs[0] - pairs[1]).argmax())
        name = "xyz"[rows[most]] + "xyz"[columns[most]]
        return differs(element, f"{words.inertia}{name}", pairs[0][most], pairs[1][most], "kg m²")
    moments = [np.linalg.eigvalsh(tensor) for tensor in (found[2], expected[2])]
    size, axes = words.moments
    if float(np.abs(moments[0] - moments[1]).max()) <= exact * float(np.abs(moments[1]).max()):
        return Finding(element, axes, "turns the principal axes of inertia otherwise than expected")
    return differs(element, size, moments[0], moments[1], "kg m², by size")
