"""Sweeps, experiments and `--cfg` in a terminal, as Hydra's users type them."""

import pytest
import yaml

from tests.support.command import COMMAND, environment
from tests.support.terminal import Terminal
from tests.support.users import write

ROBOT = """\
# @package _global_
defaults:
  - override /source: sample
  - override /root: fixed
hydra: {sweeper: {params: {hidden: "keep,drop"}}}
"""
EXPERIMENT = """\
# @package _global_
defaults:
  - override /robot: my_arm
  - override /root: free
vars: {reach: "${oc.env:REACH,0.04}"}
joints: {lift: {limits: [0, "${vars.reach}"]}}
"""


@pytest.fixture
def here(tmp_path):
    (tmp_path / "experiment").mkdir()
    (tmp_path / "experiment" / "wide.yaml").write_text(EXPERIMENT)
    return write(tmp_path, my_arm=ROBOT)


def session(here, *arguments):
    return Terminal([str(COMMAND), *arguments], here, environment(here, REACH="0.03"))


@pytest.mark.slow
def test_a_sweep_shows_its_jobs_and_a_table_with_figures(here):
    with session(here, "-m", "+experiment=wide", "depth=flexible,rigid", "until=graph") as terminal:
        shown = terminal.until("4 of 4 jobs built and valid: outputs/my_arm_wide.sweep")
    assert "job 3 starts: hidden=drop depth=rigid" in shown
    head, *rows = [line.split() for line in shown[shown.index("job  status") :].splitlines()]
    assert head == ["job", "status", "what", "kg", "dof", "calls", "folder"]
    assert [row[:5] for row in rows[:4]] == [[str(number), "0", "built", "up", "to"] for number in range(4)]
    assert all("3.286" in row for row in rows[:4])


def test_cfg_shows_what_an_experiment_makes_of_its_robot(here):
    with session(here, "--cfg", "job", "experiment=wide", "--resolve") as terminal:
        shown = terminal.until("until: validate")
    tree = yaml.safe_load(shown)
    assert (tree["name"], tree["root"]["base"], tree["source"]["kind"]) == ("my_arm_wide", "free", "sample")
    assert tree["joints"]["lift"]["limits"] == [0, 0.03]


def test_what_is_wrong_is_one_message(here):
    with session(here, "-m", "experiment=wide", "root=fred") as terminal:
        shown = terminal.until("did you mean")
    assert "E-OPTION" in shown
    assert "Traceback" not in shown
