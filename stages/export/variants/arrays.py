"""Computes the arrays of variants: random values for fields of a compiled model."""

from typing import Any

import numpy as np
import numpy.typing as npt

from linkwright.stages.export.variants.draws import Column, draws
from linkwright.stages.export.variants.inertials import moved_inertials, spread_factor, stretched_moments
from linkwright.stages.export.variants.quantities import VariedQuantity
from linkwright.stages.formats.numbers import TURN, numbers

Floats = npt.NDArray[np.float64]

ROUNDING_SCALES = {"body_iquat": TURN}
"""Field → the scale by which its numbers are rounded; other fields are rounded by the scale of each row."""

MASS_FIELDS = ("body_mass", "body_ipos", "body_inertia", "body_iquat")
"""The fields of a body's mass, centre of mass, principal moments and principal axes."""


class VariedFields:
    """The fields that vary, and their arrays."""

    def __init__(self, model: Any, seed: int, n: int) -> None:
        self._model = model
        self._seed = seed
        self._n = n
        self._rows: dict[tuple[str, int], list[Column]] = {}
        """(field, row) → the columns of its varied numbers."""
        self._bodies: dict[int, dict[str, list[Column]]] = {}
        """Body → mass property → the columns of its draws, times its share."""
        self.fixed_centres: list[str] = []
        """Names of the bodies whose centre of mass should vary and cannot."""

    def vary(self, quantity: VariedQuantity, share: float) -> bool:
        """Varies a quantity by `share` to both sides. Returns False if it cannot vary: it is 0, which no
        factor changes, or a centre of mass that MuJoCo keeps fixed."""
        if quantity.bodies:
            return self._vary_bodies(quantity, share)
        entries = [(field, index) for field, index in quantity.entries if getattr(self._model, field)[index]]
        if not entries:
            return False
        factor = 1.0 + share * self._draws(quantity.key, 1)[0]
        for field, (row, *further_indices) in entries:
            columns = self._columns(field, row)
            # A field with a single number in each row has no further index.
            number = further_indices[0] if further_indices else 0
            columns[number] = columns[number] * factor
        return True

    def arrays(self) -> dict[str, Floats]:
        """Returns the values (n, ...) of each field that varies, by name. Rows that do not vary keep the
        values of the file."""
        for body, draws_by_property in self._bodies.items():
            self._set_mass_properties(body, draws_by_property)
        arrays_by_field: dict[str, Floats] = {}
        for field, row in self._rows:
            if field not in arrays_by_field:
                nominal = _rounded_field(field, np.asarray(getattr(self._model, field), float))
                arrays_by_field[field] = np.repeat(nominal[None], self._n, axis=0)
            values = _rounded(np.column_stack(self._rows[field, row]), ROUNDING_SCALES.get(field, 0.0))
            arrays_by_field[field][:, row] = values.reshape(arrays_by_field[field][:, row].shape)
        return {field: arrays_by_field[field] for field in sorted(arrays_by_field)}

    def _draws(self, key: str, count: int) -> list[Column]:
        return draws(self._seed, key, self._n, count)

    def _columns(self, field: str, row: int) -> list[Column]:
        """Returns the columns of a row's numbers, which start from the values of the file."""
        if (field, row) not in self._rows:
            values = _nominal(self._model, field, row)
            self._rows[field, row] = [np.full(self._n, value) for value in values]
        return self._rows[field, row]

    def _vary_bodies(self, quantity: VariedQuantity, share: float) -> bool:
        """Keeps the draws of a mass property, since all properties of a body are set together. Returns False
        if it cannot vary."""
        if quantity.name == "com" and self._model.body_simple[quantity.bodies[0]]:
            self.fixed_centres.append(self._model.body(quantity.bodies[0]).name)
            return False
        count = {"mass": 1, "com": 3, "inertia": 6}[quantity.name]
        columns = [share * column for column in self._draws(quantity.key, count)]
        for body in quantity.bodies:
            self._bodies.setdefault(body, {})[quantity.name] = columns
        return True

    def _set_mass_properties(self, body: int, draws_by_property: dict[str, list[Column]]) -> None:
        """Sets a body's rows of `MASS_FIELDS`."""
        model, zeros = self._model, np.zeros(self._n)
        (mass,), com = _nominal(model, "body_mass", body), _nominal(model, "body_ipos", body)
        moments, quat = _nominal(model, "body_inertia", body), _nominal(model, "body_iquat", body)
        factor = 1.0 + draws_by_property.get("mass", [zeros])[0]
        if draws_by_property.keys() == {"mass"}:
            self._rows["body_mass", body] = [mass * factor]
            self._rows["body_inertia", body] = [moment * factor for moment in moments]
            return
        shift = draws_by_property.get("com", [zeros] * 3)
        # Three shares by which the body is stretched, and three by which it is sheared.
        shares = draws_by_property.get("inertia", [zeros] * 6)
        transform = [
            [1.0 + shares[0], zeros, zeros],
            [shares[3], 1.0 + shares[1], zeros],
            [shares[4], shares[5], 1.0 + shares[2]],
        ]
        spread = spread_factor(moments, quat, mass)
        # MuJoCo computes a simple body as if its centre of mass and principal axes were those of its frame.
        if model.body_simple[body]:
            self._rows["body_mass", body] = [mass * factor]
            self._rows["body_inertia", body] = stretched_moments(mass * factor, spread, shares)
            return
        inertials = moved_inertials(mass * factor, com, spread, shift, transform)
        properties = ([inertials.mass], inertials.com, inertials.moments, inertials.quat)
        for field, columns in zip(MASS_FIELDS, properties, strict=True):
            self._rows[field, body] = columns


def _nominal(model: Any, field: str, row: int) -> list[float]:
    """Returns the numbers of a field's row, rounded to the digits that files have, since compiled models
    differ in the last bits between machines."""
    values = np.atleast_1d(np.asarray(getattr(model, field)[row], float))
    return [*map(float, numbers(values, least=ROUNDING_SCALES.get(field, 0.0)))]


def _rounded(rows: Floats, scale: float) -> Floats:
    """Returns each row (n, k), rounded to the digits that files have. `scale`: as `least` of `numbers`."""
    return np.array([[*map(float, numbers(row, least=scale))] for row in rows.tolist()])


def _rounded_field(field: str, values: Floats) -> Floats:
    """Returns the values of a whole field, rounded by row."""
    rows = values.reshape(len(values), -1)
    return _rounded(rows, ROUNDING_SCALES.get(field, 0.0)).reshape(values.shape)
