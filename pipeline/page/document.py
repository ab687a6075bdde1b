"""report.html: a build for people, one file that needs nothing else."""

import json
import re
from collections.abc import Mapping, Sequence
from html import escape, unescape
from pathlib import Path
from typing import Any
from urllib.parse import quote

from pipeline.page.colliders import colliders
from pipeline.page.markup import (
    file_link,
    folded,
    link,
    name,
    pairs,
    plain_pairs,
    plain_table,
    section,
    table,
    text,
)
from pipeline.page.order import order
from pipeline.page.readers import readers
from pipeline.reference.codes import explanations
from pipeline.report import Report
from pipeline.secrets import Secrets
from stages.graph.view.views import PICTURE, TABLES
from stages.mesh.view.views import PICTURES
from stages.robot.globs import listed

STYLE = Path(__file__).with_name("style.css")

LEVELS = {"error": "Errors", "warning": "Warnings", "info": "For information"}

BESIDE = ("report.json", "config.yaml", "build.log")
"""The other documents of a build, in the same folder."""

ASSETS = "assets/"


def page(
    report: Report,
    shown: Mapping[str, str],
    sizes: Mapping[str, int],
    secrets: Secrets,
    *,
    pack: bytes | None = None,
    preview: str = "",
) -> bytes:
    """The page, with secrets blanked. `shown`: views of the stages by name, none where a build did not come
    so far; `sizes` [bytes] of the outputs; `pack`: what the view of the robot shows (see
    `pipeline.live.pack`), None for a page without the view; `preview`: the robot's picture, a file beside
    the page, "" without one."""
    tree: dict[str, Any] = secrets.within(report.tree())
    tables = secrets.within(json.loads(shown.get(TABLES, "[]")))
    sections = [
        _head(tree, secrets.blanked(report.heading)),
        _preview(preview, tree["name"]),
        _error(tree["error"]),
        _checks(tree["checks"]),
        _diagnostics(tree["diagnostics"]),
        section("Kinematic graph", _picture(shown.get(PICTURE, ""), secrets, PICTURE in tree["outputs"])),
        section("Outline", _preformatted(tree["outline"])),
        *(section(text(one["title"]), plain_table(one["header"], one["rows"])) for one in tables),
        colliders(tree["details"], shown.get(PICTURES, ""), secrets),
        _excludes(tree["details"].get("excludes", [])),
        order(tree["details"].get("order", {})),
        readers(tree["details"].get("readers", [])),
        _facts(tree),
        _outputs(tree["outputs"], sizes),
        _codes(tree),
    ]
    body = "\n".join(one for one in sections if one)
    return (
        '<!doctype html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>{text(tree['name'])}: {text(tree['status'])}</title>\n"
        f"<style>\n{STYLE.read_text(encoding='utf-8')}</style>\n"
        f"</head>\n<body>\n{body}\n</body>\n</html>\n"
    ).encode()


def _head(tree: Mapping[str, Any], heading: str) -> str:
    """What was built, how it went, and the files."""
    seconds = sum(stage["seconds"] for stage in tree["stages"])
    summary = f"exit status {tree['exit_status']}, {seconds:.2f} s, {tree['folder']}"
    status = f'<span class="{text(tree["status"])}">{text(tree["status"])}</span>'
    files = [path for path in tree["outputs"] if not path.startswith(ASSETS)]
    links = "\n".join(file_link(path) for path in [*files, *BESIDE])
    return (
        f'<header>\n<h1>{text(heading)}: {status}</h1>\n<p class="soft">{text(summary)}</p>\n'
        f"<nav>\n{links}\n</nav>\n</header>"
    )


def _preview(path: str, name: str) -> str:
    return f'<p><img class="preview" src="{quote(path)}" alt="{text(name)}"></p>' if path else ""


def _error(error: Mapping[str, Any] | None) -> str:
    """What ended a failed build, with all that is to be settled."""
    if error is None:
        return ""
    place = f"{text(error['where'])}: " if error.get("where") else ""
    message = f'<p class="error">{place}{text(error["message"])}</p>\n{_hint(error.get("hint", ""))}'
    return section(text(error["type"]), message + _found(error.get("problems", [])))


def _checks(checks: Sequence[Mapping[str, Any]]) -> str:
    """The checks that failed, those that warn, and those that passed, folded."""
    groups = {word: [check for check in checks if _outcome(check) == word] for word in OUTCOMES}
    passed = groups["passed"]
    words = f'<span class="passed">{len(passed)} passed</span>'
    open_tables = "".join(_check_table(groups[word]) for word in OUTCOMES if word != "passed")
    own = "".join(_own_table(check) for check in checks if check.get("table"))
    body = open_tables + folded(words, _check_table(passed)) + own
    return section(f"Checks: {len(passed)} of {len(checks)} passed", body) if checks else ""


def _own_table(check: Mapping[str, Any]) -> str:
    """What a check found beside what it does not accept."""
    title = check["name"].rpartition(": ")[2]
    rows = [["" if cell is None else cell for cell in row] for row in check["table"]["rows"]]
    summary = f"{title}: {check['detail']}".removeprefix(": ")
    return folded(text(summary), plain_table(check["table"]["header"], rows))


OUTCOMES = ("failed", "warning", "passed")
"""Of a check, the gravest first."""


def _outcome(check: Mapping[str, Any]) -> str:
    if check["passed"]:
        return "passed"
    return "failed" if check["level"] == "error" else "warning"


def _found_by(check: Mapping[str, Any]) -> str:
    """What a check measured, and the elements and attributes to look at."""
    lines = [
        f"{one['element']} {one['attribute']}".strip() + f": {one['message']}" for one in check["findings"]
    ]
    return text(check["detail"]) + "".join(f"<br>{text(line)}" for line in lines)


def _check_table(checks: Sequence[Mapping[str, Any]]) -> str:
    """A row for each check; files in which one comes to exactly the same share its row."""
    files: dict[tuple[Any, ...], list[str]] = {}
    for check in checks:
        file, _, title = check["name"].rpartition(": ")
        same = (_outcome(check), check["code"], title, _found_by(check), check["value"], check["limit"])
        files.setdefault(same, []).append(file)
    rows = []
    for (word, code, title, found, *figures), where in files.items():
        name = link(f"#{code}", title) if code in explanations() and word != "passed" else text(title)
        cells = [name, text(", ".join(filter(None, where))), found, *map(text, figures)]
        rows.append([f'<span class="{word}">{word}</span>', *cells])
    header = ["", "check", "of", "found", "value", "limit"]
    return table(header, rows, {"": "word", "value": "number", "limit": "number"})


def _diagnostics(found: Sequence[Mapping[str, Any]]) -> str:
    """The findings, the gravest first."""
    groups = {level: [one for one in found if _level(one) == level] for level in LEVELS}
    return "\n".join(section(LEVELS[level], _found(group)) for level, group in groups.items() if group)


def _level(diagnostic: Mapping[str, Any]) -> str:
    return {"E": "error", "W": "warning"}.get(diagnostic["code"][:1], "info")


def _found(problems: Sequence[Mapping[str, Any]]) -> str:
    rows = [[_code(one), name(one["where"]), text(one["message"]) + _hint(one["hint"])] for one in problems]
    return table(["", "where", "what"], rows, {"": "code"})


def _code(diagnostic: Mapping[str, Any]) -> str:
    """A code, which leads to what it means."""
    code = diagnostic["code"]
    words = link(f"#{code}", code) if code in explanations() else text(code)
    return f'<span class="{_level(diagnostic)}">{words}</span>'


def _hint(hint: str) -> str:
    return f'<span class="hint">→ {text(hint)}</span>' if hint else ""


def _picture(svg: str, secrets: Secrets, is_file: bool) -> str:
    """The picture without its XML declaration; what it says is blanked, what it is made of is not."""
    if not svg:
        return ""
    bare = re.sub(r"^<\?xml.*?\?>\s*", "", svg)
    drawn = re.sub(r">([^<]+)<", lambda match: f">{escape(secrets.blanked(unescape(match[1])))}<", bare)
    full = f'\n<p class="soft screen">in full: {file_link(PICTURE)}</p>' if is_file else ""
    return f'<div class="picture">{drawn}</div>{full}'


def _preformatted(lines: Sequence[str]) -> str:
    whole = "\n".join(lines)
    return f"<pre>{text(whole)}</pre>" if whole else ""


def _excludes(excludes: Sequence[Mapping[str, Any]]) -> str:
    """The pairs of links that do not collide, those whose reason is not a joint first, and which of their
    colliders where others do."""
    order = sorted(excludes, key=lambda one: str(one["reason"]) == "Adjacent")
    rows = [[*one["links"], one["reason"], f"{one['depth']:.2f}", _only(one["colliders"])] for one in order]
    header = ["link", "other link", "reason", "depth at home, mm", "of their colliders"]
    return section("Links that do not collide", plain_table(header, rows)) if rows else ""


def _only(colliders: Sequence[Sequence[str]] | None) -> str:
    return "all" if colliders is None else " against ".join(map(listed, colliders))


def _facts(tree: Mapping[str, Any]) -> str:
    """Figures, stages, calls, source and versions, side by side where there is room."""
    found = [
        section("Figures", plain_pairs(tree["figures"])),
        section("Stages", _stages(tree["stages"])),
        section("API calls", plain_pairs(tree["calls"])),
        section("Source", _source({**tree["source"], **tree["bundle"]})),
        section("Versions", plain_pairs(tree["versions"])),
    ]
    return '<div class="facts">\n' + "\n".join(one for one in found if one) + "\n</div>"


def _source(source: Mapping[str, Any]) -> str:
    rows = {key.replace("_", " "): text(value) for key, value in source.items()}
    address = str(source.get("url", ""))
    if address.startswith(("https://", "http://")):
        rows["url"] = link(address, address)
    return pairs(rows)


def _stages(stages: Sequence[Mapping[str, Any]]) -> str:
    rows = [
        [one["name"], "cached" if one["cached"] else "built", f"{one['seconds']:.2f}", one["outputs"]]
        for one in stages
    ]
    return plain_table(["stage", "result", "seconds", "outputs"], rows)


def _outputs(digests: Mapping[str, str], sizes: Mapping[str, int]) -> str:
    """The files, those of the meshes folded."""
    meshes = [path for path in digests if path.startswith(ASSETS)]
    others = [path for path in digests if not path.startswith(ASSETS)]
    size = sum(sizes[path] for path in meshes)
    summary = f"{len(meshes)} in {ASSETS}, {size / 1e6:.2f} MB"
    rows = {path: [file_link(path), f"{sizes[path]:,}", digests[path]] for path in digests}
    header, classes = ["file", "bytes", "SHA-256"], {"bytes": "number", "SHA-256": "digest"}
    first = table(header, [rows[path] for path in others], classes)
    rest = table(header, [rows[path] for path in meshes], classes)
    return section("Outputs", first + folded(summary, rest))


def _codes(tree: Mapping[str, Any]) -> str:
    """What the codes on this page mean."""
    problems = [*tree["diagnostics"], *(tree["error"] or {}).get("problems", [])]
    problems += [check for check in tree["checks"] if not check["passed"]]
    codes = sorted({one["code"] for one in problems} & explanations().keys())
    rows = []
    for code in codes:
        found = explanations()[code]
        rows.append([f'<span id="{code}">{code}</span>', _inline(found.meaning), _inline(found.remedy)])
    return section("What the codes mean", table(["", "meaning", "what to do"], rows, {"": "code"}))


def _inline(markdown: str) -> str:
    """A line of Markdown: code and the words of links."""
    bare = re.sub(r"\[([^\]]+)\]\([^)]*\)", r"\1", markdown.replace("\\|", "|"))
    return re.sub(r"`([^`]+)`", r"<code>\1</code>", text(bare))
