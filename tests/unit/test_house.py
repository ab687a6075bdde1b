"""The plan of the house: no circle of imports, no room that imports its sibling, nothing too long."""

import ast
import re
from collections import defaultdict
from functools import cache
from pathlib import Path

import networkx as nx
import pytest

from tests.support import floors
from tests.support.imports import imports, modules, name_of
from tests.support.places import PROJECT

LINES = 315
"""A module has about 300 lines at most."""

FUNCTION_LINES = 60
FLAT = 16
"""Modules that lie side by side in a room."""

LISTED = 6
"""A face of more modules lists them."""

VARIANT = {"source.py", "reader.py", "writer.py"}
"""Modules of which a source, a reader of sources, and a format have one."""

PARAMETERS = 8

LATE = 100
"""Imports inside functions, which a reader expects at the top. This number may only fall: what few runs need,
and is slow to import, is imported late."""

SPEAKS_REST = ("/assemblies/", "/partstudios/", "tessellatedfaces", "massproperties", "/api/v")
"""What only a client of Onshape's REST API writes."""


@cache
def parsed(path):
    return ast.parse(path.read_text())


@cache
def texts(path):
    """The strings of a module that are no documentation."""
    nodes = list(ast.walk(parsed(path)))
    documentation = {id(node.value) for node in nodes if isinstance(node, ast.Expr)}
    constants = [node for node in nodes if isinstance(node, ast.Constant) and id(node) not in documentation]
    return [node.value for node in constants if isinstance(node.value, str)]


def room_of(name):
    """The room of a stage that a module lies in: `stages/graph/urdf`; of others, nothing."""
    parts = name.split(".")
    inside = parts[0] == "stages" and len(parts) > 3
    return "/".join(parts[:3]) if inside else ""


def test_no_modules_import_each_other_in_a_circle():
    """A face may hand its work to the modules of its own room, which know its table and its version."""
    graph = imports().copy()
    graph.remove_edges_from([(face, module) for face, module in graph.edges if module.startswith(f"{face}.")])
    assert [
        sorted(component) for component in nx.strongly_connected_components(graph) if len(component) > 1
    ] == []


def test_no_variant_of_a_stage_imports_its_sibling():
    problems = []
    for importer, target in imports().edges:
        rooms = room_of(importer), room_of(target)
        stages = {room.rpartition("/")[0] for room in rooms}
        variants = all(any((PROJECT / room / file).is_file() for file in VARIANT) for room in rooms)
        if all(rooms) and len(stages) == 1 and variants and rooms[0] != rooms[1]:
            problems.append(f"{importer} imports {target}")
    assert sorted(problems) == []


def rooms():
    """Every room of the product, and the modules in it beside its face."""
    modules_of = defaultdict(list)
    for path in modules():
        if path.name != "__init__.py":
            modules_of[path.parent].append(path)
    return modules_of


def test_no_room_has_more_modules_than_can_be_seen_at_once():
    counts = {room.relative_to(PROJECT).as_posix(): len(inside) for room, inside in rooms().items()}
    assert {room: count for room, count in counts.items() if count > FLAT} == {}


def test_face_of_a_large_room_lists_its_modules():
    missing = {}
    for room, inside in rooms().items():
        text = (room / "__init__.py").read_text(encoding="utf-8")
        if len(inside) > LISTED:
            missing[room.name] = [path.stem for path in inside if f"\n- {path.stem}: " not in text]
    assert {room: names for room, names in missing.items() if names} == {}


def test_rooms_side_by_side_import_each_other_one_way():
    """A room may use its neighbour, but not be used by it too; what lies flat beside them is free."""
    faces = {name_of(path) for path in modules() if path.name == "__init__.py"}
    between = defaultdict(nx.DiGraph)
    for importer, target in imports().edges:
        first, second = importer.split("."), target.split(".")
        depth = next((n for n, pair in enumerate(zip(first, second)) if pair[0] != pair[1]), None)
        if depth:
            sides = ".".join(first[: depth + 1]), ".".join(second[: depth + 1])
            if faces.issuperset(sides):
                between[".".join(first[:depth])].add_edge(*sides)
    circles = [sorted(part) for graph in between.values() for part in nx.strongly_connected_components(graph)]
    assert [circle for circle in circles if len(circle) > 1] == []


def test_no_module_is_longer_than_can_be_read_at_once():
    lengths = {path.relative_to(PROJECT).as_posix(): len(path.read_text().splitlines()) for path in modules()}
    assert {name: lines for name, lines in lengths.items() if lines > LINES} == {}


@cache
def functions():
    """Every function of the product, with its name."""
    kinds = ast.FunctionDef | ast.AsyncFunctionDef
    trees = {name_of(path): parsed(path) for path in modules()}
    return [
        (f"{name}.{node.name}", node)
        for name, tree in trees.items()
        for node in ast.walk(tree)
        if isinstance(node, kinds)
    ]


def test_function_fits_a_screen_and_has_few_parameters():
    problems = {}
    for name, node in functions():
        lines, spec = node.end_lineno - node.lineno + 1, node.args
        named = [*spec.posonlyargs, *spec.args, *spec.kwonlyargs, spec.vararg, spec.kwarg]
        parameters = len([argument for argument in named if argument is not None])
        if lines > FUNCTION_LINES or parameters > PARAMETERS:
            problems[name] = lines, parameters
    assert problems == {}


@cache
def late_imports(path):
    """The lines of a module's imports inside functions."""
    functions = [n for n in ast.walk(parsed(path)) if isinstance(n, ast.FunctionDef | ast.AsyncFunctionDef)]
    inside = {id(node): node for function in functions for node in ast.walk(function)}
    return [node.lineno for node in inside.values() if isinstance(node, ast.Import | ast.ImportFrom)]


def test_no_more_imports_stand_inside_of_functions():
    assert sum(len(late_imports(path)) for path in modules()) <= LATE


def test_each_import_inside_of_a_function_has_a_reason():
    """A comment on its line, or above it and the imports beside it."""
    bare = []
    for path in modules():
        lines = path.read_text().splitlines()
        for number in late_imports(path):
            above = number - 1
            while lines[above - 1].strip().startswith(("from ", "import ")) or not lines[above - 1].strip():
                above -= 1
            if "#" not in lines[number - 1] and not lines[above - 1].strip().startswith("#"):
                bare.append(f"{name_of(path)}:{number}")
    assert bare == []


def test_no_module_is_imported_by_a_name_that_is_put_together():
    problems = [
        f"{name_of(path)}:{node.lineno}"
        for path in modules()
        for node in ast.walk(parsed(path))
        if isinstance(node, ast.Call)
        and "import_module" in ast.unparse(node.func)
        and any(isinstance(argument, ast.JoinedStr | ast.BinOp) for argument in node.args)
    ]
    assert problems == []


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


def test_picture_of_the_floors_is_that_of_the_imports():
    assert floors.PICTURE.read_text(encoding="utf-8") == floors.picture(), "python -m tests.support.floors"


def test_every_place_that_the_documents_name_is_there():
    for document in (PROJECT / "README.md", *(PROJECT / "docs").rglob("*.md")):
        text = document.read_text(encoding="utf-8")
        places = re.findall(r"`((?:conf|pipeline|stages|tests)/[\w./]*)`", text)
        assert [place for place in places if not (PROJECT / place).exists()] == [], document
