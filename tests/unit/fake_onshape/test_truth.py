"""The documents' own kinematics and dynamics: right by closed forms, differences and definition."""

import numpy as np
import pytest

from tests.fake_onshape import solids
from tests.fake_onshape.document import Document
from tests.fake_onshape.frames import frame


def pendulum(length=0.4, value=0.3):
    """A rod that hangs on a post and turns about the world's y; at 0 it points along x."""
    document = Document("Pendulum")
    studio = document.studio("Parts")
    post = studio.part("Post", solids.box(0.1, 0.1, 0.1), 1000)
    rod = studio.part("Rod", solids.box(length, 0.02, 0.02, at=(length / 2, 0, 0)), 2000)
    assembly = document.assembly("Pendulum")
    base, arm = assembly.add(post, fixed=True), assembly.add(rod)
    across = frame(x=(1, 0, 0), z=(0, 1, 0))
    assembly.revolute("Swing", (arm, across), (base, across), value)
    return document


def test_a_pendulum_has_the_closed_form_mass_matrix_and_gravity_torque():
    truth = pendulum(0.4).truth
    mass = 2000 * 0.4 * 0.02 * 0.02
    for value in (-1.0, 0.0, 0.7):
        # About the end: m(l²/3 + h²/12); +y turns x towards −z, so gravity helps at q > −90°.
        assert truth.mass_matrix({"Swing": value})[0, 0] == pytest.approx(mass * (0.4**2 / 3 + 0.02**2 / 12))
        torque = truth.gravity_torque({"Swing": value})
        assert torque[0] == pytest.approx(-mass * 9.81 * 0.2 * np.cos(value))


def test_a_slider_carries_its_whole_mass_and_weight():
    document = Document("Lift")
    studio = document.studio("Parts")
    block = studio.part("Block", solids.box(0.1, 0.1, 0.1), 1000)
    assembly = document.assembly("Lift")
    base, cabin = assembly.add(block, fixed=True), assembly.add(block)
    assembly.slider("Lift", (base, frame()), (cabin, frame()), 0.2)
    truth = document.truth
    # The first entity stands still here, so a positive value lowers the cabin.
    assert truth.poses()[cabin.path][2, 3] == pytest.approx(-0.2)
    assert truth.mass_matrix()[0, 0] == pytest.approx(1.0)
    assert truth.gravity_torque()[0] == pytest.approx(-9.81)


def test_a_loop_must_be_declared():
    document = pendulum()
    (arm, _), (base, _) = document.root.features[0].entities
    document.root.revolute("Again", (arm, frame()), (base, frame()))
    with pytest.raises(ValueError, match="'Again' closes a loop"):
        _ = document.truth
