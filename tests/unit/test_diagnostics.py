"""The table of diagnostics says everything that the product can say, and nothing else."""

import ast
import re

import numpy as np
import pytest

from linkwright.stages.formats.urdf.diagnostics import HINTS
from linkwright.stages.graph.mechanism import Mechanism, RelationSpec, RigidBody
from linkwright.stages.graph.passes.relation_dofs import dof_relations
from linkwright.stages.graph.section import GraphSections
from linkwright.stages.graph.tree import spanning_tree
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.errors import Disconnected
from linkwright.stages.robot.model.robot import Provenance
from tests.support.places import PROJECT
from tests.support.robots import joint, robot_with

CODE = re.compile(r"""["']([EWI]-[A-Z][A-Z0-9-]*)["']""")
CHECK = re.compile(r"""["'](C-[A-Z][A-Z0-9-]*)["']""")
ROW = re.compile(r"^\| `([EWIC]-[A-Z0-9-]+)` \| (.+?) \| (.+?) \| (.+?) \|$")
MAKERS = ("tell", "report", "report_unmatched", "Diagnostic", "Loss")


def spoken():
    """Every code in the source, and the top-level packages and stages that say it."""
    codes = {}
    for package in ("pipeline", "stages"):
        for file in sorted((PROJECT / package).rglob("*.py")):
            parts = file.relative_to(PROJECT).parts
            place = parts[1] if parts[0] == "stages" else parts[0]
            for code in CODE.findall(file.read_text()):
                codes.setdefault(code, set()).add(place)
    return codes


def written(file="DIAGNOSTICS.md"):
    lines = (PROJECT / "stages" / file).read_text().splitlines()
    return [match.groups() for line in lines if (match := ROW.match(line))]


def diagnostics_of(source):
    """Line, code, and the arguments (message, where, hint) of each diagnostic that a module makes."""
    tree = ast.parse(source)
    named = {
        target.id: statement.value
        for statement in tree.body
        if isinstance(statement, ast.Assign)
        for target in statement.targets
        if isinstance(target, ast.Name)
    }
    for call in ast.walk(tree):
        if not isinstance(call, ast.Call) or not call.args:
            continue
        maker = call.func.attr if isinstance(call.func, ast.Attribute) else getattr(call.func, "id", "")
        code = call.args[0]
        code = named.get(code.id, code) if isinstance(code, ast.Name) else code
        arguments = [*call.args[1:], *(keyword.value for keyword in call.keywords)]
        for word in code.values if isinstance(code, ast.Dict) else [code]:
            if maker in MAKERS and isinstance(word, ast.Constant) and CODE.fullmatch(repr(word.value)):
                yield call.lineno, word.value, arguments


def is_blank(value):
    return isinstance(value, ast.Constant) and not value.value


def incomplete(source, arguments=3):
    """Line and code of each error or warning that lacks a message, a place or a hint."""
    return [
        (line, code)
        for line, code, values in diagnostics_of(source)
        if code[0] in "EW" and (len(values) < arguments or any(map(is_blank, values)))
    ]


def test_table_is_complete_in_order_and_linked_in_the_readme():
    codes = [code for code, *_ in written()]
    assert codes == sorted(spoken(), key=lambda code: ("EWI".index(code[0]), code))
    assert "stages/DIAGNOSTICS.md" in (PROJECT / "README.md").read_text()


def test_table_of_checks_is_complete_and_in_order():
    files = [file for name in ("pipeline", "stages") for file in (PROJECT / name).rglob("*.py")]
    codes = [code for code, *_ in written("CHECKS.md")]
    assert codes == sorted({code for file in files for code in CHECK.findall(file.read_text())})
    for code, level, meaning, hint in written("CHECKS.md"):
        assert {*level.split(", ")} <= {"error", "warning"}, code
        assert len(meaning) > 15, code
        assert len(hint) > 5, code
    assert "stages/CHECKS.md" in (PROJECT / "README.md").read_text()


def test_row_says_its_place_its_meaning_and_what_to_do():
    said = spoken()
    for code, place, meaning, remedy in written():
        # The sink of diagnostics and the targets report for the stages that the row names.
        assert set(place.split(", ")) == said[code] or said[code] <= {"robot", "targets"}, code
        assert len(meaning) > 15, code
        assert len(remedy) > 5 or remedy == "–", code


def test_every_error_and_warning_has_a_place_and_a_hint():
    lacking, seen = [], set()
    for file in sorted((PROJECT / "stages").rglob("*.py")):
        source = file.read_text()
        seen |= {code for _, code, _ in diagnostics_of(source)}
        # Of what a URDF says wrong, one table has the hints of those that have none of their own.
        hints = HINTS if file.is_relative_to(PROJECT / "stages/formats/urdf") else {}
        rows = incomplete(source, 3)
        lacking += [(file.relative_to(PROJECT), *row) for row in rows if row[1] not in hints]
    assert lacking == []
    assert seen == {code for code, places in spoken().items() if places != {"pipeline"}}


def test_what_lacks_a_place_or_a_hint_is_found():
    source = [
        'RIGID = "W-A"',
        "log.report(RIGID, m, w)",
        'Diagnostic("E-B", m, "", h)',
        'Diagnostic("E-C", m, w, hint="")',
    ]
    assert incomplete("\n".join(source)) == [(2, "W-A"), (3, "E-B"), (4, "E-C")]
    assert incomplete('log.report("I-D", m)\nlog.report("E-E", m, w, h)\n') == []


@pytest.mark.parametrize(("kind", "place"), [("GEAR", "in Onshape"), ("MIMIC", "in the file")])
def test_relation_is_corrected_where_it_was_said(kind, place):
    log = Diagnostics()
    robot = robot_with([joint("revolute", "base", "arm", [0.0], name="r1")])
    dof_relations(robot, [RelationSpec("Gear", kind, ("r1", "gone"), 1.0, 0.0, False)], log)
    (only,) = log.notes
    assert only.code == "W-RELATION"
    assert [where for where in ("in Onshape", "in the file") if where in only.hint] == [place]


def loose(has_saved_pose):
    """The diagnostics on two links that nothing joins, however `root.disconnected` settles it."""
    bodies = tuple(RigidBody(name, (name,), (), frozenset({name}), "", np.eye(4)) for name in ("a", "b"))
    drawn = Mechanism(bodies, (), (), (), Provenance("", "", "", ""), root=0, has_saved_pose=has_saved_pose)
    with pytest.raises(Disconnected) as caught:
        spanning_tree(drawn, GraphSections(), Diagnostics())
    log = Diagnostics()
    for how in ("weld", "drop", "separate"):
        spanning_tree(drawn, GraphSections.model_validate({"root": {"disconnected": how}}), log)
    return [*caught.value.problems, *log.notes]


def test_what_hangs_on_nothing_is_corrected_where_it_was_drawn():
    for has_saved_pose, place in ((True, "in Onshape"), (False, "in the file")):
        diagnostics = loose(has_saved_pose)
        assert [problem.code for problem in diagnostics] == ["E-LOOSE", *["I-LOOSE"] * 3]
        assert all(place in problem.hint for problem in diagnostics)
    assert diagnostics[0].message == "1 link is not connected to the root"
    assert diagnostics[0].where == "b"
