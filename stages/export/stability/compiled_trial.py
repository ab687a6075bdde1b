"""Runs a trial of an MJCF in memory."""

from collections.abc import Mapping

from linkwright.stages.mujoco.compile import NotCompiled, compiled_text
from linkwright.stages.mujoco.trial import MAX_OPENING, TRIAL_SECONDS, Trial, trial_run


def compiled_trial(mjcf: bytes, meshes: Mapping[str, bytes], margin: float) -> Trial | None:
    """Returns the trial run of a model; `meshes`: file name → content. Returns None if nothing moves, or if
    the model does not compile, which the validate stage reports. A `margin` above 1 multiplies the duration
    and divides the allowed opening of loops."""
    assets = {f"assets/{name}": data for name, data in meshes.items()}
    try:
        model = compiled_text(mjcf, assets)
    except NotCompiled:
        return None
    return trial_run(model, margin * TRIAL_SECONDS, MAX_OPENING / margin) if model.nv else None
