"""Computes the arrays of variants: random values for fields of a compiled model."""

from typing import Any

import numpy as np
import numpy.typing as npt

from linkwright.stages.export.variants.draws import Column, draws
from linkwright.stages.export.variants.inertials import moved_inertials, radii, stretched_moments
from linkwright.stages.export.variants.quantities import VariedQuantity
from linkwright.stages.formats.numbers import TURN, numbers

Floats = npt.NDArray[np.float64]

ROUNDING_STEPS = {"body_iquat": TURN}
"""Field → the rounding step of its numbers; the others are rounded by their own scale."""

OF_BODIES = ("body_mass", "body_ipos", "body_inertia", "body_iquat")


class VariedFields:
    """The fields that vary, and their arrays."""

    def __init__(self, model: Any, seed: int, n: int) -> None:
        self._model = model
        self._seed = seed
        self._n = n
        self._rows: dict[tuple[str, int], list[Column]] = {}
        """(field, row) → the columns of its varied numbers."""
        self._bodies: dict[int, dict[str, list[Column]]] = {}
        """Body → mass property → its draws times its share."""
        self.fixed_centres: list[str] = []
        """Names of the bodies whose centre of mass should vary and cannot."""

    def vary(self, quantity: VariedQuantity, share: float) -> bool:
        """Varies a quantity by `share` to both sides; returns False if it is 0, which no factor changes."""
        if quantity.bodies:
            return self._vary_bodies(quantity, share)
        entries = [(field, place) for field, place in quantity.entries if getattr(self._model, field)[place]]
        if not entries:
            return False
        factor = 1.0 + share * self._draws(quantity.key, 1)[0]
        for field, (row, *column) in entries:
            columns = self._row(field, row)
            number = column[0] if column else 0
            columns[number] = columns[number] * factor
        return True

    def arrays(self) -> dict[str, Floats]:
        """Returns the values (n, ...) of each field that varies."""
        for body, drawn in self._bodies.items():
            self._set_body(body, drawn)
        arrays_by_field: dict[str, Floats] = {}
        for field, row in self._rows:
            if field not in arrays_by_field:
                nominal = _rounded_all(field, np.asarray(getattr(self._model, field), float))
                arrays_by_field[field] = np.repeat(nominal[None], self._n, axis=0)
            values = _rounded(np.column_stack(self._rows[field, row]), ROUNDING_STEPS.get(field, 0.0))
            arrays_by_field[field][:, row] = values.reshape(arrays_by_field[field][:, row].shape)
        return {field: arrays_by_field[field] for field in sorted(arrays_by_field)}

    def _draws(self, key: str, count: int) -> list[Column]:
        return draws(self._seed, key, self._n, count)

    def _row(self, field: str, row: int) -> list[Column]:
        if (field, row) not in self._rows:
            values = _nominal(self._model, field, row)
            self._rows[field, row] = [np.full(self._n, value) for value in values]
        return self._rows[field, row]

    def _vary_bodies(self, quantity: VariedQuantity, share: float) -> bool:
        if quantity.name == "com" and self._model.body_simple[quantity.bodies[0]]:
            self.fixed_centres.append(self._model.body(quantity.bodies[0]).name)
            return False
        count = {"mass": 1, "com": 3, "inertia": 6}[quantity.name]
        columns = [share * column for column in self._draws(quantity.key, count)]
        for body in quantity.bodies:
            self._bodies.setdefault(body, {})[quantity.name] = columns
        return True

    def _set_body(self, body: int, drawn: dict[str, list[Column]]) -> None:
        """Sets the rows of MuJoCo's fields of a body's mass properties."""
        model, zeros = self._model, np.zeros(self._n)
        (mass,), com = _nominal(model, "body_mass", body), _nominal(model, "body_ipos", body)
        moments, quat = _nominal(model, "body_inertia", body), _nominal(model, "body_iquat", body)
        factor = 1.0 + drawn.get("mass", [zeros])[0]
        if drawn.keys() == {"mass"}:
            self._rows["body_mass", body] = [mass * factor]
            self._rows["body_inertia", body] = [moment * factor for moment in moments]
            return
        t, s = drawn.get("com", [zeros] * 3), drawn.get("inertia", [zeros] * 6)
        transform = [
            [1.0 + s[0], zeros, zeros],
            [s[3], 1.0 + s[1], zeros],
            [s[4], s[5], 1.0 + s[2]],
        ]
        spread = radii(moments, quat, mass)
        if model.body_simple[body]:
            self._rows["body_mass", body] = [mass * factor]
            self._rows["body_inertia", body] = stretched_moments(mass * factor, spread, s)
            return
        solid = moved_inertials(mass * factor, com, spread, t, transform)
        parts = ([solid.mass], solid.com, solid.moments, solid.quat)
        for field, columns in zip(OF_BODIES, parts, strict=True):
            self._rows[field, body] = columns


def _nominal(model: Any, field: str, row: int) -> list[float]:
    """Returns the numbers of the model as the file has them, since compilers differ in the last bits."""
    values = np.atleast_1d(np.asarray(getattr(model, field)[row], float))
    return [*map(float, numbers(values, least=ROUNDING_STEPS.get(field, 0.0)))]


def _rounded(rows: Floats, step: float) -> Floats:
    return np.array([[*map(float, numbers(row, least=step))] for row in rows.tolist()])


def _rounded_all(field: str, values: Floats) -> Floats:
    rows = values.reshape(len(values), -1)
    return _rounded(rows, ROUNDING_STEPS.get(field, 0.0)).reshape(values.shape)
