"""What Hydra composes here, and which jobs it makes, are those of Hydra alone; files may change."""

import itertools

import pytest
from hydra import compose, initialize_config_module
from hydra._internal import defaults_list
from hydra._internal.core_plugins.basic_sweeper import BasicSweeper
from hydra.core.global_hydra import GlobalHydra
from hydra.types import RunMode
from omegaconf import OmegaConf

from linkwright.pipeline.config.compose import HYDRA_ARGUMENTS, compose_plan, session
from linkwright.pipeline.config.hydra.loader import PRIMARY, composed, parsed
from linkwright.pipeline.config.hydra.node import search_path_override
from linkwright.pipeline.sweep.run import compose_sweep
from tests.support.users import MY_ARM, write

GLOBAL = "# @package _global_\n"
NESTED = f"""{GLOBAL}
defaults:
  - _self_
  - base: [tool, gripper]
  - optional /part: none
  - override /source: sample
  - override /export: mjcf
vars: {{reach: 0.3, half: "${{vars.reach}}"}}
"""
MORE = {
    "experiment/short": f"{GLOBAL}defaults:\n  - override /robot: my_arm\n  - override /mesh: raw\n",
    "robot/base/tool": f"{GLOBAL}name: tool\n",
    "robot/base/gripper": f"{GLOBAL}joints: {{finger: {{limits: [0, 1]}}}}\n",
    "robot/folded": f"{GLOBAL}defaults:\r\n  - override /source: sample\r\nname: >-\r\n  a\r\n  b\r\n",
    "robot/empty": "",
    "part/one": "defaults: [two]\nreach: 1\n",
    "part/two": "reach: 2\n",
    "hydra/launcher/mine": "defaults: [basic]\n",
}
COMMANDS = [
    [],
    ["robot=sample"],
    ["source=urdf", "++source.path=a.urdf", "mesh=hull"],
    ["export=[]"],
    ["export=[mjcf,urdf]", "~validate"],
    ["robot=my_arm", "root=fixed", "++joints.elbow.damping=2"],
    ["robot=nested"],
    ["robot=folded"],
    ["robot=empty"],
    ["+experiment=short", "export=mjcf"],
    ["+part@vars=one"],
    ["hydra/launcher=mine", "robot=sample"],
]


@pytest.fixture
def here(tmp_path):
    for name, text in MORE.items():
        file = tmp_path / f"{name}.yaml"
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_bytes(text.encode())
    return write(tmp_path, my_arm=MY_ARM, nested=NESTED)


@pytest.mark.parametrize("overrides", COMMANDS, ids=" ".join)
def test_tree_and_paths_are_those_of_hydra_alone(here, overrides):
    everything = [*overrides, *search_path_override([here])]
    with initialize_config_module("linkwright.conf", job_name="linkwright", **HYDRA_ARGUMENTS):
        expected = compose(PRIMARY, everything, return_hydra_config=True)
        loader = GlobalHydra.instance().config_loader()
        files = [
            default.config_path or ""
            for default in loader.compute_defaults_list(PRIMARY, everything, RunMode.RUN).defaults
        ]
    with session(cwd=here):
        for _ in range(2):
            config, paths = composed(everything)
            assert OmegaConf.to_container(config) == OmegaConf.to_container(expected)
            assert list(config) == list(expected)
            assert list(paths) == files


def test_a_file_that_changes_is_read_again(here):
    for name in ("one", "two"):
        write(here, my_arm=MY_ARM + f"name: {name}\n")
        assert compose_plan(["robot=my_arm"], cwd=here).plan.name == name


def test_values_of_a_tree_are_not_those_of_the_next(here):
    with session(cwd=here):
        plain = OmegaConf.to_container(composed(["robot=sample"])[0])
        composed(
            ["robot=sample", "++joints={elbow:{damping:2}}", "++mesh.tolerance=1", "++hydra.verbose=true"]
        )
        composed(["robot=sample", "~joints"])
        assert OmegaConf.to_container(composed(["robot=sample"])[0]) == plain


def test_jobs_with_the_same_options_have_one_defaults_list(here, monkeypatch):
    listed = []
    make = defaults_list.create_defaults_list

    def counted(*args, **more):
        listed.append(args)
        return make(*args, **more)

    monkeypatch.setattr(defaults_list, "create_defaults_list", counted)
    with session(cwd=here) as composer:
        for mesh in ("hull", "raw", "hull"):
            for tolerance in ("0.1", "0.2"):
                overrides = ["robot=my_arm", f"mesh={mesh}", f"++mesh.tolerance={tolerance}"]
                section = composer.compose(overrides).plan.mesh
                assert (section.collider, section.tolerance) == (mesh, float(tolerance))
    assert len([args for args in listed if "mesh=hull" in str(args)]) == 1


USUAL = ("source=sample", "name=arm")


def jobs(*arguments, judge=lambda _: ()):
    with session(()) as composer:
        asked = composer.with_params(*composer.read([*USUAL, *arguments], multirun=True))
        assert not asked.problems
        return asked.overrides, compose_sweep(composer, asked, judge).jobs


def settings(plan):
    return [plan.joints[name].model_dump(exclude_unset=True) for name in plan.joints]


def test_keys_with_globs_are_swept_beside_each_other():
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


def test_the_last_of_a_key_wins_and_other_keys_are_kept():
    _, made = jobs("joints.*.damping=1,2", "mesh=raw,hull", "joints.*.damping=3,4,5", "mesh=visual")
    assert [settings(job.plan) for job in made] == [[{"damping": value}] for value in (3, 4, 5)]
    assert {job.overrides["mesh"] for job in made} == {"visual"}
    _, made = jobs("joints.*.damping=5", "joints.*.friction=3,4")
    assert [settings(job.plan) for job in made] == [[{"damping": 5, "friction": value}] for value in (3, 4)]
    assert [job.overrides["joints.*.damping"] for job in made] == [5, 5]


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
