"""A search by a sweeper that is a plug-in of Hydra: what it gets, and what it cannot do.

The sweeper here is a small one of the tests; that of Optuna is searched with in the slow tests.
"""

import itertools
import json
from types import SimpleNamespace

import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from linkwright.pipeline.config.objective_section import ObjectiveSection
from linkwright.pipeline.sweep.outcome import Outcome
from linkwright.pipeline.sweep.search import MAX_VALUES, Trials, corners
from tests.support.command import called, environment, linkwright
from tests.support.users import write

pytestmark = pytest.mark.slow

TOY = '''
"""Ternary search over the first interval; tries the values of `extra` first."""
import json
from dataclasses import dataclass, field
from pathlib import Path
from hydra.core.config_store import ConfigStore
from hydra.core.override_parser.overrides_parser import OverridesParser
from hydra.core.plugins import Plugins
from hydra.plugins.sweeper import Sweeper
from omegaconf import ListConfig

class ToySweeper(Sweeper):
    def __init__(self, direction, n_trials, extra, params):
        self.direction, self.n_trials, self.extra = direction, n_trials, list(extra)

    def setup(self, *, hydra_context, task_function, config):
        self.folder = Path(config.hydra.sweep.dir)
        self.launcher = Plugins.instance().instantiate_launcher(
            hydra_context=hydra_context, task_function=task_function, config=config
        )

    def sweep(self, arguments):
        (override,) = OverridesParser.create().parse_overrides(arguments)
        key, low, high = override.get_key_element(), override.value().start, override.value().end
        answers, index = [], 0

        def ask(*values):
            nonlocal index
            made = self.launcher.launch([[f"{key}={value}"] for value in values], initial_job_idx=index)
            index += len(made)
            answers.extend([value, job.return_value] for value, job in zip(values, made))
            return [job.return_value for job in made]

        if self.extra:
            ask(*self.extra)
        while index + 2 <= self.n_trials:
            first, second = low + (high - low) / 3, high - (high - low) / 3
            costs = ask(first, second)
            low, high = (low, second) if costs[0] < costs[1] else (first, high)
        (self.folder / "told.json").write_text(json.dumps([arguments, answers]))

@dataclass
class ToyConf:
    _target_: str = "hydra_plugins.toy_sweeper.toy.ToySweeper"
    direction: str = "minimize"
    n_trials: int = 4
    extra: list = field(default_factory=list)
    params: dict | None = None

ConfigStore.instance().store(group="hydra/sweeper", name="toy", node=ToyConf, provider="toy")
'''

SPACE = "mass.links.forearm.mass=interval(0.1,2.0)"
SEARCH = ["-m", "hydra/sweeper=toy", "until=graph", SPACE]


@pytest.fixture
def here(tmp_path):
    plugin = tmp_path / "plugins" / "hydra_plugins" / "toy_sweeper"
    plugin.mkdir(parents=True)
    (plugin / "__init__.py").touch()
    (plugin / "toy.py").write_text(TOY)
    (tmp_path / "far.py").write_text("def far(robot, goal): return (robot.mass - goal) ** 2\n")
    return tmp_path


def searched(here, *arguments):
    environ = environment(here, seeded=False, PYTHONPATH=str(here / "plugins"))
    # A process finds its plug-ins once.
    needs_toy = {"hydra/sweeper=toy", "robot=mine"} & {*arguments}
    return (linkwright if needs_toy else called)(here, *arguments, environ=environ)


def rows(here, name="sample"):
    return json.loads((here / f"outputs/{name}.sweep/summary.json").read_text())["runs"][-1]["jobs"]


def answers_in(here):
    """The overrides that the sweeper got, and the values that it tried with their costs."""
    return json.loads((here / "outputs/sample.sweep/told.json").read_text())


@pytest.mark.e2e
def test_search_ends_near_the_known_optimum(here):
    objective = ["objective={_target_: far.far, args: {goal: 4.0}}", "plugins=[far]"]
    done = searched(here, *SEARCH, "hydra.sweeper.n_trials=26", "hydra.sweeper.extra=[1.0,1.0]", *objective)
    assert done.returncode == 0, done.stderr
    jobs = rows(here)
    costs = {job["number"]: job["objective"] for job in jobs}
    best = jobs[min(costs, key=lambda number: costs[number])]
    # The goal, less the mass of the other links, which any job tells.
    fixed_mass = jobs[0]["figures"]["mass"] - jobs[0]["overrides"]["mass.links.forearm.mass"]
    assert best["overrides"]["mass.links.forearm.mass"] == pytest.approx(4.0 - fixed_mass, abs=1e-2)
    assert f"best: {best['objective']:.6g} of job {best['number']}" in done.stdout
    arguments, answers = answers_in(here)
    assert arguments == [SPACE]
    assert len(answers) == 26
    assert len(jobs) == 25
    assert answers[0] == answers[1]
    assert answers[0][1] == pytest.approx(jobs[0]["objective"])


@pytest.mark.e2e
def test_invalid_trial_has_the_objective_of_a_failure(here):
    more = [
        "objective={figure: mass, failed: 77}",
        "hydra.sweeper.extra=[-1,0.5]",
        "hydra.sweeper.n_trials=2",
    ]
    done = searched(here, *SEARCH, *more)
    assert done.returncode == 0, done.stderr
    _, answers = answers_in(here)
    assert answers[0] == [-1, 77.0]
    good, bad = rows(here)
    assert (good["status"], bad["status"]) == (0, 2)
    assert "mass.links.forearm.mass" in " ".join([bad["message"], *bad["problems"]])


@pytest.mark.e2e
def test_file_of_a_robot_may_choose_sweeper_and_space(here):
    tree = {"defaults": [{"override /source": "sample"}, {"override /hydra/sweeper": "toy"}]}
    tree |= {"name": "mine", "until": "graph", "objective": {"figure": "mass"}}
    key, space = SPACE.split("=")
    tree["hydra"] = {"sweeper": {"n_trials": 2, "params": {key: space}}}
    write(here, mine="# @package _global_\n" + yaml.safe_dump(tree))
    done = searched(here, "-m", "robot=mine")
    assert done.returncode == 0, done.stderr
    assert len(rows(here, "mine")) == 2
    tree["hydra"]["sweeper"]["extra"] = [3]
    write(here, mine="# @package _global_\n" + yaml.safe_dump(tree))
    refused = searched(here, "-m", "robot=mine")
    assert refused.returncode == 2
    assert "hydra.sweeper.extra: a file must not set this key" in refused.stderr


@pytest.mark.e2e
@pytest.mark.parametrize(("arguments", "said"), [
    ([*SEARCH], "a search needs a number from each job"),
    ([*SEARCH, "objective.figures=[mass,reach]"], "2 figures need the same number of directions"),
    ([*SEARCH, "objective.figure=mass", "--plan", "jobs.json"], "by the results of earlier jobs"),
    ([*SEARCH[:3], "joints.*.damping=1,2", "joints.*.friction=1,2", "objective.figure=mass"],
     "joints.*.friction: cannot be searched beside joints.*.damping"),
    ([*SEARCH[:3], "mass.links.forearm.mass=interval(-1,2)", "objective.figure=mass"], "must be"),
    (["-m", SPACE, "until=graph"], "list them, or search: hydra/sweeper=optuna"),
    (["-m", SPACE, "hydra/sweeper=none_such"], "there is no sweeper none_such"),
    ([SPACE], "several values, but no sweep"),
    ([*SEARCH, "objective.figure=mass", "hydra.sweeper.n_trials=0.5"], "n_trials"),
])  # fmt: skip
def test_impossible_search_is_one_message_before_any_job(here, arguments, said):
    done = searched(here, *arguments)
    assert done.returncode == 2
    assert said in done.stderr
    assert "Traceback" not in done.stderr
    assert not (here / "outputs").exists()


def request(*spaces):
    swept = [
        SimpleNamespace(hydra=f"++k{place}=x", values=tuple(values), swept=True, for_hydra_itself=False)
        for place, values in enumerate(spaces)
    ]
    return SimpleNamespace(overrides=swept)


def test_values_and_corners_of_a_space_are_validated_once():
    spaces = corners(request(["1", "2", "3"], ["a", "b"]))
    pairs = [("1", "a"), ("1", "b"), ("2", "a"), ("3", "a"), ("3", "b")]
    assert sorted(spaces) == [[f"++k0={first}", f"++k1={second}"] for first, second in pairs]
    many = corners(request([str(number) for number in range(100_000)]))
    assert len(many) == MAX_VALUES
    assert {"++k0=0", "++k0=99999"} <= {override for (override,) in many}


numbers = st.integers(0, 4).map(float)


@given(
    st.lists(st.tuples(numbers, numbers), max_size=8),
    st.sampled_from([("minimize",) * 2, ("maximize", "minimize")]),
)
def test_best_jobs_are_those_that_no_other_beats(values, directions):
    trials = object.__new__(Trials)
    trials._directions = directions
    trials._objective = ObjectiveSection.model_validate({"figures": ["mass", "reach"]})
    trials.outcomes = [
        Outcome(number, "", 0, "", "", figures={"mass": a, "reach": b})
        for number, (a, b) in enumerate(values)
    ]
    signs = [1 if direction == "minimize" else -1 for direction in directions]
    costs = [tuple(sign * cost for sign, cost in zip(signs, pair, strict=True)) for pair in values]
    beaten = {
        trial
        for trial, other in itertools.permutations(range(len(costs)), 2)
        if costs[other] != costs[trial]
        and all(a <= b for a, b in zip(costs[other], costs[trial], strict=True))
    }
    assert {trial.number for trial in trials.best()} == set(range(len(costs))) - beaten
