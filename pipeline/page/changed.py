"""What changed since the previous build of the folder, for people."""

from linkwright.pipeline.changes.since import Since
from linkwright.pipeline.page.html.markup import name, part, section, table, text
from linkwright.pipeline.secrets import Secrets
from linkwright.stages.robot.text.plural import count


def changed(changes: Since | None, secrets: Secrets) -> str:
    """The section; nothing where no build was replaced."""
    if changes is None:
        return ""
    if changes.first:
        body = "<p>This is the first build here.</p>"
    elif changes.nothing:
        body = "<p>Nothing: each of the robot's files is as it was.</p>"
    else:
        body = _robot(changes, secrets) + part("Checks and files", _files(changes, secrets))
    return section("Changed since the previous build", body, "changes")


def _robot(changes: Since, secrets: Secrets) -> str:
    if changes.unknown:
        return f"<p>Whether the robot is the same is not known: {text(secrets.blanked(changes.unknown))}.</p>"
    if not changes.robot:
        return "<p>The robot is the same; its files are not.</p>"
    rows, last = [], ""
    for thing, words in changes.robot:
        rows.append([name(secrets.blanked(thing)) if thing != last else "", text(secrets.blanked(words))])
        last = thing
    more = f'<p class="soft">and {count(changes.more, "more difference")}</p>' if changes.more else ""
    return table(["what", "difference"], rows, {"what": "place"}) + more


def _files(changes: Since, secrets: Secrets) -> str:
    lines = "\n".join(f"<li>{text(secrets.blanked(line))}</li>" for line in changes.files)
    return f"<ul>\n{lines}\n</ul>" if lines else ""
