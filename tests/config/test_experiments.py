"""Experiment files, helper variables and values of the environment, as Hydra's users know them."""

import pytest

from linkwright.pipeline.cli import run
from linkwright.pipeline.config.compose import compose_plan
from linkwright.pipeline.report import Report
from linkwright.stages.robot.errors import ConfigError
from tests.support.users import write

GLOBAL = "# @package _global_\n"
SAMPLE = f"{GLOBAL}defaults:\n  - override /source: sample\n"
MY_ARM = f"{SAMPLE}  - override /root: fixed\nground: {{size: [2, 2]}}\nmesh: {{tolerance: null}}\n"


def experiment(folder, **experiments):
    for name, text in experiments.items():
        file = folder / "experiment" / f"{name}.yaml"
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(GLOBAL + text, encoding="utf-8")
    return folder


def composed(folder, *arguments, config_dirs=()):
    return compose_plan(arguments, config_dirs, folder)


def refused(folder, *arguments):
    with pytest.raises(ConfigError) as caught:
        composed(folder, *arguments)
    return str(caught.value)


@pytest.mark.parametrize("typed", ["+experiment=e1", "experiment=e1"])
def test_an_experiment_chooses_the_robot_and_nothing_is_defaulted(tmp_path, typed):
    write(experiment(tmp_path, e1="defaults:\n  - override /robot: my_arm\n"), my_arm=MY_ARM)
    made = composed(tmp_path, typed)
    assert (made.robot, made.plan.name, made.plan.root.base) == ("my_arm", "my_arm_e1", "fixed")


@pytest.mark.parametrize(
    "text",
    [
        "defaults:\n  - override /source: bundle\nsource: {path: a.zip}\n",
        "source: {kind: bundle, path: a.zip}\n",
    ],
)
def test_an_experiment_chooses_the_source_and_nothing_is_defaulted(tmp_path, text):
    made = composed(experiment(tmp_path, e1=text), "+experiment=e1")
    assert (made.robot, made.plan.name, made.plan.source.kind) == ("bare", "a_e1", "bundle")


def test_an_experiment_that_chooses_neither_changes_the_sample(tmp_path):
    made = composed(experiment(tmp_path, e1="name: other\n"), "+experiment=e1")
    assert (made.robot, made.plan.name, made.plan.source.kind) == ("sample", "other", "sample")


def test_any_group_of_ones_own_may_choose_a_robot(tmp_path):
    write(tmp_path, my_arm=MY_ARM)
    (tmp_path / "variants").mkdir()
    (tmp_path / "variants" / "mine.yaml").write_text(f"{GLOBAL}defaults:\n  - override /robot: my_arm\n")
    assert composed(tmp_path, "variants=mine").robot == "my_arm"


def test_an_option_of_ones_own_may_have_a_defaults_list_and_a_place(tmp_path):
    write(tmp_path, my_arm=MY_ARM)
    (tmp_path / "root").mkdir()
    (tmp_path / "root" / "mine.yaml").write_text("defaults: [free]\nselect: base\n")
    (tmp_path / "root" / "wide.yaml").write_text(f"{GLOBAL}ground: {{size: [9, 9]}}\n")
    root = composed(tmp_path, "robot=my_arm", "root=mine").plan.root
    assert (root.base, root.select) == ("free", "base")
    assert composed(tmp_path, "source=sample", "root=wide").plan.ground.size == (9, 9)


def test_an_experiment_leaves_the_robots_own_output_alone(tmp_path):
    texts = {"wide": "ground: {size: [1, 1]}\n", "named": "name: other\n", "placed": "output: elsewhere\n"}
    write(experiment(tmp_path, **texts), my_arm=MY_ARM, titled=f"{MY_ARM}name: arm\n")
    found = {
        (robot, name): composed(tmp_path, f"robot={robot}", f"experiment={name}").plan
        for robot in ("my_arm", "titled")
        for name in texts
    }
    names = [plan.name for plan in found.values()]
    assert names == ["my_arm_wide", "other", "my_arm_placed", "arm_wide", "other", "arm_placed"]
    assert str(found["titled", "wide"].folder).endswith("outputs/arm_wide")
    assert str(found["titled", "placed"].folder) == "elsewhere"
    assert composed(tmp_path, "robot=titled", "experiment=wide", "name=mine").plan.name == "mine"


def test_an_experiment_wins_over_the_robot_and_the_command_line_over_both(tmp_path):
    text = "defaults:\n  - override /robot: my_arm\n  - override /root: free\nground: {size: [1, 1]}\n"
    write(experiment(tmp_path, e1=text), my_arm=MY_ARM)
    plan = composed(tmp_path, "+experiment=e1").plan
    assert (plan.root.base, plan.ground.size) == ("free", (1, 1))
    plan = composed(tmp_path, "+experiment=e1", "root=fixed", "ground.size=[3,3]").plan
    assert (plan.root.base, plan.ground.size) == ("fixed", (3, 3))


def test_an_option_that_an_experiment_chooses_wins_over_keys_of_the_robot(tmp_path):
    own = f"{SAMPLE}root: {{base: fixed, select: auto}}\n"
    write(experiment(tmp_path, e1="defaults:\n  - override /root: free\n"), my_arm=own)
    assert composed(tmp_path, "robot=my_arm", "+experiment=e1").plan.root.base == "free"
    assert composed(tmp_path, "robot=my_arm", "+experiment=e1", "root.base=auto").plan.root.base == "auto"
    experiment(tmp_path, e2="defaults:\n  - override /root: free\nroot: {base: auto}\n")
    assert composed(tmp_path, "robot=my_arm", "+experiment=e2").plan.root.base == "auto"


def test_keys_of_the_robots_source_are_dropped_where_an_experiment_chooses_another(tmp_path):
    own = f"{GLOBAL}defaults:\n  - override /source: onshape\nsource: {{url: x}}\n"
    other = "defaults:\n  - override /source: bundle\nsource: {path: a.zip}\n"
    write(experiment(tmp_path, e1=other), my_arm=own)
    assert composed(tmp_path, "robot=my_arm", "+experiment=e1").plan.source.path == "a.zip"


def test_experiments_lie_in_the_working_folder_or_in_config_dir(tmp_path):
    there = experiment(tmp_path / "there", e1="name: other\n")
    (tmp_path / "here").mkdir()
    assert composed(tmp_path / "here", "experiment=e1", config_dirs=[there]).plan.name == "other"


def test_experiments_are_swept_over(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    write(experiment(tmp_path, a="defaults:\n  - override /robot: my_arm\n", b="name: b\n"), my_arm=MY_ARM)
    plans = []

    def build(plan):
        plans.append(plan)
        return Report("built", plan.name, str(plan.folder), plan.until, 0)

    assert run(["-m", "experiment=a,b"], build) == 0
    assert [(plan.name, plan.source.kind) for plan in plans] == [("my_arm_a", "sample"), ("b", "sample")]


@pytest.mark.parametrize(
    ("typed", "shown"),
    [
        (
            "experiment=e2",
            "E-OPTION experiment=e2: there is no such option\n      options: e1",
        ),
        (
            "+experiment=e2",
            "E-OPTION experiment=e2: there is no such option\n      options: e1",
        ),
        ("other=e2", "E-KEY other: unknown key (given 'e2')"),
    ],
)
def test_an_experiment_that_is_not_there_is_reported(tmp_path, typed, shown):
    assert shown in refused(experiment(tmp_path, e1="name: x\n"), typed)


def test_where_experiments_belong_is_reported(tmp_path):
    assert "an experiment is a file ./experiment/NAME.yaml" in refused(tmp_path, "experiment=e1")
    experiment(tmp_path, e1="").joinpath("experiment/e1.yaml").write_text("name: x\n")
    assert "the keys of the experiment's file lie under `experiment`" in refused(tmp_path, "experiment=e1")


VARS = f"""\
{SAMPLE}vars: {{reach: 0.3, speed: "${{oc.env:SPEED,4}}", deep: {{list: [1, 2]}}}}
mass: {{density: "${{oc.env:DENSITY,900}}"}}
depth: {{max: "${{oc.env:LEVELS,2}}"}}
joints: {{"*": {{velocity: "${{vars.speed}}", limits: ["${{oc.env:LOW,-1.5}}", "${{vars.reach}}"]}}}}
name: "${{oc.env:ARM,007}}"
scene: {{option: {{timestep: "${{vars.deep.list.0}}"}}}}
"""


def test_vars_are_the_users_own(tmp_path):
    plan = composed(write(tmp_path, my_arm=VARS), "robot=my_arm", "vars.reach=0.5", "vars.more=[1]").plan
    assert plan.joints["*"].limits == (-1.5, 0.5)
    assert plan.vars["more"] == [1]
    assert plan.scene.option.timestep == 1


def test_a_value_of_the_environment_is_a_number_where_one_is_wanted_and_text_elsewhere(tmp_path, monkeypatch):
    write(tmp_path, my_arm=VARS)
    plan = composed(tmp_path, "robot=my_arm").plan
    assert (plan.mass.density, plan.depth.max, plan.joints["*"].velocity, plan.name) == (900, 2, 4, "007")
    monkeypatch.setenv("DENSITY", " 1e3 ")
    monkeypatch.setenv("LOW", "-2")
    plan = composed(tmp_path, "robot=my_arm").plan
    assert (plan.mass.density, plan.joints["*"].limits[0]) == (1000, -2)


def test_it_is_a_truth_value_or_a_number_on_the_command_line_too(tmp_path, monkeypatch):
    monkeypatch.setenv("OFF", "True")
    url = (
        "source.url='https://cad.onshape.com/documents/"
        + "a" * 24
        + "/w/"
        + "b" * 24
        + "/e/"
        + "c" * 24
        + "'"
    )
    typed = ["source=onshape", url, "source.offline='${oc.env:OFF}'", "source.max_calls='${oc.env:CALLS,7}'"]
    source = composed(tmp_path, *typed).plan.source
    assert (source.offline, source.max_calls) == (True, 7)


def test_what_is_no_number_is_reported_as_it_stands_in_the_environment(tmp_path, monkeypatch):
    monkeypatch.setenv("DENSITY", "heavy")
    monkeypatch.setenv("LEVELS", "2.5")
    shown = refused(write(tmp_path, my_arm=VARS), "robot=my_arm")
    assert "E-VALUE mass.density: must be a number (given 'heavy')" in shown
    assert "E-VALUE depth.max: must be a whole number (given '2.5')" in shown


def test_text_in_a_file_that_is_no_interpolation_stays_text(tmp_path):
    write(tmp_path, my_arm=f"{SAMPLE}mass: {{density: '900'}}\n")
    assert "E-VALUE mass.density: must be a number (given '900')" in refused(tmp_path, "robot=my_arm")


def test_a_file_chooses_one_option_of_a_group(tmp_path):
    """Hydra takes the first in a robot's file, and the last in an experiment's."""
    twice = "  - override /source: sample\n  - override /source: urdf\n"
    write(experiment(tmp_path, e1=f"defaults:\n{twice}"), my_arm=f"# @package _global_\ndefaults:\n{twice}")
    for typed, file in (("experiment=e1", "experiment/e1.yaml"), ("robot=my_arm", "robot/my_arm.yaml")):
        shown = refused(tmp_path, typed)
        assert f"E-OPTION {file}: its defaults list overrides source more than once: sample, urdf" in shown
        assert "keep one line, override /source: urdf" in shown
