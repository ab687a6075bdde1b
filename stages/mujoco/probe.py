"""Shows that MuJoCo works: `python -m` compiles and moves a model, and prints the version of MuJoCo."""

import mujoco

_BALL = '<mujoco><worldbody><body><freejoint/><geom size="1"/></body></worldbody></mujoco>'

if __name__ == "__main__":
    model = mujoco.MjModel.from_xml_string(_BALL)
    mujoco.mj_step(model, mujoco.MjData(model))
    print(mujoco.__version__)
