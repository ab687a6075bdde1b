"""The imports of the product: which module imports which, wherever in it."""

import ast
from functools import cache

import networkx as nx

from tests.support.places import PROJECT, ROOMS


def modules():
    return sorted(path for top in ROOMS for path in (PROJECT / top).rglob("*.py"))


class _WithoutTypes(ast.NodeTransformer):
    """Leaves out what only type checkers read."""

    def visit_If(self, node):
        if isinstance(node.test, ast.Name) and node.test.id == "TYPE_CHECKING":
            return ast.Pass()
        return self.generic_visit(node)


def imported(path, source, types=True):
    """The full names that a module imports, wherever in it, also by `import_module`; those under
    `if TYPE_CHECKING` too where `types` is true."""
    package = ("linkwright", *path.relative_to(PROJECT).parts[:-1])
    tree = ast.parse(source)
    for node in ast.walk(tree if types else _WithoutTypes().visit(tree)):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            above = package[: len(package) - node.level + 1] if node.level else ()
            base = ".".join([*above, *([node.module] if node.module else [])])
            yield from (f"{base}.{alias.name}" for alias in node.names)
        elif isinstance(node, ast.Call) and node.args and isinstance(node.args[0], ast.Constant):
            called = node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", "")
            if called in ("import_module", "__import__"):
                yield str(node.args[0].value)


def name_of(path):
    parts = path.relative_to(PROJECT).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


@cache
def imports():
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
