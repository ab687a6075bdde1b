"""What Hydra composes here is what Hydra alone composes, and the files are those of its own defaults list."""

import pytest
from hydra import compose, initialize_config_module
from hydra._internal import defaults_list
from hydra.core.global_hydra import GlobalHydra
from hydra.types import RunMode
from omegaconf import OmegaConf

from linkwright.pipeline.config.compose import HYDRA, compose_plan, session
from linkwright.pipeline.config.hydra.loader import PRIMARY, composed
from linkwright.pipeline.config.hydra.node import search_path_override
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
    with initialize_config_module("linkwright.conf", job_name="linkwright", **HYDRA):
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
