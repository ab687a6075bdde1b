"""The plan of the house: no circle of imports, no room that imports its sibling, nothing too long."""

import ast
from collections import defaultdict
from functools import cache
from itertools import combinations
from pathlib import Path

import networkx as nx
import pytest

from tests.support.places import PROJECT
from tests.unit.test_import_walls import imported, modules

LINES = 315
"""A module has about 300 lines at most."""

FUNCTION_LINES = 60
PARAMETERS = 8

SPEAKS_REST = ("/assemblies/", "/partstudios/", "tessellatedfaces", "massproperties", "/api/v")
"""What only a client of Onshape's REST API writes."""


@cache
def parsed(path: Path) -> ast.Module:
    return ast.parse(path.read_text())


def name_of(path: Path) -> str:
    parts = path.relative_to(PROJECT).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


@cache
def texts(path: Path) -> list[str]:
    """The strings of a module that are no documentation."""
    nodes = list(ast.walk(parsed(path)))
    documentation = {id(node.value) for node in nodes if isinstance(node, ast.Expr)}
    constants = [node for node in nodes if isinstance(node, ast.Constant) and id(node) not in documentation]
    return [node.value for node in constants if isinstance(node.value, str)]


@cache
def imports() -> nx.DiGraph:
    """Every module of the product and the modules of ours that it imports, wherever in it."""
    ours = {name_of(path): path for path in modules()}
    graph = nx.DiGraph()
    for name, path in ours.items():
        for found in imported(path, path.read_text()):
            found = found.removeprefix("linkwright.")
            target = found if found in ours else found.rpartition(".")[0]
            if target in ours and target != name:
                graph.add_edge(name, target)
    return graph


def room_of(name: str) -> str:
    """The room of a stage that a module lies in: `stages/graph/urdf`; of others, nothing."""
    parts = name.split(".")
    inside = parts[0] == "stages" and len(parts) > 3
    return "/".join(parts[:3]) if inside else ""


def test_no_modules_import_each_other_in_a_circle():
    """A face may hand its work to the modules of its own room, which know its table and its version."""
    graph = imports().copy()
    graph.remove_edges_from([(face, module) for face, module in graph.edges if module.startswith(f"{face}.")])
    assert [sorted(one) for one in nx.strongly_connected_components(graph) if len(one) > 1] == []


FLOORS = ("checks", "read", "usd", "sdf", "same")
"""Rooms of `stages/validate` of which each may import those after it."""


def test_no_room_of_a_stage_imports_its_sibling():
    """But for the floors of validate: checks use readers, and these what compares."""
    below = {
        (f"stages/validate/{upper}", f"stages/validate/{lower}") for upper, lower in combinations(FLOORS, 2)
    }
    found = []
    for importer, target in imports().edges:
        rooms = room_of(importer), room_of(target)
        stages = {room.rpartition("/")[0] for room in rooms}
        if all(rooms) and len(stages) == 1 and rooms[0] != rooms[1] and rooms not in below:
            found.append(f"{importer} imports {target}")
    assert sorted(found) == []


def test_no_module_is_longer_than_can_be_read_at_once():
    lengths = {path.relative_to(PROJECT).as_posix(): len(path.read_text().splitlines()) for path in modules()}
    assert {name: lines for name, lines in lengths.items() if lines > LINES} == {}


def test_no_function_is_longer_than_a_screen():
    found = {
        f"{name_of(path)}.{node.name}": node.end_lineno - node.lineno + 1
        for path in modules()
        for node in ast.walk(parsed(path))
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef)
        and node.end_lineno - node.lineno + 1 > FUNCTION_LINES
    }
    assert found == {}


def test_no_function_has_more_parameters_than_can_be_told_apart():
    found = {}
    for path in modules():
        for node in ast.walk(parsed(path)):
            if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
                given = node.args
                every = [*given.posonlyargs, *given.args, *given.kwonlyargs, given.vararg, given.kwarg]
                found[f"{name_of(path)}.{node.name}"] = len([one for one in every if one is not None])
    assert {name: number for name, number in found.items() if number > PARAMETERS} == {}


def test_no_two_classes_have_one_name():
    places = defaultdict(list)
    # The public face has its users' words: `linkwright.Robot` wraps the robot that the stages hand on.
    for path in (path for path in modules() if not path.is_relative_to(PROJECT / "pipeline" / "api")):
        for node in ast.walk(parsed(path)):
            if isinstance(node, ast.ClassDef):
                places[node.name].append(name_of(path))
    assert {name: where for name, where in places.items() if len(where) > 1} == {}


@pytest.mark.parametrize("words", SPEAKS_REST)
def test_only_the_room_of_onshape_knows_its_rest_api(words):
    room = PROJECT / "stages" / "fetch" / "onshape"
    speakers = [name_of(path) for path in modules() if any(words in text for text in texts(path))]
    assert [name for name in speakers if not (PROJECT / Path(*name.split("."))).is_relative_to(room)] == []


@pytest.mark.parametrize(
    ("question", "answer"),
    [
        ("where mates become joints", "stages/graph/onshape/mates/joints.py"),
        ("where HTTP is spoken", "stages/fetch/onshape/api/transport.py"),
        ("where a URDF is parsed", "stages/formats/urdf/parse.py"),
        ("where loops are closed in MJCF", "stages/export/mjcf/loops.py"),
        ("where a collider is chosen", "stages/mesh/colliders/__init__.py"),
        ("where a check is defined", "stages/validate/checks/__init__.py"),
    ],
)
def test_a_name_answers_what_a_stranger_asks(question, answer):
    assert (PROJECT / answer).is_file(), question
