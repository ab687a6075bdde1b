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


def compare_masses(read_robot: ReadRobot) -> Iterator[Check]:
    """Yields a result for each quantity."""
    worst_values, worst_link = dict.fromkeys(UNITS, 0.0), dict.fromkeys(UNITS, "")
    findings: dict[str, list[tuple[float, Finding]]] = {quantity: [] for quantity in UNITS}
    tolerance, largest_allowance = read_robot.precision.mass, 0.0
    for link in read_robot.robot.links:
        actual = read_robot.mass_properties(link.name)
        expected = expected_mass_properties(link, read_robot.precision.massless_inertial)
        largest_entry = float(np.abs(expected.inertia).max())
        allowance = read_robot.axes_error(largest_entry) if largest_entry else 0.0
        largest_allowance = max(largest_allowance, allowance)
        for quantity, value in differences(actual, expected, allowance).items():
            if not value < worst_values[quantity]:
                worst_values[quantity], worst_link[quantity] = value, link.name
            if not value <= tolerance:
                element, names = read_robot.element("link", link.name), read_robot.attribute_names
                finding = _finding(element, quantity, actual, expected, names, tolerance)
                findings[quantity].append((value, finding))
    for name, value, finding in read_robot.unexpected_masses():
        if not value < worst_values["mass"]:
            worst_values["mass"], worst_link["mass"] = value, name
        if not value <= tolerance:
            findings["mass"].append((value, finding))
    for quantity, unit in UNITS.items():
        if quantity == "inertia" and largest_allowance > tolerance:
            unit += ", beyond the error of this MuJoCo's principal axes"
        detail = f"{quantity} of each link against CAD's parts ({unit}); worst: {worst_link[quantity]}"
        yield read_robot.within(
            quantity, worst_values[quantity], tolerance, detail, worst_first(findings[quantity])
        )


def _finding(
    element: str,
    quantity: str,
    actual: MassProperties,
    expected: MassProperties,
    words: AttributeNames,
    tolerance: float,
) -> Finding:
    if quantity == "mass":
        return differs(element, words.mass, actual.mass, expected.mass, "kg")
    if quantity == "centre of mass":
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
    if float(np.abs(moments[0] - moments[1]).max()) <= tolerance * float(np.abs(moments[1]).max()):
        return Finding(element, axes, "turns the principal axes of inertia differently than expected")
    return differs(element, size, moments[0], moments[1], "kg m², by size")
