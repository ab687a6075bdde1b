"""Experiment files, helper variables and values of the environment, as Hydra's users know them."""

import pytest

from linkwright.pipeline.cli import run
from tests.support.stand_in_builds import Recorder
from tests.support.users import GLOBAL, SAMPLE, URL, composed, put, refused, write

MY_ARM = f"{SAMPLE}  - override /root: fixed\nground: {{size: [2, 2]}}\nmesh: {{tolerance: null}}\n"
ARM = "defaults:\n  - override /robot: my_arm\n"


def experiment(folder, **experiments):
    return put(folder, {f"experiment/{name}.yaml": GLOBAL + text for name, text in experiments.items()})


def plan(folder, *arguments):
    return composed(folder, *arguments).plan


SOURCE = "source: {path: a.zip}\n"


@pytest.mark.parametrize(("typed", "text", "made"), [
    ("+experiment=e1", ARM, ("my_arm", "my_arm_e1", "sample")),
    ("experiment=e1", ARM, ("my_arm", "my_arm_e1", "sample")),
    ("+experiment=e1", f"defaults:\n  - override /source: bundle\n{SOURCE}", ("bare", "a_e1", "bundle")),
    ("+experiment=e1", "source: {kind: bundle, path: a.zip}\n", ("bare", "a_e1", "bundle")),
    ("+experiment=e1", "name: other\n", ("sample", "other", "sample")),
    ("robot=far +experiment=e1", f"defaults:\n  - override /source: bundle\n{SOURCE}",
     ("far", "far_e1", "bundle")),
], ids=["robot", "without plus", "source", "keys of a source", "sample", "another source"])  # fmt: skip
def test_an_experiment_chooses_the_robot_or_the_source(tmp_path, typed, text, made):
    far = f"{GLOBAL}defaults:\n  - override /source: onshape\nsource: {{url: x}}\n"
    write(experiment(tmp_path, e1=text), my_arm=MY_ARM, far=far)
    result = composed(tmp_path, *typed.split())
    assert (result.robot, result.plan.name, result.plan.source.kind) == made


def test_options_of_the_user_have_defaults_and_a_place(tmp_path):
    wide = f"{GLOBAL}ground: {{size: [9, 9]}}\n"
    put(tmp_path, {"root/mine.yaml": "defaults: [free]\nselect: base\n", "root/wide.yaml": wide})
    put(write(tmp_path, my_arm=MY_ARM), {"variants/mine.yaml": GLOBAL + ARM})
    assert composed(tmp_path, "variants=mine").robot == "my_arm"
    root = plan(tmp_path, "robot=my_arm", "root=mine").root
    assert (root.base, root.select) == ("free", "base")
    assert plan(tmp_path, "source=sample", "root=wide").ground.size == (9, 9)


def test_an_experiment_leaves_the_robots_own_output_alone(tmp_path):
    texts = {"wide": "ground: {size: [1, 1]}\n", "named": "name: other\n", "placed": "output: elsewhere\n"}
    write(experiment(tmp_path, **texts), my_arm=MY_ARM, titled=f"{MY_ARM}name: arm\n")
    plans = {
        (robot, name): plan(tmp_path, f"robot={robot}", f"experiment={name}")
        for robot in ("my_arm", "titled")
        for name in texts
    }
    names = [made.name for made in plans.values()]
    assert names == ["my_arm_wide", "other", "my_arm_placed", "arm_wide", "other", "arm_placed"]
    assert str(plans["titled", "wide"].folder).endswith("outputs/arm_wide")
    assert str(plans["titled", "placed"].folder) == "elsewhere"
    assert plan(tmp_path, "robot=titled", "experiment=wide", "name=mine").name == "mine"


FREE = "  - override /root: free\n"
WIDE = f"{ARM}{FREE}ground: {{size: [1, 1]}}\n"
OWN = f"{SAMPLE}root: {{base: fixed, select: auto}}\nground: {{size: [2, 2]}}\n"


@pytest.mark.parametrize(("robot", "text", "typed", "base", "size"), [
    (MY_ARM, WIDE, [], "free", (1, 1)),
    (MY_ARM, WIDE, ["root=fixed", "ground.size=[3,3]"], "fixed", (3, 3)),
    (OWN, f"defaults:\n{FREE}", ["robot=my_arm"], "free", (2, 2)),
    (OWN, f"defaults:\n{FREE}", ["robot=my_arm", "root.base=auto"], "auto", (2, 2)),
    (OWN, f"defaults:\n{FREE}root: {{base: auto}}\n", ["robot=my_arm"], "auto", (2, 2)),
])  # fmt: skip
def test_command_line_wins_over_experiment_and_robot(tmp_path, robot, text, typed, base, size):
    write(experiment(tmp_path, e1=text), my_arm=robot)
    made = plan(tmp_path, *typed, "+experiment=e1")
    assert (made.root.base, made.ground.size) == (base, size)


def test_experiments_are_in_the_working_folder_or_in_config_dir(tmp_path):
    there = experiment(tmp_path / "there", e1="name: other\n")
    (tmp_path / "here").mkdir()
    assert composed(tmp_path / "here", "experiment=e1", dirs=[there]).plan.name == "other"


def test_experiments_are_swept_over(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    write(experiment(tmp_path, a=ARM, b="name: b\n"), my_arm=MY_ARM)
    build = Recorder()
    assert run(["-m", "experiment=a,b"], build) == 0
    assert [(plan.name, plan.source.kind) for plan in build.plans] == [
        ("my_arm_a", "sample"),
        ("b", "sample"),
    ]


UNKNOWN = "E-OPTION experiment=e2: there is no such option\n      options: e1"


@pytest.mark.parametrize(("typed", "shown"), [
    ("experiment=e2", UNKNOWN),
    ("+experiment=e2", UNKNOWN),
    ("other=e2", "E-KEY other: unknown key (given 'e2')"),
])  # fmt: skip
def test_an_unknown_experiment_is_reported(tmp_path, typed, shown):
    assert shown in refused(experiment(tmp_path, e1="name: x\n"), typed)


def test_the_message_says_where_experiments_belong(tmp_path):
    assert "an experiment is a file ./experiment/NAME.yaml" in refused(tmp_path, "experiment=e1")
    put(tmp_path, {"experiment/e1.yaml": "name: x\n"})
    assert "the keys of the experiment's file are under `experiment`" in refused(tmp_path, "experiment=e1")


VARS = f"""\
{SAMPLE}vars: {{reach: 0.3, speed: "${{oc.env:SPEED,4}}", deep: {{list: [1, 2]}}}}
mass: {{density: "${{oc.env:DENSITY,900}}"}}
depth: {{max: "${{oc.env:LEVELS,2}}"}}
joints: {{"*": {{velocity: "${{vars.speed}}", limits: ["${{oc.env:LOW,-1.5}}", "${{vars.reach}}"]}}}}
name: "${{oc.env:ARM,007}}"
scene: {{option: {{timestep: "${{vars.deep.list.0}}"}}}}
"""


def test_interpolations_are_numbers_where_a_key_needs_one(tmp_path, monkeypatch):
    write(tmp_path, my_arm=VARS)
    made = plan(tmp_path, "robot=my_arm", "vars.reach=0.5", "vars.more=[1]")
    assert (made.joints["*"].limits, made.vars["more"], made.scene.option.timestep) == ((-1.5, 0.5), [1], 1)
    assert (made.mass.density, made.depth.max, made.joints["*"].velocity, made.name) == (900, 2, 4, "007")
    monkeypatch.setenv("DENSITY", " 1e3 ")
    monkeypatch.setenv("LOW", "-2")
    made = plan(tmp_path, "robot=my_arm")
    assert (made.mass.density, made.joints["*"].limits[0]) == (1000, -2)
    monkeypatch.setenv("OFF", "True")
    typed = ["source.offline='${oc.env:OFF}'", "source.max_calls='${oc.env:CALLS,7}'"]
    source = plan(tmp_path, "source=onshape", f"source.url='{URL}'", *typed).source
    assert (source.offline, source.max_calls) == (True, 7)


def test_value_that_is_no_number_is_reported_as_it_is(tmp_path, monkeypatch):
    monkeypatch.setenv("DENSITY", "heavy")
    monkeypatch.setenv("LEVELS", "2.5")
    shown = refused(write(tmp_path, my_arm=VARS), "robot=my_arm")
    assert "E-VALUE mass.density: must be a number (given 'heavy')" in shown
    assert "E-VALUE depth.max: must be a whole number (given '2.5')" in shown
    write(tmp_path, my_arm=f"{SAMPLE}mass: {{density: '900'}}\n")
    assert "E-VALUE mass.density: must be a number (given '900')" in refused(tmp_path, "robot=my_arm")


@pytest.mark.parametrize("kind", ["experiment", "robot"])
def test_a_file_chooses_an_option_of_a_group_once(tmp_path, kind):
    """Hydra takes the first in a robot's file, and the last in an experiment's."""
    text = f"{GLOBAL}defaults:\n  - override /source: sample\n  - override /source: urdf\n"
    shown = refused(put(tmp_path, {f"{kind}/e1.yaml": text}), f"{kind}=e1")
    assert (
        f"E-OPTION {kind}/e1.yaml: its defaults list overrides source more than once: sample, urdf" in shown
    )
    assert "keep one line, override /source: urdf" in shown


@pytest.mark.parametrize(("text", "chosen"), [
    ("defaults:\n  - override /target: none\n", ()),
    ("defaults:\n  - override /target: drake\n", ("drake",)),
    ("defaults:\n  - override /target: [newton, drake]\n", ("newton", "drake")),
    ("mesh: {tolerance: 0.1}\n", ("mjx",)),
])  # fmt: skip
def test_targets_of_an_experiment_replace_the_robots(tmp_path, text, chosen):
    write(experiment(tmp_path, e1=text), my_arm=f"{MY_ARM}target: {{mjx: {{iterations: 7}}}}\n")
    assert plan(tmp_path, "robot=my_arm", "+experiment=e1").target.chosen == chosen
