"""Ends are fitted in two processes as in one, whatever becomes of the second process."""

from typing import Any

import numpy as np
import pytest
import trimesh

from linkwright.stages.formats.meshes.surface import Surface, weld
from linkwright.stages.mesh.by_contact import fitting
from linkwright.stages.mesh.by_contact.fitting import EndFitter, EndToFit, FittedEnd, end_fitter
from linkwright.stages.mesh.configuration.collider_settings import ContactSettings
from linkwright.stages.mesh.cut.piece import hulled
from linkwright.stages.mesh.fit import fittest
from linkwright.stages.mesh.surfaces.pieces import surface_of
from linkwright.stages.robot.system.guest import Bounds

SETTINGS = ContactSettings(max_vertices=32)


def welded(mesh: trimesh.Trimesh) -> Surface:
    surface, _ = weld(np.asarray(mesh.vertices, dtype=float), np.asarray(mesh.faces, dtype=np.int64))
    return surface


def end(*sizes: float) -> EndToFit:
    """A fork with two tines."""
    x, y, z = sizes
    boxes = [((0, 0, 0), (x, y, 0.01)), ((0, 0, 0), (0.01, y, z)), ((x - 0.01, 0, 0), (x, y, z))]
    fork = welded(trimesh.boolean.union([trimesh.creation.box(bounds=box) for box in boxes]))
    whole = hulled(fork, SETTINGS.max_vertices, 0)
    assert whole is not None
    return EndToFit(fork, ((whole,),), SETTINGS)


ENDS = [end(0.08, 0.02, 0.05), end(0.05, 0.03, 0.09), end(0.06, 0.02, 0.06)]


def asked(fitter: EndFitter, one: EndToFit) -> FittedEnd:
    """Fitted by the second process, of which one thread asks at a time."""
    return fitter._pool.submit(fitter._asked, one).result()


def plain(fitted: list[FittedEnd]) -> list[Any]:
    def of(surface: Surface) -> tuple[bytes, bytes]:
        return surface.vertices.tobytes(), surface.triangles.tobytes()

    return [
        ([(of(chunk.surface), of(surface_of(chunk.piece)), chunk.group, chunk.volume) for chunk in made], fit)
        for made, fit in (([*chunks], repr(fit)) for chunks, fit in fitted)
    ]


@pytest.fixture(scope="module")
def alone() -> list[FittedEnd]:
    return [one.fitted() for one in ENDS]


def test_two_processes_give_what_one_gives(alone: list[FittedEnd], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(EndToFit, "fitted", lambda one: pytest.fail("not by this process"))
    with end_fitter(2) as fitter:
        asking = [asked(fitter, one) for one in ENDS]
    assert plain(asking) == plain(alone)
    assert all(len(made) == 3 for made, _ in alone)
    monkeypatch.undo()
    with end_fitter(2) as fitter:
        assert plain(fitter.fitted(ENDS)) == plain(alone)


def test_an_end_that_needs_no_cut_keeps_its_pieces() -> None:
    """The very same object, by which its depths in other links are known."""
    block = hulled(welded(trimesh.creation.box((0.04, 0.05, 0.06))), 32, 0)
    assert block is not None
    with end_fitter(2) as fitter:
        made, _ = asked(fitter, EndToFit(block.surface, ((block,),), SETTINGS))
    assert made == [block]


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("TASKS", "no.such.module"),
        ("_BOUNDS", Bounds(seconds=600, memory=1 << 20, reply=1 << 30)),
        ("_BOUNDS", Bounds(seconds=600, memory=8 << 30, reply=10)),
    ],
    ids=["none", "out of memory", "too large"],
)
def test_without_a_second_process_all_are_fitted(
    name: str, value: object, alone: list[FittedEnd], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(fitting, name, value)
    with end_fitter(2) as fitter:
        assert plain(fitter.fitted(ENDS)) == plain(alone)


def test_no_process_is_left_behind_when_fitting_fails(monkeypatch: pytest.MonkeyPatch) -> None:
    guests = []
    real = fitting.Guest

    def guest(*arguments: Any) -> Any:
        guests.append(real(*arguments))
        return guests[-1]

    monkeypatch.setattr(fitting, "Guest", guest)

    def failing(one: EndToFit) -> FittedEnd:
        msg = "as planted"
        raise ArithmeticError(msg)

    monkeypatch.setattr(EndToFit, "fitted", failing)
    with pytest.raises(ArithmeticError), end_fitter(2) as fitter:
        fitter.fitted(ENDS)
    assert [one._process for one in guests] == [None]


def test_a_primitive_stays_a_primitive() -> None:
    ball = welded(trimesh.creation.icosphere(3, 0.02))
    hull, sphere = hulled(ball, 32, 0), fittest(ball)
    assert hull is not None
    assert sphere is not None
    start = type(hull).of(ball, sphere, 0)
    with end_fitter(2) as fitter:
        made, fit = asked(fitter, EndToFit(ball, ((start,),), SETTINGS))
    assert [chunk.piece for chunk in made] == [sphere]
    assert fit.meets
    assert np.isclose(made[0].volume, surface_of(sphere).volume(), rtol=1e-12)
