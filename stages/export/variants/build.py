"""Makes `variants.npz`: random variants of the finished MJCF within the configured ranges."""

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from linkwright.stages.export.variants.arrays import VariedFields
from linkwright.stages.export.variants.quantities import quantities
from linkwright.stages.export.variants.shares import SHARE_BY_ORIGIN, shares_of
from linkwright.stages.export.variants.variant_files import NO_VARIANTS, VariantFiles
from linkwright.stages.formats.robot_json.files import VariantsRecord, VariedQuantityRecord
from linkwright.stages.formats.variants import Variants, digest_of
from linkwright.stages.formats.written import Written
from linkwright.stages.mujoco.compile import NotCompiled, compiled_text
from linkwright.stages.mujoco.variants import names_in, places
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.errors import Diagnostic
from linkwright.stages.robot.text.file_names import VARIANTS
from linkwright.stages.robot.text.globs import name_list

if TYPE_CHECKING:
    from linkwright.stages.export.section import ExportSections

NO_MJCF_HINT = "choose mjcf in `export`, or remove `variants`"


def make_variants(written: Written, sections: "ExportSections", files: Mapping[str, bytes]) -> VariantFiles:
    """Makes the variants that the configuration requests. `files`: the robot's files, by path.

    If it requests none, the result holds only idle keys (I-IDLE-KEY); without an MJCF, only a warning
    (W-VARIANTS). If MuJoCo cannot compile the MJCF, the result is empty, and the validate stage reports the
    error. Raises AssemblyError (E-GLOB) for a glob that matches no quantity.
    """
    request = sections.variants
    if not request.n:
        return replace(NO_VARIANTS, diagnostics=_idle_keys(sections))
    if not sections.has_variants:
        text = "no variants are made: they need the MJCF, which is not exported"
        return replace(NO_VARIANTS, diagnostics=(Diagnostic("W-VARIANTS", text, "variants", NO_MJCF_HINT),))
    mjcf = files[f"{written.robot.name}.xml"]
    try:
        model = compiled_text(
            mjcf, {path: data for path, data in files.items() if path.startswith("assets/")}
        )
    except NotCompiled:
        return NO_VARIANTS
    log = Diagnostics(optional=sections.optional)
    known_quantities = quantities(model, written)
    shares = shares_of({quantity.key: quantity.origin for quantity in known_quantities}, request.ranges, log)
    log.raise_errors()
    fields = VariedFields(model, request.seed, request.n)
    varied_quantities = [
        quantity
        for quantity in known_quantities
        if shares.get(quantity.key) and fields.vary(quantity, shares[quantity.key])
    ]
    variants = Variants(
        request.seed, digest_of(mjcf), names_in(model), model.geom_bodyid, places(model), fields.arrays()
    )
    quantity_records = tuple(
        VariedQuantityRecord(quantity.key, quantity.origin, shares[quantity.key])
        for quantity in varied_quantities
    )
    record = VariantsRecord(VARIANTS, request.n, request.seed, tuple(variants.fields), quantity_records)
    diagnostics = (*log.notes, *_fixed_centres(fields))
    return VariantFiles({VARIANTS: variants.to_bytes()}, {"variants": record}, diagnostics, _summary(record))


def _idle_keys(sections: "ExportSections") -> tuple[Diagnostic, ...]:
    """Reports each key of `variants` that is set although no variant is made (I-IDLE-KEY)."""
    default = type(sections.variants)()
    text = "variants.n is 0, so there are no variants, and this key has no effect"
    hint = "remove it, or set variants.n"
    return tuple(
        Diagnostic("I-IDLE-KEY", text, f"variants.{key}", hint)
        for key in ("seed", "ranges")
        if getattr(sections.variants, key) != getattr(default, key)
    )


def _fixed_centres(fields: VariedFields) -> list[Diagnostic]:
    """Reports the bodies whose centre of mass should vary and cannot (I-VARIANTS)."""
    if not fields.fixed_centres:
        return []
    text = (
        "MuJoCo assumes that the centre of mass of these bodies is the origin of their frames, so their "
        f"centres of mass and axes of inertia do not vary: {name_list(fields.fixed_centres)}"
    )
    return [Diagnostic("I-VARIANTS", text, "variants")]


def _summary(record: VariantsRecord) -> dict[str, Any]:
    """Returns the variants' entry in the report: the varied quantities, by origin and share."""
    groups: dict[tuple[str, float], list[str]] = {}
    for varied in record.varied:
        groups.setdefault((varied.origin, varied.share), []).append(varied.quantity)
    origins = list(SHARE_BY_ORIGIN)
    order = sorted(
        groups, key=lambda origin_and_share: (origins.index(origin_and_share[0]), origin_and_share[1])
    )
    rows = [{"origin": origin, "share": share, "of": groups[origin, share]} for origin, share in order]
    return {"n": record.n, "seed": record.seed, "fields": list(record.fields), "rows": rows}
