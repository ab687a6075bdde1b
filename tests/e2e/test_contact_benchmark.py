"""What the benchmark of contacts compares: the models that it makes of a build, and that these differ."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from linkwright.stages.validate.contact_errors import contact_errors
from linkwright.stages.validate.model.shapes import seen_and_solid
from tests.benchmarks.contacts import compiled, counts
from tests.benchmarks.dropped import VARIANTS, models, recorded
from tests.benchmarks.walker import PARTS, walker_document
from tests.support.mutated_builds import built

LINKS = 13


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The walker with the mesh of each part, which is its hull to MuJoCo."""
    keys = {"root": {"base": "free"}, "mesh": {"collider": "raw"}, "contact": {"self": "auto"}}
    return built(
        walker_document(), tmp_path_factory.mktemp("walker") / "build", keys | {"export": {"mjcf": {}}}
    ).folder


def test_each_model_has_the_colliders_that_it_is_called_by(folder: Path) -> None:
    made = models(folder)
    robot = compiled(folder)
    shapes = seen_and_solid(robot.model).values()
    floor = 1
    solid = {
        name: int(((model.geom_contype != 0) | (model.geom_conaffinity != 0)).sum()) - floor
        for name, model in made.items()
    }
    assert len(robot.robot.links) == LINKS
    assert solid == {"made": PARTS, "raw": sum(len(seen) for seen, _ in shapes), "hulls": LINKS}
    # Of each leg the shank with its foot, four parts, is the end.
    assert counts(robot.model) == (PARTS, 16, pytest.approx((PARTS - 16) / (LINKS - 4)))
    masses = [model.body_mass for model in made.values()]
    assert all(np.allclose(one, masses[0], rtol=1e-9) for one in masses)
    states = {name: recorded(made[name]) for name in VARIANTS}
    assert {len(one) for one in states.values()} == {50}
    assert not np.allclose(states["made"][-1][0], states["hulls"][-1][0])


def test_one_hull_of_the_trunk_is_in_the_way_of_the_legs(folder: Path) -> None:
    """The thighs swing beside the spine, between two plates."""
    robot = compiled(folder)
    by_part = contact_errors(robot, 100)
    assert sum(pair.false + pair.missed for pair in by_part.pairs) < 0.1 * by_part.poses
    hulls = contact_errors(replace(robot, model=models(folder)["hulls"]), 100)
    names = {
        frozenset(robot.model.body(body).name for body in pair.bodies): pair.false / hulls.poses
        for pair in hulls.pairs
    }
    for leg in ("front_left", "front_right", "rear_left", "rear_right"):
        assert names[frozenset(("trunk", f"{leg}_thigh"))] > 0.4
    assert all(pair.missed == 0 for pair in hulls.pairs)
