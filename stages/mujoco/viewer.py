"""Opens MuJoCo's own viewer, with a scene at its keyframe `home`."""

from linkwright.stages.mujoco.state import at_keyframe


class NoViewer(Exception):
    """An error of an installed MuJoCo without a viewer."""


class NoWindow(Exception):
    """An error of a viewer that cannot open a window."""


def show(scene: str) -> None:
    """Opens the viewer with the scene of this path, and returns when it is closed. Raises NoViewer or
    NoWindow, with MuJoCo's message, if it cannot be opened."""
    try:
        # Late: it needs a window library, which may be missing.
        import mujoco.viewer
    except ImportError as error:
        raise NoViewer(str(error)) from None
    model = mujoco.MjModel.from_xml_path(scene)
    try:
        mujoco.viewer.launch(model, at_keyframe(model))
    except mujoco.FatalError as error:
        raise NoWindow(str(error)) from None
