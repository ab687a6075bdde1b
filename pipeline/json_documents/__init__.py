"""Defines the documents that commands print with `--json`, one JSON object each.

The fields of a class are the keys of its document. The JSON Schemas in `pipeline/reference/schemas` and the
page `pipeline/reference/formats/COMMAND_JSON.md` are generated from the classes: `python -m
tests.config.regenerate`.

- build: Defines the document of a build.
- bundle: Defines the document of `linkwright bundle`.
- cache: Defines the document of `linkwright cache`.
- check: Defines the document of `linkwright check`.
- diff: Defines the document of `linkwright diff`.
- doctor: Defines the document of `linkwright doctor`.
- document: Defines what all documents have in common, and writes a document as text.
- error: Defines the document of a command that an error ended.
- explain: Defines the document of `linkwright explain`.
- findings: Chooses the worst diagnostics of a build for a document.
- jobs: Defines the documents of a sweep and of a list of jobs.
- new: Defines the document of `linkwright new`.
"""
