"""Compares the mass, centre of mass and inertia of each link with those of its parts in CAD.

The expected values are summed over the parts, by second moments, instead of taken from the links that
the files were written from. A link with an inertial from the user must have that inertial.
"""

from collections.abc import Iterator

import numpy as np

from linkwright.stages.robot.check import Check, Finding
from linkwright.stages.validate.findings import differs, worst_first
from linkwright.stages.validate.model.mass_properties import (
    UNITS,
    MassProperties,
    differences,
    expected_mass_properties,
)
from linkwright.stages.validate.same.read_robot import AttributeNames, ReadRobot


def compare_masses(read: ReadRobot) -> Iterator[Check]:
    """Yields a result for each quantity."""
    worst, worst_link = dict.fromkeys(UNITS, 0.0), dict.fromkeys(UNITS, "")
    findings: dict[str, list[tuple[float, Finding]]] = {key: [] for key in UNITS}
    exact, error = read.precision.mass, 0.0
    for link in read.robot.links:
        actual, expected = (
            read.mass_properties(link.name),
            expected_mass_properties(link, read.precision.massless_inertial),
        )
        largest = float(np.abs(expected.inertia).max())
        allowed = read.axes_error(largest) if largest else 0.0
        error = max(error, allowed)
        for key, value in differences(actual, expected, allowed).items():
            if not value < worst[key]:
                worst[key], worst_link[key] = value, link.name
            if not value <= exact:
                element = read.element("link", link.name)
                findings[key].append(
                    (value, _finding(element, key, actual, expected, read.attribute_names, exact))
                )
    for name, value, finding in read.unexpected_masses():
        if not value < worst["mass"]:
            worst["mass"], worst_link["mass"] = value, name
        if not value <= exact:
            findings["mass"].append((value, finding))
    for key, unit in UNITS.items():
        if key == "inertia" and error > exact:
            unit += ", beyond the error of this MuJoCo's principal axes"
        detail = f"{key} of each link against CAD's parts ({unit}); worst: {worst_link[key]}"
        yield read.within(key, worst[key], exact, detail, worst_first(findings[key]))


def _finding(
    element: str,
    key: str,
    actual: MassProperties,
    expected: MassProperties,
    words: AttributeNames,
    exact: float,
) -> Finding:
    if key == "mass":
        return differs(element, words.mass, actual.mass, expected.mass, "kg")
    if key == "centre of mass":
        return differs(element, words.com, actual.com, expected.com, "m")
    if words.moments is None:
        rows, columns = np.triu_indices(3)
        pairs = [body.inertia[rows, columns] for body in (actual, expected)]
        worst_entry = int(np.abs(pairs[0] - pairs[1]).argmax())
        name = "xyz"[rows[worst_entry]] + "xyz"[columns[worst_entry]]
        return differs(
            element, f"{words.inertia}{name}", pairs[0][worst_entry], pairs[1][worst_entry], "kg m²"
        )
    size, axes = words.moments
    # NaN has no eigenvalues.
    if not np.isfinite(actual.inertia).all():
        return Finding(element, size, "is not a finite number")
    moments = [np.linalg.eigvalsh(tensor) for tensor in (actual.inertia, expected.inertia)]
    if float(np.abs(moments[0] - moments[1]).max()) <= exact * float(np.abs(moments[1]).max()):
        return Finding(element, axes, "turns the principal axes of inertia differently than expected")
    return differs(element, size, moments[0], moments[1], "kg m², by size")
