"""The truth's Jacobians against differences of its poses."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.fake_onshape.mates import quaternion, rotation
from tests.fake_onshape.truth import shifted


def nearby(truth, values, column, by, root):
    """Values with one column of the Jacobian moved by `by`: a ball's, in the frame of what it moves."""
    forward = {step.edge.name: step.forward for _, steps in truth.tree.components(root) for step in steps}
    for dof in truth.dofs:
        place = truth.columns[dof.name]
        if place.start <= column < place.stop:
            step, value = by * np.eye(dof.width)[column - place.start], values[dof.name]
            if dof.kind == "ball" and not forward[dof.name]:
                moved = quaternion(Rotation.from_rotvec(-step).as_matrix() @ rotation(value))
            else:
                moved = shifted(value, step)
            return {**values, dof.name: moved}
    raise AssertionError


def differences_hold(truth, values, roots=(None,)):
    """Asserts that the Jacobians are the central differences of the poses, with each root held."""
    step = 1e-6
    for root in roots:
        poses, jacobians = truth.poses(values, root), truth.jacobians(values, root)
        for column in range(truth.width):
            ahead, behind = (truth.poses(nearby(truth, values, column, s, root), root) for s in (step, -step))
            for path in truth.leaves:
                _, com, _ = truth.places[path].instance.source.inertial()
                speed = ((ahead[path] - behind[path]) @ [*com, 1])[:3] / (2 * step)
                spin = (ahead[path] - behind[path])[:3, :3] @ poses[path][:3, :3].T / (2 * step)
                linear, angular = jacobians[path]
                assert linear[:, column] == pytest.approx(speed, abs=1e-8)
                turned = [spin[2, 1], spin[0, 2], spin[1, 0]]
                assert angular[:, column] == pytest.approx(turned, abs=1e-8)
