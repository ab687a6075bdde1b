"""The jobs of a sweep are all combinations of its values."""

import itertools

import pytest
from hydra._internal.core_plugins.basic_sweeper import BasicSweeper

from linkwright.pipeline.config.compose import session
from linkwright.pipeline.config.hydra.loader import parsed
from linkwright.pipeline.sweep.run import jobs_of

USUAL = ("source=sample", "name=arm")


def jobs(*arguments, judge=lambda _: ()):
    with session(()) as composer:
        asked = composer.with_params(*composer.read([*USUAL, *arguments], multirun=True))
        assert not asked.problems
        return asked.overrides, jobs_of(composer, asked, judge).jobs


def settings(plan):
    return [plan.joints[name].model_dump(exclude_unset=True) for name in plan.joints]


def test_keys_with_a_name_that_is_no_word_are_swept_beside_each_other():
    _, made = jobs(
        "joints.*.damping=1,2", "joints.*.friction=3,4", "joints.lift.armature=0.1", "mesh=hull,raw"
    )
    drawn = list(itertools.product((1, 2), (3, 4), ("hull", "raw")))
    assert [
        (job.overrides["joints.*.damping"], job.overrides["joints.*.friction"], job.overrides["mesh"])
        for job in made
    ] == drawn
    assert [job.label for job in made] == [
        f"joints.*.damping={damping} joints.*.friction={friction} mesh={mesh}"
        for damping, friction, mesh in drawn
    ]
    for job, (damping, friction, _) in zip(made, drawn, strict=True):
        assert settings(job.plan) == [{"damping": damping, "friction": friction}, {"armature": 0.1}]


def test_a_key_with_a_name_that_is_no_word_is_kept_beside_a_swept_key():
    _, made = jobs("joints.*.damping=5", "joints.*.friction=3,4")
    assert [settings(job.plan) for job in made] == [[{"damping": 5, "friction": value}] for value in (3, 4)]
    assert [job.overrides["joints.*.damping"] for job in made] == [5, 5]


def test_the_last_of_a_key_wins():
    _, made = jobs("joints.*.damping=1,2", "mesh=raw,hull", "joints.*.damping=3,4,5", "mesh=visual")
    assert [settings(job.plan) for job in made] == [[{"damping": value}] for value in (3, 4, 5)]
    assert {job.overrides["mesh"] for job in made} == {"visual"}


@pytest.mark.parametrize("arguments", [
    ("mesh=glob(h*)", "root=auto,fixed"),
    ("vars.x=range(1,4)", "+vars.y='a b',\"c,d\"", "vars.z={a: 1, b: [1,2]}"),
    ("vars.x=1,2", "vars.y=null", "vars.x=3,4", "~mesh.coacd", "vars.i='${vars.x}'"),
    ("joints.*.damping=choice(2)", "joints.a.friction=sort(3,1,2)"),
])  # fmt: skip
def test_jobs_are_those_of_hydras_own_sweeper(arguments):
    with session(()) as composer:
        asked = composer.with_params(*composer.read(arguments, multirun=True))
        combinations = composer.reading.jobs(asked.overrides)
    batches = BasicSweeper.split_arguments([parsed(override.hydra) for override in asked.overrides], None)
    assert combinations == [list(job) for batch in batches for job in batch]
