"""report.html: a build for people, one file that needs nothing else."""

import json
from base64 import b64encode
from collections.abc import Mapping
from typing import Any

from linkwright.pipeline.changes.since import Since
from linkwright.pipeline.page.changed import changed
from linkwright.pipeline.page.checks import checks
from linkwright.pipeline.page.codes import codes, problems_of
from linkwright.pipeline.page.colliders import colliders
from linkwright.pipeline.page.contacts import contacts
from linkwright.pipeline.page.files import files
from linkwright.pipeline.page.findings import diagnostics, error
from linkwright.pipeline.page.fix_first import MOST, fix_first, fixes
from linkwright.pipeline.page.graph import graph, tables_of
from linkwright.pipeline.page.head import facts, head
from linkwright.pipeline.page.hero import with_view
from linkwright.pipeline.page.html.shell import ReportSection, Top, document
from linkwright.pipeline.page.order import order
from linkwright.pipeline.page.provenance import cost, provenance
from linkwright.pipeline.page.readers import readers
from linkwright.pipeline.report import Report
from linkwright.pipeline.secrets import Secrets
from linkwright.pipeline.show.live import NOTHING, Live
from linkwright.pipeline.show.preview import NONE, Preview
from linkwright.stages.mesh.view.views import PICTURES
from linkwright.stages.show.graph_view.views import PICTURE, TABLES


def page(
    report: Report,
    shown: Mapping[str, str],
    sizes: Mapping[str, int],
    secrets: Secrets,
    *,
    live: Live = NOTHING,
    pictures: Preview = NONE,
    changes: Since | None = None,
) -> bytes:
    """The page, with secrets blanked: its frame with the `live` view of the robot."""
    moves = live.pack is not None
    made = frame(report, shown, sizes, secrets, moves=moves, pictures=pictures, changes=changes)
    return with_view(made, live)


def frame(
    report: Report,
    shown: Mapping[str, str],
    sizes: Mapping[str, int],
    secrets: Secrets,
    *,
    moves: bool,
    pictures: Preview,
    changes: Since | None,
) -> str:
    """The page without its live view. `shown`: views of the stages by name, none where a build did not come
    so far; `sizes` [bytes] of the outputs; `moves`: whether it gets a view; `pictures`: of the robot, a file
    beside the page and a small one in it; `changes`: since the build that this one replaces, None where it
    replaces none."""
    tree: dict[str, Any] = report.tree()
    tables = json.loads(shown.get(TABLES, "[]"))
    if secrets:
        tree, tables = secrets.within(tree), secrets.within(tables)
    details, found = tree["details"], fixes(tree)
    drawn = graph(
        shown.get(PICTURE, ""), tree["outline"], tables, secrets, is_file=PICTURE in tree["outputs"]
    )
    parts = [
        ReportSection("error", "Error", error(tree["error"])),
        ReportSection("fix", "Fix first", fix_first(tree, found)),
        ReportSection("checks", "Checks", checks(tree["checks"])),
        ReportSection("diagnostics", "Diagnostics", diagnostics(tree["diagnostics"])),
        ReportSection("graph", "Graph", drawn),
        ReportSection("joints", "Joints", tables_of("Joints", tables)),
        ReportSection("masses", "Masses", tables_of("Masses", tables)),
        ReportSection("colliders", "Colliders", colliders(details, shown.get(PICTURES, ""), secrets)),
        ReportSection("contacts", "Contacts", contacts(details.get("excludes", []))),
        ReportSection("order", "Order", order(details.get("order", {}))),
        ReportSection("readers", "Readers", readers(details.get("readers", []))),
        ReportSection("cost", "Time", cost(tree)),
        ReportSection("provenance", "Provenance", provenance(tree)),
        ReportSection("changes", "Changes", changed(changes, secrets)),
        ReportSection("files", "Files", files(tree["outputs"], sizes)),
        ReportSection("codes", "Codes", codes(_codes(tree) | {fix.code for fix in found[:MOST]})),
    ]
    title = f"{tree['name']}: {tree['status']}"
    top = Top(
        head(tree, secrets.blanked(report.heading), changes),
        facts(tree, pictures.files),
        b64encode(pictures.small).decode() if pictures.path else "",
        f"The robot {tree['name']}",
        "" if moves else pictures.path,
    )
    return document(title, top, parts, tree["versions"].get("linkwright", ""))


def _codes(tree: Mapping[str, Any]) -> set[str]:
    """The codes that the page has."""
    unmet = [check for check in tree["checks"] if not check["passed"]]
    return {one["code"] for one in (*problems_of(tree), *unmet)}
