"""Renders report.html: a single file that shows a build and needs nothing else."""

import json
from base64 import b64encode
from collections.abc import Mapping
from typing import Any

from linkwright.pipeline.changes.build_changes import BuildChanges
from linkwright.pipeline.page.changed import changes_section
from linkwright.pipeline.page.checks import checks
from linkwright.pipeline.page.codes import codes, problems_of
from linkwright.pipeline.page.colliders import colliders
from linkwright.pipeline.page.contacts import excluded_pairs_section
from linkwright.pipeline.page.files import files, variants
from linkwright.pipeline.page.findings import diagnostics_section, error_section
from linkwright.pipeline.page.fix_first import MAX_FIXES, fix_first, fixes
from linkwright.pipeline.page.graph import graph, tables_of
from linkwright.pipeline.page.head import facts, head
from linkwright.pipeline.page.html.shell import ReportSection, Top, document
from linkwright.pipeline.page.live_view import with_view
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
    stage_views: Mapping[str, str],
    sizes: Mapping[str, int],
    secrets: Secrets,
    *,
    live: Live = NOTHING,
    pictures: Preview = NONE,
    changes: BuildChanges | None = None,
) -> bytes:
    """Renders the page, with secrets blanked and the `live` view of the robot; parameters as for `frame`."""
    moves = live.pack is not None
    framed = frame(report, stage_views, sizes, secrets, moves=moves, pictures=pictures, changes=changes)
    return with_view(framed, live)


def frame(
    report: Report,
    stage_views: Mapping[str, str],
    sizes: Mapping[str, int],
    secrets: Secrets,
    *,
    moves: bool,
    pictures: Preview,
    changes: BuildChanges | None,
) -> str:
    """Renders the page without its live view.

    `stage_views`: views of the stages that ran, by name; `sizes`: size [bytes] of each output; `moves`:
    whether the page gets a live view; `pictures`: the robot's picture as a file beside the page, and small in
    the page; `changes`: the differences from the build that this build replaces, if there is one.
    """
    tree: dict[str, Any] = report.tree()
    tables = json.loads(stage_views.get(TABLES, "[]"))
    if secrets:
        tree, tables = secrets.within(tree), secrets.within(tables)
    details, to_fix = tree["details"], fixes(tree)
    graph_section = graph(
        stage_views.get(PICTURE, ""), tree["outline"], tables, secrets, is_file=PICTURE in tree["outputs"]
    )
    parts = [
        ReportSection("error", "Error", error_section(tree["error"])),
        ReportSection("fix", "Fix first", fix_first(tree, to_fix)),
        ReportSection("checks", "Checks", checks(tree["checks"])),
        ReportSection("diagnostics", "Diagnostics", diagnostics_section(tree["diagnostics"])),
        ReportSection("graph", "Graph", graph_section),
        ReportSection("joints", "Joints", tables_of("Joints", tables)),
        ReportSection("masses", "Masses", tables_of("Masses", tables)),
        ReportSection("colliders", "Colliders", colliders(details, stage_views.get(PICTURES, ""), secrets)),
        ReportSection("contacts", "Contacts", excluded_pairs_section(details.get("excludes", []))),
        ReportSection("order", "Order", order(details.get("order", {}))),
        ReportSection("readers", "Readers", readers(details.get("readers", []))),
        ReportSection("variants", "Variants", variants(details.get("variants", {}))),
        ReportSection("cost", "Time", cost(tree)),
        ReportSection("provenance", "Provenance", provenance(tree)),
        ReportSection("changes", "Changes", changes_section(changes, secrets)),
        ReportSection("files", "Files", files(tree["outputs"], sizes)),
        ReportSection("codes", "Codes", codes(_codes(tree) | {fix.code for fix in to_fix[:MAX_FIXES]})),
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
    """Returns the codes that the page has."""
    unmet = [check for check in tree["checks"] if not check["passed"]]
    return {problem["code"] for problem in (*problems_of(tree), *unmet)}
