"""Reads a configuration of onshape-to-robot: its source, and the robot's name."""

import json
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from linkwright.pipeline.errors import ConfigError
from linkwright.stages.robot.system import regular_files

FILE = "config.json"
"""The name of the file in a robot's folder."""

_MAX_BYTES = 1 << 20
"""Largest size of a configuration [bytes]."""

_COMMENT = re.compile(r'("(?:\\.|[^"\\])*")|//[^\n]*|#[^\n]*|/\*.*?\*/', re.DOTALL)
_TRAILING_COMMA = re.compile(r'("(?:\\.|[^"\\])*")|,(?=\s*[\]}])')
_IDS = ("document_id", "workspace_id", "version_id", "element_id")
_EXAMPLE = "my_robot/config.json"


@dataclass(frozen=True, slots=True)
class PeerConfig:
    """A configuration of onshape-to-robot."""

    place: str
    """Its path as the user gave it."""
    options: Mapping[str, Any]
    """Option in snake_case → value, in the order of the file."""
    folder: Path
    """The folder of the file, where other files that it names are."""

    @property
    def name(self) -> str:
        """The robot's name there, in letters that a robot's name may have; "" without one."""
        names = (self.options.get("robot_name"), self.options.get("output_filename"), self._folder_name)
        text = next((name for name in names if isinstance(name, str) and name not in ("", "robot")), "")
        return re.sub(r"[^A-Za-z0-9_-]+", "_", text).strip("_-")

    @property
    def _folder_name(self) -> str:
        return self.folder.resolve().name

    def source(self, address: str = "") -> dict[str, Any]:
        """Returns the keys of the source; `address`: the user's, which replaces that of the file. Raises
        ConfigError if there is none."""
        options = self.options
        url = address or options.get("url") or self._composed_url()
        if not isinstance(url, str) or not url:
            lacking = ", ".join(name for name in ("document_id", "workspace_id or version_id", "element_id"))
            msg = f"it has neither url nor all of {lacking}"
            hint = f'give the address of the assembly: linkwright new --from {self.place} "https://..."'
            raise ConfigError(msg, self.place, hint)
        values = _configuration(options.get("configuration"))
        return {"kind": "onshape", "url": url, **({"configuration": values} if values else {})}

    def _composed_url(self) -> str:
        document, workspace, version, element = (self.options.get(name) for name in _IDS)
        pin = f"v/{version}" if version else f"w/{workspace}" if workspace else ""
        if not (document and pin and element):
            return ""
        return f"https://cad.onshape.com/documents/{document}/{pin}/e/{element}"


def read(path: str) -> PeerConfig:
    """Reads a configuration at the path of its file or folder. Raises ConfigError if it cannot be read."""
    file = Path(path)
    if file.is_dir():
        file = file / FILE
    regular_files.require(str(file), "--from", "a configuration of onshape-to-robot is a file", _EXAMPLE)
    try:
        text = regular_files.content(file, _MAX_BYTES).decode("utf-8-sig")
        options = json.loads(_TRAILING_COMMA.sub(_quoted_text, _COMMENT.sub(_quoted_text, text)))
    except (OSError, ValueError, regular_files.FileTooLarge) as error:
        reason = f", {error}" if isinstance(error, json.JSONDecodeError) else ""
        msg = f"it cannot be read as JSON with comments{reason}"
        raise ConfigError(msg, str(file), "give the config.json of onshape-to-robot") from None
    if not isinstance(options, dict):
        raise ConfigError("it is not a mapping of options", str(file), "give the config.json itself")
    return PeerConfig(path, {_snake_case(name): value for name, value in options.items()}, file.parent)


def _quoted_text(match: re.Match[str]) -> str:
    """Returns a text of JSON as it is, and nothing in place of a comment or a comma."""
    return match[1] or ""


def _snake_case(name: str) -> str:
    """Returns the present name of an option: earlier releases wrote `outputFormat`."""
    return re.sub(r"(?<=[a-z0-9])([A-Z])", lambda match: f"_{match[1].lower()}", name)


def _configuration(value: Any) -> dict[str, Any]:
    """Returns the values of the assembly's configuration: `A=x;B=true` as a mapping."""
    if isinstance(value, Mapping):
        return dict(value)
    if not isinstance(value, str) or value in ("", "default"):
        return {}
    pairs = (item.partition("=") for item in value.split(";") if item)
    return {name.strip(): entry.strip() for name, _, entry in pairs}
