"""The documents about a build: report.json, report.html, config.yaml and build.log."""

from collections.abc import Mapping
from pathlib import Path

from linkwright.pipeline.changes.since import since
from linkwright.pipeline.report import Report
from linkwright.pipeline.show.live import NOTHING, Live
from linkwright.pipeline.show.preview import NONE, Preview
from linkwright.pipeline.terminal.progress import Log


def documents(
    done: Report,
    files: Mapping[str, bytes],
    shown: Mapping[str, str],
    config: bytes,
    log: Log,
    last: Path | None = None,
    seen: Live = NOTHING,
    pictures: Preview = NONE,
) -> dict[str, bytes]:
    """The documents by file name, with secrets blanked. `files`: those of the robot; `shown`: views of the
    stages by name; `config`: the composed configuration as YAML; `last`: the folder that they replace, None
    where they replace no build; `seen`: what the page shows of the robot; `pictures` of it."""
    from linkwright.pipeline.page.document import page

    sizes = {path: len(data) for path, data in files.items()}
    changes = (
        None
        if last is None
        else since(last, done.outputs, files, (*seen.files, *pictures.files), done.checks)
    )
    return {
        "report.json": done.to_json(log.secrets),
        "report.html": page(done, shown, sizes, log.secrets, live=seen, pictures=pictures, changes=changes),
        "config.yaml": config,
        "build.log": log.content(),
    }
