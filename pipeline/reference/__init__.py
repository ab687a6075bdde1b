"""Holds the reference for users: keys of the configuration, codes of diagnostics, environment variables.

`KEYS.md`, `keys.json`, `keys.txt` and `robot.schema.json` are generated from the sections of the
configuration, `MUTATIONS.md` from `tests/support/faults`, `PEERS.md`, for who comes from another tool,
from peers.yaml, `formats/READERS.md` from `stages/targets/readers.py`, and
`formats/ROBOT_JSON.md` and `robot_json.schema.json` from `stages/formats/robot_json`, and
`formats/COMMAND_JSON.md` and `schemas` from `pipeline/json_documents`: `python -m tests.config.regenerate`.
Imports nothing heavy.
"""

from pathlib import Path

_HERE = Path(__file__).parent

DATA = _HERE / "keys.json"
HELP = _HERE / "keys.txt"
COMMAND_JSON = _HERE / "formats" / "COMMAND_JSON.md"
MUTATIONS = _HERE / "MUTATIONS.md"
PAGE = _HERE / "KEYS.md"
PEERS = _HERE / "PEERS.md"
READERS = _HERE / "formats" / "READERS.md"
ROBOT_JSON = _HERE / "formats" / "ROBOT_JSON.md"
ROBOT_JSON_SCHEMA = _HERE / "robot_json.schema.json"
SCHEMA = _HERE / "robot.schema.json"
SCHEMAS = _HERE / "schemas"
SKILL = _HERE / "linkwright" / "SKILL.md"
"""The instructions for agents, in a folder with the name of the skill."""

_SUFFIX = ".schema.json"


def schemas() -> dict[str, Path]:
    """Returns the JSON Schemas of the documents that commands print with `--json`: name → file."""
    return {path.name.removesuffix(_SUFFIX): path for path in sorted(SCHEMAS.glob(f"*{_SUFFIX}"))}
