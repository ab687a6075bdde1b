"""Guest process that expands a xacro file with ROS's own `xacro` package."""

from __future__ import annotations

import json
from collections.abc import Mapping

import xacro
from xacro import substitution_args


class _MissingPackage(Exception):
    """The error that a requested package is not among the given packages."""


def answer(request: bytes) -> bytes:
    """Expands a xacro file; returns a line of JSON, and the text.

    The request is {"path": the file, "args": its arguments, "packages": folders of packages by name}. The
    line is {"lacking": a package that is not among them, "refused": why there is no text}.
    """
    fields = json.loads(request)
    missing_packages: list[str] = []
    try:
        text, fault = _expanded(fields["path"], fields["args"], fields["packages"], missing_packages), ""
    except RecursionError:
        text, fault = "", "its macros are nested too deeply, or call themselves"
    except Exception as error:
        text, fault = "", str(error) or type(error).__name__
    reply = {"lacking": missing_packages[-1] if missing_packages and fault else "", "refused": fault}
    return json.dumps(reply).encode() + b"\n" + text.encode()


def _expanded(
    path: str, args: Mapping[str, str], packages: Mapping[str, str], missing_packages: list[str]
) -> str:
    def folder(name: str) -> str:
        if name not in packages:
            missing_packages.append(name)
            raise _MissingPackage(name)
        return packages[name]

    # xacro's own look-up needs an installed ROS.
    substitution_args._eval_find = folder
    substitution_args._eval_dict["find"] = folder
    xacro.init_stacks(path)
    document = xacro.parse(None, path)
    xacro.process_doc(document, mappings=dict(args))
    text: str = document.toprettyxml(indent="  ")
    return text
