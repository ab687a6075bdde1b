"""What changed since the previous build of the folder, for people."""

from linkwright.pipeline.changes.since import Since
from linkwright.pipeline.page.html.tables import table
from linkwright.pipeline.page.html.template import name, rendered
from linkwright.pipeline.secrets import Secrets
from linkwright.stages.robot.text.plural import count


def changed(changes: Since | None, secrets: Secrets) -> str:
    """The section; nothing where no build was replaced."""
    if changes is None:
        return ""
    rows, last = [], ""
    for thing, words in changes.robot:
        rows.append([name(secrets.blanked(thing)) if thing != last else "", secrets.blanked(words)])
        last = thing
    return rendered(
        "changes",
        changes=changes,
        unknown=secrets.blanked(changes.unknown),
        robot=table(["what", "difference"], rows, {"what": "place"}),
        more=count(changes.more, "more difference") if changes.more else "",
        files=[secrets.blanked(line) for line in changes.files],
    )
