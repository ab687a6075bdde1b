"""Checks that the variants of the MJCF fit the robot and are physically possible, and simulates a sample.

The sample must stay stable and finite, and rest at `home` if the robot does.
"""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from linkwright.stages.formats.npz import NotNpz
from linkwright.stages.formats.variants import Variants, digest_of
from linkwright.stages.mujoco.trial import MAX_OPENING, trial_run
from linkwright.stages.mujoco.variants import misfit, variant
from linkwright.stages.robot.check import Check
from linkwright.stages.robot.text.file_names import VARIANTS as FILE
from linkwright.stages.robot.text.globs import name_list
from linkwright.stages.validate.checks.simulation.rest import largest_motions
from linkwright.stages.validate.compiled import CompiledModel

SAMPLE_SIZE = 4
"""Number of simulated variants, spread evenly over all."""

SMALLER_SHARE_HINT = "; a smaller share in variants.ranges keeps them closer to the robot"

MAX_BYTES = 1 << 31
"""Largest size [bytes] of a file that is read."""

TRIANGLE_TOLERANCE = 1e-9
"""Relative tolerance of the triangle inequality of moments of inertia: the file has 12 digits."""

NON_NEGATIVE_FIELDS = ("damping", "armature", "frictionloss", "friction", "stiffness")
"""Endings of the fields whose values are at least 0."""


def check(compiled: CompiledModel) -> Iterator[Check]:
    """Checks the file of variants, if there is one."""
    path = compiled.path.parent / FILE
    if not path.is_file() or not compiled.model.nv:
        return
    variants, wrong = _read(compiled)
    wrong = wrong or (_impossible_value_text(compiled, variants) if variants is not None else "")
    passed = (
        ""
        if variants is None
        else f"{variants.n} of this model, each with masses and inertias that solids have"
    )
    yield compiled.result("variants", not wrong, wrong or passed)
    if variants is not None and variants.n and not wrong:
        yield from _simulation_checks(compiled, variants)


def _read(compiled: CompiledModel) -> tuple[Variants | None, str]:
    """Returns the variants, or None with the text of the error."""
    path = compiled.path.parent / FILE
    mjcf = path.with_name(f"{compiled.written.robot.name}.xml")
    if path.stat().st_size > MAX_BYTES:
        return None, f"{FILE} is too large to be read"
    try:
        variants = Variants.from_bytes(path.read_bytes())
    except NotNpz as error:
        return None, f"{FILE} cannot be read: {error}"
    mismatch = misfit(compiled.model, variants)
    if mismatch:
        return None, f"{FILE} belongs to another model, as its {mismatch} shows; build again"
    if not mjcf.is_file() or digest_of(mjcf.read_bytes().replace(b"\r\n", b"\n")) != variants.mjcf:
        return None, f"{mjcf.name} is not the file that {FILE} was made for; build again"
    return variants, ""


def _impossible_value_text(compiled: CompiledModel, variants: Variants) -> str:
    """Returns a text on the first value that no robot can have; "" without such a value."""
    for field, values in variants.fields.items():
        if len(values) != variants.n or not np.isfinite(values).all():
            return f"{FILE}: {field} is not finite, or of another number of variants"
        if field.endswith(NON_NEGATIVE_FIELDS) and (values < 0).any():
            return f"{FILE}: {field} is below 0"
    mass, inertia = variants.fields.get("body_mass"), variants.fields.get("body_inertia")
    if mass is not None:
        has_mass = compiled.model.body_mass[: mass.shape[1]] > 0
        if ((mass > 0) != has_mass).any():
            return f"{FILE}: body_mass is not above 0"
    if inertia is not None:
        total = inertia.sum(axis=2)
        if (inertia < 0).any() or (2 * inertia.max(axis=2) > total * (1 + TRIANGLE_TOLERANCE)).any():
            return f"{FILE}: body_inertia is impossible for a solid"
    return ""


def _simulation_checks(compiled: CompiledModel, variants: Variants) -> Iterator[Check]:
    numbers = sorted({round(k * (variants.n - 1) / max(1, SAMPLE_SIZE - 1)) for k in range(SAMPLE_SIZE)})
    rests = _rests(compiled)
    failed, moving, largest_opening = [], [], 0.0
    for number in numbers:
        varied = replace(compiled, model=variant(compiled.model, variants, number))
        trial = trial_run(varied.model)
        largest_opening = max(largest_opening, trial.opening)
        if trial.failed:
            failed.append(f"variant {number}: after {trial.time:.3g} s {trial.failed}")
        elif rests and not _rests(varied):
            moving.append(str(number))
    passed = f"variants {', '.join(map(str, numbers))} simulated from home without a warning"
    text = "; ".join(failed) + SMALLER_SHARE_HINT if failed else passed
    yield compiled.result("variants run", not failed, text, largest_opening, MAX_OPENING)
    if rests:
        text = "they rest at home as the robot does"
        text += f", except {name_list(moving)}{SMALLER_SHARE_HINT}" if moving else ""
        yield compiled.result("variants rest", not moving, text, float(len(moving)), 0.0, level="warning")


def _rests(compiled: CompiledModel) -> bool:
    motions = largest_motions(compiled) or []
    return bool(motions) and motions[0][0] <= 1.0
