"""Random documents with closed loops, as built, stay whole and finite for two seconds."""

import mujoco
import numpy as np
import pytest
from hypothesis import assume
from hypothesis import strategies as st

from linkwright.stages.export import export
from tests.fake_onshape.document import Document
from tests.support.building import NO_MESHES, plan_of, robot_of
from tests.support.drawn import any_document, each

SECONDS, OPEN = 2.0, 1e-3


def holds(document: Document, timestep: float):
    """As built, without actuators: no warning, no NaN, no two sites of a loop apart."""
    plan = plan_of(scene={"option": {"timestep": timestep}})
    robot = robot_of(document, plan)
    assume(robot.loops)
    text = export(robot, NO_MESHES, plan).files["robot.xml"].decode()
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    if model.nkey:
        mujoco.mj_resetDataKeyframe(model, data, model.key("home").id)
    closing = model.eq_type != mujoco.mjtEq.mjEQ_JOINT
    first, second = model.eq_obj1id[closing], model.eq_obj2id[closing]
    for _ in range(round(SECONDS / timestep)):
        mujoco.mj_step1(model, data)
        apart = np.linalg.norm(data.site_xpos[first] - data.site_xpos[second], axis=1)
        assert apart.max(initial=0.0) <= OPEN
        mujoco.mj_step2(model, data)
        assert not data.warning.number.any()
    assert np.isfinite(data.qpos).all()


@pytest.mark.parametrize(
    ("everything", "timesteps", "count"),
    [(False, [0.002, 0.005], 6), pytest.param(None, [0.001, 0.002, 0.005], 40, marks=pytest.mark.slow)],
)
def test_looped_documents_hold(everything, timesteps, count):
    each(holds, count, any_document(everything, True), st.sampled_from(timesteps))
