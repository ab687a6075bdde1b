"""MuJoCo's own viewer, with a scene at its keyframe `home`."""

from linkwright.stages.mujoco.state import at_keyframe


class NoViewer(Exception):
    """The installed MuJoCo has no viewer."""


class NoWindow(Exception):
    """The viewer cannot open a window."""


def show(scene: str) -> None:
    """Opens the viewer with a scene, and returns when it is closed. NoViewer or NoWindow where it cannot be
    opened, with MuJoCo's words."""
    try:
        # Late: it needs a library of windows, which may not be there.
        import mujoco.viewer
    except ImportError as error:
        raise NoViewer(str(error)) from None
    model = mujoco.MjModel.from_xml_path(scene)
    try:
        mujoco.viewer.launch(model, at_keyframe(model))
    except mujoco.FatalError as error:
        raise NoWindow(str(error)) from None
