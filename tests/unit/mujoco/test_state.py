"""A model's state at its keyframes."""

from linkwright.stages.mujoco.compile import compiled_text
from linkwright.stages.mujoco.state import at_keyframe, keyframe_of

TEXT = b"""<mujoco><worldbody><body><joint name="j"/><geom size="1"/></body></worldbody>
<actuator><position joint="j"/></actuator>
<keyframe><key name="up" qpos="1"/><key name="home" qpos="0.5" ctrl="0.25"/></keyframe></mujoco>"""


def test_the_state_is_that_of_the_keyframe_with_its_controls_and_else_qpos0() -> None:
    model = compiled_text(TEXT, {})
    assert [keyframe_of(model, name) for name in ("up", "home", "lost")] == [0, 1, -1]
    assert [at_keyframe(model, name).qpos[0] for name in ("up", "home", "lost")] == [1, 0.5, 0]
    assert at_keyframe(model).ctrl[0] == 0.25
