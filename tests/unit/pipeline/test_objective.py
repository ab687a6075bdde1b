"""The objective of a robot: figures against closed forms, paths in robot.json, and functions of users."""

import contextlib
import json
import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from linkwright.pipeline.config.objective_section import ObjectiveSection
from linkwright.pipeline.errors import ConfigError
from linkwright.pipeline.objective import value
from linkwright.pipeline.objective.figures import number_at
from linkwright.pipeline.stages.context import ROBOT
from linkwright.stages.robot.check import Check, Table
from linkwright.stages.validate.torque_value import torque_value
from tests.support.command import called

G = 9.81
LIFT = "actuators={lift: motor}"


def inertial(mass, x=0.0):
    tensor = 'ixx="0.01" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.01"'
    return f'<inertial><origin xyz="{x} 0 0"/><mass value="{mass}"/><inertia {tensor}/></inertial>'


ARM = f"""<robot name="arm"><link name="base">{inertial(2)}</link><link name="carriage">{inertial(3)}</link>
<link name="forearm">{inertial(0.5, 0.2)}</link>
<joint name="lift" type="prismatic"><parent link="base"/><child link="carriage"/><axis xyz="0 0 1"/>
<limit lower="0" upper="0.3" effort="70" velocity="1"/></joint>
<joint name="swing" type="revolute"><parent link="carriage"/><child link="forearm"/><origin xyz="0.4 0 0"/>
<axis xyz="0 0 1"/><limit lower="-1" upper="1" effort="5" velocity="2"/></joint></robot>"""


@pytest.fixture
def here(tmp_path):
    (tmp_path / "arm.urdf").write_text(ARM)
    return tmp_path


def objective(here, *arguments, until="graph"):
    built = called(here, "source=urdf", "source.path=arm.urdf", f"until={until}", *arguments)
    assert built.returncode in (0, 3), built.stderr
    folder = here / "outputs" / ("arm.graph" if until == "graph" else "arm")
    assert ">Objective<" in (folder / "report.html").read_text()
    return json.loads((folder / "report.json").read_text())["objective"]


def refused(here, *arguments):
    built = called(here, "source=urdf", "source.path=arm.urdf", "until=graph", *arguments)
    assert built.returncode in (1, 2), built.stdout
    assert "Traceback" not in built.stderr
    return built.stderr


def test_the_figures_are_those_of_closed_forms(here):
    names = "[mass,torque_margin,links.forearm.mass,mobility.dof]"
    figures = objective(here, f"objective.figures={names}", LIFT)
    # The lift carries the carriage and the forearm; the swing turns about the vertical.
    margin = pytest.approx(3.5 * G / 70, abs=1e-9)
    assert figures == {
        "mass": pytest.approx(5.5, abs=1e-12), "torque_margin": margin, "links.forearm.mass": 0.5,
        "mobility.dof": 2,
    }  # fmt: skip
    figures = objective(here, "objective.figure=torque_margin", LIFT, "validate.payload={forearm: 2}")
    assert figures["torque_margin"] == pytest.approx(5.5 * G / 70, abs=1e-9)


def test_the_reach_is_the_largest_distance_within_the_limits(here):
    """The reach is that of links, since the robot has no frame: the carriage's ends at 0.3 m, that of the
    forearm's origin at the hypotenuse; drawn poses come near to the ends and not beyond them."""
    figures = objective(here, "objective.figures=[reach,reach.carriage,reach.base]")
    assert figures["reach.base"] == 0.0
    assert 0.29 < figures["reach.carriage"] <= 0.3
    assert figures["reach"] == pytest.approx(math.hypot(0.4, figures["reach.carriage"]), abs=1e-9)


@pytest.mark.e2e
def test_objective_of_a_build_is_that_of_its_check(here):
    figures = "objective.figures=[torque_margin,checks_failed]"
    numbers = objective(here, figures, LIFT, "mesh=raw", "page.preview=none", until="validate")
    checks = json.loads((here / "outputs" / "arm" / "report.json").read_text())["checks"]
    (share,) = [check["value"] for check in checks if check["code"] == "C-TORQUE"]
    failed = [check for check in checks if check["level"] == "error" and not check["passed"]]
    assert numbers == {"torque_margin": share, "checks_failed": len(failed)}
    early = objective(here, "objective.figure=torque_margin", LIFT)
    assert early["torque_margin"] == pytest.approx(share, abs=1e-9)


def test_trusted_function_is_called_once(here, monkeypatch):
    monkeypatch.syspath_prepend(str(here))
    (here / "cost_a.py").write_text(
        "def both(robot, weight):\n"
        "    with open('calls', 'a') as calls: calls.write('.')\n"
        "    return weight * robot.mass, len(robot.dofs)\n"
    )
    function = ["objective={_target_: cost_a.both, args: {weight: 2}}", "plugins=[cost_a]"]
    for _ in range(2):
        assert objective(here, *function) == {"both.0": 11.0, "both.1": 2.0}
    assert (here / "calls").read_text() == "."
    assert "if you trust it" in refused(here, function[0])
    (here / "cost_b.py").write_text("def nothing(robot):\n    return []\n")
    message = refused(here, "objective={_target_: cost_b.nothing}", "plugins=[cost_b]")
    assert "cost_b.nothing failed: ValueError: it returned an empty list" in message


@pytest.mark.parametrize(("words", "said"), [
    (["objective.figure=mas"], "E-VALUE objective.figure: must be one of mass, reach, torque_margin"),
    (["objective.figure=mas"], "did you mean mass"),
    (["objective.figure=links.nolink.mass"], "links has base, carriage, forearm"),
    (["objective.figure=links.forarm.mass"], "did you mean forearm"),
    (["objective.figure=links.forearm"], "is not a number"),
    (["objective.figure=reach.tool"], "has no frame tool"),
    (["objective.figure=checks_failed"], "until=validate"),
    (["objective.failed=1"], "must have one of figure, figures and _target_"),
    (["objective={figures: [mass, reach], failed: [1, 2, 3]}"], "as many as there are figures"),
    (["objective={figure: mass, failed: nan}"], ".nan is not"),
    (["objective={figure: mass, args: {a: 1}}"], "args belong to a function"),
])  # fmt: skip
def test_what_cannot_be_an_objective_is_refused_by_name(here, words, said):
    message = refused(here, *words)
    assert said in message


def test_robot_without_force_limits_has_no_torque_margin(here):
    """The check of a whole build then has the value 0, which would be the best margin of all."""
    still = ARM.replace('"revolute"', '"fixed"').replace('"prismatic"', '"fixed"')
    (here / "arm.urdf").write_text(still)
    assert "no joint with a limited force" in refused(here, "objective.figure=torque_margin")
    row = ("lift", "N", 34.3, 34.3, None, None)
    unlimited = Check("arm: torque margin", True, "", 0.0, 1.0, "C-TORQUE", table=Table(("joint",), (row,)))
    limited = replace(unlimited, value=0.5, table=Table(("joint",), (row, (*row[:-1], 0.5))))
    assert [torque_value(checks) for checks in ([unlimited], [limited], [])] == [None, 0.5, None]


def test_objective_of_a_failure_may_be_infinite():
    for word in (math.inf, ".inf", [math.inf]):
        section = ObjectiveSection.model_validate({"figure": "mass", "failed": word})
        assert section.failed == (math.inf,)
        assert section.model_dump(mode="json")["failed"] == [math.inf]


names = st.text("ab.", min_size=1, max_size=4).filter(lambda name: name.strip(".") == name)
trees = st.recursive(
    st.floats(-9, 9), lambda inner: st.dictionaries(names, inner, min_size=1, max_size=3), max_leaves=6
)


def paths(tree, head=()):
    if isinstance(tree, float):
        return {".".join(head): {tree}} if head else {}
    places = {}
    for name, inner in tree.items():
        for path, values in paths(inner, (*head, name)).items():
            places.setdefault(path, set()).update(values)
    return places


@given(trees)
def test_numbers_of_a_tree_have_paths_despite_dots(tree):
    for path, values in paths(tree).items():
        # Of two readings of a path the longest name is taken at each step, which may lead nowhere.
        with contextlib.suppress(ConfigError):
            assert number_at({"t": tree}, f"t.{path}") in values


def test_lists_go_by_name_and_by_place():
    tree = {"links": [{"name": "a.b", "mass": 2, "com": [0.0, 7.0]}, {"name": "c", "mass": 3}]}
    assert number_at(tree, "links.a.b.mass") == 2
    assert number_at(tree, "links.1.mass") == 3
    assert number_at(tree, "links.a.b.com.1") == 7
    with pytest.raises(ConfigError, match=r"no links\.d"):
        number_at(tree, "links.d.mass")
    assert np.isfinite(number_at(tree, "links.0.mass"))


def test_results_of_a_function_are_those_of_this_version(monkeypatch):
    libraries_of_memos = []

    def memo(stage, version, libraries):
        libraries_of_memos.append(libraries)
        return lambda kind, key, make: b'{"light": 1.0}'

    monkeypatch.setattr(value.loader, "sources_digest", lambda plugins: "text")
    plan = SimpleNamespace(plugins=["my_objectives"])
    files = {"graph": SimpleNamespace(digests={ROBOT: "digest"})}
    context = SimpleNamespace(plan=plan, cache=SimpleNamespace(memo=memo), files=files)
    section = SimpleNamespace(target="my_objectives.light", args={})
    assert value._user_numbers(context, section) == {"light": 1.0}
    assert {"linkwright", "numpy"} <= libraries_of_memos[0].keys()
