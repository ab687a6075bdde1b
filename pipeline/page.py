"""report.html: a build for people, one file that needs nothing else."""

import json
import re
from collections.abc import Iterable, Mapping, Sequence
from html import escape, unescape
from typing import Any

from pipeline.report import Report
from pipeline.secrets import Secrets
from stages.graph.view.views import PICTURE, TABLES
from stages.robot.printable import printable_lines

STYLE = """
:root { color-scheme: light dark; --ink: #1b1f24; --soft: #57606a; --line: #d0d7de; --paper: #fff;
  --panel: #f6f8fa; --good: #15803d; --warn: #a16207; --bad: #b91c1c; }
@media (prefers-color-scheme: dark) { :root { --ink: #e6edf3; --soft: #9198a1; --line: #3d444d;
  --paper: #0d1117; --panel: #161b22; --good: #4ade80; --warn: #facc15; --bad: #f87171; } }
body { font: 15px/1.5 system-ui, sans-serif; color: var(--ink); background: var(--paper);
  max-width: 76rem; margin: 0 auto; padding: 1.5rem; }
p { white-space: pre-line; }
h1 { margin: 0; font-size: 1.6rem; } h2 { margin: 2rem 0 .5rem; font-size: 1.15rem; }
table { border-collapse: collapse; font-size: .87rem; } .wide { overflow-x: auto; }
th, td { text-align: left; vertical-align: top; padding: .25rem .75rem .25rem 0;
  border-bottom: 1px solid var(--line); overflow-wrap: anywhere; }
th { color: var(--soft); font-weight: 600; white-space: nowrap; } td.code { white-space: nowrap; }
pre { background: var(--panel); padding: 1rem; overflow-x: auto; font-size: .8rem; line-height: 1.3; }
.soft { color: var(--soft); } .built, .passed { color: var(--good); }
.invalid, .warning { color: var(--warn); } .failed, .error { color: var(--bad); }
.picture { border: 1px solid var(--line); background: #fff; overflow: auto; max-height: 90vh; }
.picture svg { display: block; }
@media print { body { max-width: none; padding: 0; font-size: 10pt; } tr { break-inside: avoid; }
  .picture { max-height: none; border: 0; } .picture svg { width: 100%; height: auto; }
  .wide, pre { overflow: visible; } pre { padding: 0; font-size: 7pt; } }
"""

LEVELS = {"error": "Errors", "warning": "Warnings", "info": "For information"}


def page(report: Report, shown: Mapping[str, str], sizes: Mapping[str, int], secrets: Secrets) -> bytes:
    """The page, with secrets blanked. `shown`: files of the graph stage by name, none where a build
    did not come so far; `sizes` [bytes] of the outputs."""
    tree: dict[str, Any] = secrets.within(report.tree())
    tables = secrets.within(json.loads(shown.get(TABLES, "[]")))
    picture = _blanked(shown.get(PICTURE, ""), secrets)
    sections = [
        _head(tree),
        _error(tree["error"]),
        _diagnostics(tree["diagnostics"]),
        _checks(tree["checks"]),
        _section("Kinematic graph", f'<div class="picture">{picture}</div>' if picture else ""),
        _section("Outline", _preformatted(tree["outline"])),
        *(_section(escape(one["title"]), _table(one["header"], one["rows"])) for one in tables),
        _section("Figures", _pairs(tree["figures"])),
        _section("Stages", _stages(tree["stages"])),
        _section("API calls", _pairs(tree["calls"])),
        _section("Source", _pairs({**tree["source"], **tree["bundle"]})),
        _section("Outputs", _outputs(tree["outputs"], sizes)),
        _section("Versions", _pairs(tree["versions"])),
    ]
    body = "\n".join(section for section in sections if section)
    return (
        '<!doctype html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>{_text(tree['name'])}: {_text(tree['status'])}</title>\n<style>{STYLE}</style>\n"
        f"</head>\n<body>\n{body}\n</body>\n</html>\n"
    ).encode()


def _text(value: Any) -> str:
    """A value as people read it, escaped."""
    if value is None:
        return ""
    if isinstance(value, Mapping):
        return ", ".join(f"{_text(key)}: {_text(item)}" for key, item in value.items())
    text = f"{value:.6g}" if isinstance(value, float) else str(value)
    return escape(printable_lines(text))


def _blanked(svg: str, secrets: Secrets) -> str:
    """The picture without its XML declaration; what it says is blanked, what it is made of is not."""
    bare = re.sub(r"^<\?xml.*?\?>\s*", "", svg)
    return re.sub(r">([^<]+)<", lambda said: f">{escape(secrets.blanked(unescape(said[1])))}<", bare)


def _section(title: str, body: str) -> str:
    return f"<section>\n<h2>{title}</h2>\n{body}\n</section>" if body else ""


def _table(header: Iterable[str], rows: Sequence[Sequence[Any]]) -> str:
    """A table of plain values; columns without any value are left out, and a table without rows."""
    if not rows:
        return ""
    names = list(header)
    kept = [column for column in range(len(names)) if any(row[column] not in ("", None) for row in rows)]
    head = "".join(f"<th>{_text(names[column])}</th>" for column in kept)
    lines = ["<tr>" + "".join(f"<td>{_text(row[column])}</td>" for column in kept) + "</tr>" for row in rows]
    return '<div class="wide"><table>\n<tr>' + head + "</tr>\n" + "\n".join(lines) + "\n</table></div>"


def _pairs(values: Mapping[str, Any]) -> str:
    rows = [f"<tr><th>{_text(key)}</th><td>{_text(value)}</td></tr>" for key, value in values.items()]
    return "<table>\n" + "\n".join(rows) + "\n</table>" if rows else ""


def _preformatted(lines: Sequence[str]) -> str:
    text = "\n".join(lines)
    return f"<pre>{_text(text)}</pre>" if text else ""


def _head(tree: Mapping[str, Any]) -> str:
    seconds = sum(stage["seconds"] for stage in tree["stages"])
    told = f"exit status {tree['exit_status']}, {seconds:.2f} s, {tree['folder']}"
    status = f'<span class="{_text(tree["status"])}">{_text(tree["status"])}</span>'
    return f'<h1>{_text(tree["name"])}: {status}</h1>\n<p class="soft">{_text(told)}</p>'


def _error(error: Mapping[str, Any] | None) -> str:
    """What ended a failed build, with all that is to be settled."""
    if error is None:
        return ""
    place = f"{_text(error['where'])}: " if error.get("where") else ""
    hint = f"<p>→ {_text(error['hint'])}</p>" if error.get("hint") else ""
    message = f'<p class="error">{place}{_text(error["message"])}</p>'
    return _section(_text(error["type"]), message + hint + _found(error.get("problems", [])))


def _diagnostics(found: Sequence[Mapping[str, Any]]) -> str:
    """The findings, the gravest first."""
    groups = {level: [one for one in found if _level(one) == level] for level in LEVELS}
    return "\n".join(_section(LEVELS[level], _found(group)) for level, group in groups.items() if group)


def _level(diagnostic: Mapping[str, Any]) -> str:
    return {"E": "error", "W": "warning"}.get(diagnostic["code"][:1], "info")


def _found(problems: Sequence[Mapping[str, Any]]) -> str:
    lines = [
        f'<tr><td class="code {_level(one)}">{_text(one["code"])}</td><td>{_text(one["where"])}</td>'
        f"<td>{_text(one['message'])}{_hint(one['hint'])}</td></tr>"
        for one in problems
    ]
    return '<div class="wide"><table>\n' + "\n".join(lines) + "\n</table></div>" if lines else ""


def _hint(hint: str) -> str:
    return f'<br><span class="soft">→ {_text(hint)}</span>' if hint else ""


def _checks(checks: Sequence[Mapping[str, Any]]) -> str:
    """The checks, those that failed first."""
    if not checks:
        return ""
    lines = []
    for check in sorted(checks, key=lambda one: bool(one["passed"])):
        word = "passed" if check["passed"] else "failed"
        cells = "".join(f"<td>{_text(check[key])}</td>" for key in ("name", "detail", "value", "limit"))
        lines.append(f'<tr><td class="{word}">{word}</td>{cells}</tr>')
    passed = sum(bool(check["passed"]) for check in checks)
    head = "<tr><th></th><th>check</th><th>found</th><th>value</th><th>limit</th></tr>\n"
    table = '<div class="wide"><table>\n' + head + "\n".join(lines) + "\n</table></div>"
    return _section(f"Checks: {passed} of {len(checks)} passed", table)


def _stages(stages: Sequence[Mapping[str, Any]]) -> str:
    rows = [
        [one["name"], "cached" if one["cached"] else "built", f"{one['seconds']:.2f}", one["outputs"]]
        for one in stages
    ]
    return _table(["stage", "result", "seconds", "outputs"], rows)


def _outputs(digests: Mapping[str, str], sizes: Mapping[str, int]) -> str:
    rows = [[path, f"{sizes[path]:,}", digest] for path, digest in digests.items()]
    return _table(["file", "bytes", "SHA-256"], rows)
