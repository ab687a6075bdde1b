"""Ends are fitted in two processes as in one, whatever becomes of the second process."""

import numpy as np
import pytest
import trimesh

from linkwright.stages.mesh.by_contact import fitting
from linkwright.stages.mesh.by_contact.fitting import EndToFit, end_fitter
from linkwright.stages.mesh.configuration.collider_settings import ContactSettings
from linkwright.stages.mesh.cut.chunk import Chunk, hull_chunk
from linkwright.stages.mesh.fit import best_primitive
from linkwright.stages.mesh.surfaces.pieces import surface_of
from linkwright.stages.robot.system.guest import Bounds
from tests.support.solids import box, of_mesh

SETTINGS = ContactSettings(max_vertices=32)


def end(x, y, z):
    """A fork with two tines."""
    boxes = [((0, 0, 0), (x, y, 0.01)), ((0, 0, 0), (0.01, y, z)), ((x - 0.01, 0, 0), (x, y, z))]
    fork = of_mesh(trimesh.boolean.union([trimesh.creation.box(bounds=box) for box in boxes]))
    return EndToFit(fork, ((hull_chunk(fork, SETTINGS.max_vertices, 0),),), SETTINGS)


ENDS = [end(0.08, 0.02, 0.05), end(0.05, 0.03, 0.09), end(0.06, 0.02, 0.06)]


def by_guest(fitter, end):
    """Fitted by the second process, of which one thread asks at a time."""
    return fitter._pool.submit(fitter._fitted_by_guest, end).result()


def plain(fitted):
    def content(surface):
        return surface.vertices.tobytes(), surface.triangles.tobytes()

    return [
        (
            [
                (content(chunk.surface), content(surface_of(chunk.piece)), chunk.collider_index, chunk.volume)
                for chunk in chunks
            ],
            repr(fit),
        )
        for chunks, fit in fitted
    ]


@pytest.fixture(scope="module")
def here():
    """The ends fitted in this process."""
    fitted = [end.fitted() for end in ENDS]
    assert all(len(chunks) == 3 for chunks, _ in fitted)
    return plain(fitted)


def test_two_processes_give_what_one_gives(here, monkeypatch):
    with end_fitter(2) as fitter:
        assert plain(fitter.fitted(ENDS)) == here
        monkeypatch.setattr(EndToFit, "fitted", lambda end: pytest.fail("not by this process"))
        assert plain([by_guest(fitter, end) for end in ENDS]) == here


def test_end_that_needs_no_cut_keeps_its_pieces():
    """The very same object, by which its depths in other links are known; a primitive stays a primitive."""
    block = hull_chunk(box(0.04, 0.05, 0.06), 32, 0)
    ball = of_mesh(trimesh.creation.icosphere(3, 0.02))
    sphere = best_primitive(ball)
    start = Chunk.of(ball, sphere, 0)
    with end_fitter(2) as fitter:
        chunks, _ = by_guest(fitter, EndToFit(block.surface, ((block,),), SETTINGS))
        assert chunks == [block]
        (chunk,), fit = by_guest(fitter, EndToFit(ball, ((start,),), SETTINGS))
    assert (chunk.piece, fit.meets) == (sphere, True)
    assert np.isclose(chunk.volume, surface_of(sphere).volume(), rtol=1e-12)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("TASKS", "no.such.module"),
        ("_BOUNDS", Bounds(seconds=600, memory=1 << 20, reply=1 << 30)),
        ("_BOUNDS", Bounds(seconds=600, memory=8 << 30, reply=10)),
    ],
    ids=["none", "out of memory", "too large"],
)
def test_without_a_second_process_all_are_fitted(name, value, here, monkeypatch):
    monkeypatch.setattr(fitting, name, value)
    with end_fitter(2) as fitter:
        assert plain(fitter.fitted(ENDS)) == here


def test_no_process_is_left_behind_when_fitting_fails(monkeypatch):
    guests = []
    real = fitting.Guest
    monkeypatch.setattr(fitting, "Guest", lambda *options: guests.append(real(*options)) or guests[-1])
    monkeypatch.setattr(EndToFit, "fitted", lambda end: 1 / 0)
    with pytest.raises(ZeroDivisionError), end_fitter(2) as fitter:
        fitter.fitted(ENDS)
    assert [guest._process for guest in guests] == [None]
