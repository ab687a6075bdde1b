"""Defines the document of `linkwright explain`."""

from dataclasses import dataclass
from typing import Any, ClassVar, Literal

from linkwright.pipeline.json_documents.document import CommandDocument
from linkwright.stages.formats.robot_json.codec import JsonRecord


@dataclass(frozen=True)
class EntryDocument(JsonRecord[Any]):
    """The explanation of a code, a key, a motor, an environment variable, a launcher or the exit status, or
    the path of a JSON Schema.

    kind: what is explained.
    name: the code, the whole key with `<glob>` or `<name>` for parts that may be any name, the motor, ...
    meaning: the meaning.
    hint: what to do about a code.
    level: the level of a code: error, warning, info or check.
    stages: the stages that report the code.
    source: the kind of source that the key belongs to; missing for all.
    type: the type of the key.
    unit: the unit of the key.
    default: the default of the key.
    allowed: the values that the key allows, in words.
    words: the values of a key that is a choice.
    example: an example of the key.
    is_later: true for a key that is decided, but not supported yet.
    keys: the keys of a section or of a launcher.
    values: the values of a motor in lines of text, each followed by its source.
    path: the path of a schema.
    """

    kind: Literal["code", "key", "motor", "variable", "launcher", "exit_status", "schema"]
    name: str
    meaning: str
    hint: str = ""
    level: str = ""
    stages: str = ""
    source: str = ""
    type: str = ""
    unit: str = ""
    default: str = ""
    allowed: str = ""
    words: tuple[str, ...] = ()
    example: str = ""
    is_later: bool = False
    keys: tuple[str, ...] = ()
    values: tuple[str, ...] = ()
    path: str = ""


@dataclass(frozen=True)
class ExplainDocument(CommandDocument):
    """The meaning of a code, a key, a motor or a variable (`linkwright explain`). Keys of an entry that have
    no value are left out.

    exit_status: 0.
    entries: the explanation: one entry, or several for a key that several kinds of source have.
    """

    FORMAT: ClassVar[str] = "linkwright-explain"

    exit_status: int
    entries: tuple[EntryDocument, ...]
