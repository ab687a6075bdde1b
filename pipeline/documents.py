"""The documents about a build: report.json, report.html, config.yaml and build.log."""

from linkwright.pipeline.report import Report
from linkwright.pipeline.terminal.progress import Log


def documents(done: Report, page: bytes, config: bytes, log: Log) -> dict[str, bytes]:
    """The documents by file name, with secrets blanked. `page`: report.html; `config`: the composed
    configuration as YAML."""
    return {
        "report.json": done.to_json(log.secrets),
        "report.html": page,
        "config.yaml": config,
        "build.log": log.content(),
    }
