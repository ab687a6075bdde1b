"""Mechanisms of loops: each has all that moves its loops."""

import numpy as np
import pytest

from linkwright.stages.robot.model.robot import Relation, Robot
from linkwright.stages.robot.motion.closing import Closer
from linkwright.stages.robot.motion.loop_groups import LoopGroups
from tests.support.robots import joint, loop, robot_with


def gears(driver_above: bool) -> Robot:
    """A loop of `left` and `right`, of which `left` follows a joint that is above both, or beside them."""
    shoulder = joint("revolute", "base", "arm", name="shoulder")
    beside = joint("revolute", "base", "aside", name="beside")
    sides = [joint("revolute", "arm", name, name=f"to_{name}") for name in ("left", "right")]
    driver = "shoulder" if driver_above else "beside"
    relation = Relation("gear", "to_left", driver, 2.0, 0.0)
    return robot_with(
        [shoulder, beside, *sides],
        loops=[loop("revolute", "left", "right", np.eye(4), np.eye(4))],
        relations=[relation],
        root="base",
    )


@pytest.mark.parametrize("driver_above", [True, False])
def test_a_driver_is_in_the_mechanism_wherever_it_is(driver_above: bool) -> None:
    (mechanism,) = LoopGroups(gears(driver_above)).mechanisms()
    dofs = {dof.name for one in mechanism.joints for dof in one.dofs}
    assert {name for one in mechanism.relations for name in (one.driver, one.follower)} <= dofs
    moved = {"shoulder" if driver_above else "beside", "to_right"}
    assert moved <= set(Closer(mechanism).names)
