"""`python -m tests.benchmarks.size`: lines of the product's code, without docstrings, comments and blanks."""

import ast
import io
import tokenize
from collections import Counter

from tests.support.places import PROJECT, ROOMS

GOAL = 48_000

LAYOUT = {
    tokenize.COMMENT, tokenize.NL, tokenize.NEWLINE, tokenize.INDENT, tokenize.DEDENT, tokenize.ENDMARKER,
}  # fmt: skip


def code_lines(text):
    """The number of lines with code."""
    documented: set[int] = set()
    for node in ast.walk(ast.parse(text)):
        for child in getattr(node, "body", ()) if not isinstance(node, ast.Lambda | ast.IfExp) else ():
            if isinstance(child, ast.Expr) and isinstance(child.value, ast.Constant):
                documented.update(range(child.lineno, (child.end_lineno or child.lineno) + 1))
    lines: set[int] = set()
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        if token.type not in LAYOUT:
            lines.update(range(token.start[0], token.end[0] + 1))
    return len(lines - documented)


def room(path):
    parts = path.relative_to(PROJECT).parts[:-1]
    return "/".join(parts[:3])


def main():
    rooms: Counter[str] = Counter()
    for top in ROOMS:
        for path in sorted((PROJECT / top).rglob("*.py")):
            rooms[room(path)] += code_lines(path.read_text(encoding="utf-8"))
    for name, lines in sorted(rooms.items()):
        print(f"{lines:7,}  {name}")
    print(f"{rooms.total():7,}  in all; the goal is {GOAL:,}")


if __name__ == "__main__":
    main()
