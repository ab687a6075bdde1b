"""Collects the documents about a build: report.json, report.html, config.yaml and build.log."""

from linkwright.pipeline.report import Report
from linkwright.pipeline.terminal.progress import Log


def documents(report: Report, page: bytes, config: bytes, log: Log) -> dict[str, bytes]:
    """Returns the documents by file name, with secrets blanked. `page`: the content of report.html; `config`:
    the composed configuration as YAML."""
    return {
        "report.json": report.to_json(log.secrets),
        "report.html": page,
        "config.yaml": config,
        "build.log": log.content(),
    }
