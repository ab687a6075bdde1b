"""Reads the facts of a Python module, which is parsed and never run: constants, and statements of functions.

Docstrings, comments, quotes, and the order of imports are not facts.
"""

import ast
from collections.abc import Iterator

from linkwright.stages.validate.findings import named
from linkwright.stages.validate.rewritten.facts import Place, Unparsable, Value


def python_facts(data: bytes) -> Iterator[tuple[Place, Value]]:
    """Yields the facts of a module; raises Unparsable."""
    try:
        module = ast.parse(data)
    except (SyntaxError, ValueError) as error:
        line_text = f", line {error.lineno}" if isinstance(error, SyntaxError) else ""
        raise Unparsable(f"is not Python: {error.args[0]}{line_text}") from None
    yield from _body(module.body, (), "module")


def _body(body: list[ast.stmt], path: tuple[str, ...], element: str) -> Iterator[tuple[Place, Value]]:
    number = 0
    for statement in body:
        if isinstance(statement, ast.Expr) and isinstance(statement.value, ast.Constant):
            continue  # a docstring of the module, of a function or of a constant
        if isinstance(statement, ast.FunctionDef | ast.ClassDef):
            yield from _definition(statement, path)
        elif not path and isinstance(statement, ast.Assign):
            (name, *_) = map(ast.unparse, statement.targets)
            yield from _constant(statement.value, (name,), named("constant", name))
        elif isinstance(statement, ast.Import | ast.ImportFrom):
            text = ast.unparse(statement)
            yield Place((*path, text), element, text), True
        else:
            number += 1
            yield Place((*path, str(number)), element, f"statement {number}"), ast.unparse(statement)


def _definition(
    statement: ast.FunctionDef | ast.ClassDef, path: tuple[str, ...]
) -> Iterator[tuple[Place, Value]]:
    inner_path, element = (*path, statement.name), named("def", statement.name)
    if isinstance(statement, ast.FunctionDef):
        yield Place((*inner_path, "()"), element, "arguments"), ast.unparse(statement.args)
    elif statement.bases:
        yield Place((*inner_path, "bases"), element, "bases"), tuple(map(ast.unparse, statement.bases))
    if statement.decorator_list:
        decorators = tuple(map(ast.unparse, statement.decorator_list))
        yield Place((*inner_path, "@"), element, "decorators"), decorators
    yield from _body(statement.body, inner_path, element)


def _constant(node: ast.expr, path: tuple[str, ...], element: str) -> Iterator[tuple[Place, Value]]:
    """Yields the entries of a dictionary by their keys, and a list of texts as a row. The order of `__all__`
    is not a fact."""
    attribute = " ".join(path[1:])
    if isinstance(node, ast.Dict):
        yield Place((*path, "{}"), element, attribute), True
        for key, value in zip(node.keys, node.values, strict=True):
            text = str(key.value) if isinstance(key, ast.Constant) else ast.unparse(key) if key else "**"
            yield from _constant(value, (*path, text), element)
    elif isinstance(node, ast.List | ast.Tuple):
        row = tuple(str(_constant_value(entry)) for entry in node.elts)
        yield Place(path, element, attribute), tuple(sorted(row)) if path == ("__all__",) else row
    else:
        # Positions, in metres and radians.
        yield Place(path, element, attribute, 1.0), _constant_value(node)


def _constant_value(node: ast.expr) -> Value:
    try:
        value = ast.literal_eval(node)
    except (ValueError, TypeError):
        value = ()  # not a constant, or a set of what cannot be in a set
    return value if isinstance(value, str | float | int | bool | None) else f"`{ast.unparse(node)}`"
