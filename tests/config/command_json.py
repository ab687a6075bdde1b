"""The JSON Schemas of what commands print with `--json`, and the page about them."""

import functools
import json

from linkwright.pipeline.json_documents.build import BuildDocument
from linkwright.pipeline.json_documents.bundle import BundleDocument
from linkwright.pipeline.json_documents.cache import CacheDocument
from linkwright.pipeline.json_documents.check import CheckDocument
from linkwright.pipeline.json_documents.diff import DiffDocument
from linkwright.pipeline.json_documents.doctor import DoctorDocument
from linkwright.pipeline.json_documents.document import VERSION
from linkwright.pipeline.json_documents.error import ErrorDocument
from linkwright.pipeline.json_documents.explain import ExplainDocument
from linkwright.pipeline.json_documents.jobs import JobsDocument, SweepDocument
from linkwright.pipeline.json_documents.new import NewDocument
from linkwright.pipeline.reference import SCHEMAS
from tests.config import robot_json

DOCUMENTS = (
    BuildDocument,
    SweepDocument,
    JobsDocument,
    ErrorDocument,
    BundleDocument,
    CacheDocument,
    CheckDocument,
    DiffDocument,
    DoctorDocument,
    ExplainDocument,
    NewDocument,
)

INTRODUCTION = """# What commands print with --json

A build, a sweep (`-m`) and the verbs `bundle`, `cache`, `check`, `diff`, `doctor`, `explain`, `job`,
`jobs` and `new` take `--json`. The standard output then holds one JSON object and nothing else; progress and
messages go to the standard error. Every document has these keys:

| key | value | meaning |
| --- | --- | --- |
| `format` | text | the kind of the document |
| `version` | 1 | keys may be added in the same version: pass over those that you do not know |
| `exit_status` | whole number | the exit status of the command |

If an error ends the command, the document is a [linkwright-error](#linkwright-error). `linkwright explain
--schema NAME` prints the path of a JSON Schema; NAME is the format without `linkwright-`. Numbers that JSON
lacks are null.

Generated from `pipeline/json_documents` by `python -m tests.config.regenerate`; do not edit.
"""


def name_of(document):
    """The format without `linkwright-`, which names the schema's file."""
    return str(document.FORMAT).removeprefix("linkwright-")


def schema(document):
    whole = robot_json.schema(document, f"linkwright {name_of(document)} --json")
    head = {
        "format": {"const": document.FORMAT, "description": "The kind of the document."},
        "version": {"const": VERSION, "description": "The version."},
    }
    required = [*head, *whole["required"]]
    return {**whole, "properties": {**head, **whole["properties"]}, "required": required}


def schemas():
    """File of a schema → its text."""
    return {
        SCHEMAS / f"{name_of(document)}.schema.json": functools.partial(_text, document)
        for document in DOCUMENTS
    }


def _text(document):
    return json.dumps(schema(document), indent=1, ensure_ascii=False) + "\n"


def markdown():
    """The page: a section for each document, and below it one for each of its tables."""
    sections, seen = [INTRODUCTION], set()
    for document in DOCUMENTS:
        tables = robot_json.tables(document)
        for name, kind in tables.items():
            if name in seen:
                continue
            seen.add(name)
            text = robot_json.section(kind, "###")
            if kind is document:
                text = text.replace(f"### {robot_json.title(name)}", f"## {document.FORMAT}", 1)
            sections.append(text)
    return "".join(sections)
