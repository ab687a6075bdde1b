"""A trial run of an MJCF in memory."""

from collections.abc import Mapping

from linkwright.stages.mujoco.compile import NotCompiled, compiled_text
from linkwright.stages.mujoco.trial import OPEN, SECONDS, Trial, trial_run


def compiled_trial(mjcf: bytes, meshes: Mapping[str, bytes], margin: float) -> Trial | None:
    """The trial run of a model whose meshes are `meshes`, by file name; None where it does not compile, which
    the validate stage reports. With a `margin` above 1 it takes so much longer, and loops may open so much
    less."""
    assets = {f"assets/{name}": data for name, data in meshes.items()}
    try:
        model = compiled_text(mjcf, assets)
    except NotCompiled:
        return None
    return trial_run(model, margin * SECONDS, OPEN / margin) if model.nv else None
