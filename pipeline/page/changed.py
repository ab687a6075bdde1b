"""Renders the changes since the previous build in the folder."""

from linkwright.pipeline.changes.build_changes import BuildChanges
from linkwright.pipeline.page.html.tables import table
from linkwright.pipeline.page.html.template import name, rendered
from linkwright.pipeline.secrets import Secrets
from linkwright.stages.robot.text.plural import count


def changes_section(changes: BuildChanges | None, secrets: Secrets) -> str:
    """Renders the section; "" if no build was replaced."""
    if changes is None:
        return ""
    rows, previous_row = [], ""
    for row_name, words in changes.robot:
        rows.append(
            [name(secrets.blanked(row_name)) if row_name != previous_row else "", secrets.blanked(words)]
        )
        previous_row = row_name
    return rendered(
        "changes",
        changes=changes,
        unknown=secrets.blanked(changes.failure),
        robot=table(["what", "difference"], rows, {"what": "place"}),
        more=count(changes.more, "more difference") if changes.more else "",
        files=[secrets.blanked(line) for line in changes.files],
    )
