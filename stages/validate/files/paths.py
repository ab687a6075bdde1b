"""Checks that paths of files stay valid if the folder moves: they are relative, and stay within the
folder."""

from collections.abc import Iterator
from pathlib import PurePosixPath, PureWindowsPath

from linkwright.stages.robot.check import CheckLevel, Finding
from linkwright.stages.validate.reading.asset_files import is_of_package, package_of, referenced_files
from linkwright.stages.validate.reading.documents import ModelDocument


def level(document: ModelDocument) -> CheckLevel:
    """Returns the level of the findings: a warning for another program's file, which may rely on a package
    elsewhere."""
    return "warning" if document.foreign else "error"


def findings(document: ModelDocument) -> Iterator[Finding]:
    """Yields findings on absolute paths, paths that lead out of the folder, and missing packages. Another
    program's file may name files outside its folder, as packages of ROS do."""
    for file in referenced_files(document):
        if file.element in document.included:
            continue
        is_in_package = is_of_package(file.text)
        # `package:///a.stl`, without a package's name, is not absolute either.
        text = file.text.partition("://")[2].lstrip("/") if is_in_package else file.text
        flaw = _flaw_of_path(text, document)
        if file.path is None:
            flaw = f'no folder of a package "{package_of(file.text)}" has this file'
        if flaw:
            yield document.finding(file.element, file.attribute, f'"{file.text}": {flaw}')
    if document.language == "mjcf":
        yield from _folder_findings(document)


def _folder_findings(document: ModelDocument) -> Iterator[Finding]:
    for compiler in document.root.iterfind("compiler"):
        for name in ("meshdir", "texturedir", "assetdir"):
            flaw = _flaw_of_path(compiler.get(name, ""), document)
            if flaw and compiler not in document.included:
                yield document.finding(compiler, name, f'"{compiler.get(name)}": {flaw}')


def _flaw_of_path(text: str, document: ModelDocument) -> str:
    """Returns a text on why a path is not valid elsewhere; "" for a valid path."""
    pure_path = PurePosixPath(text)
    if text.startswith("file://") or pure_path.is_absolute() or PureWindowsPath(text).drive:
        return "an absolute path, which is of one computer"
    if ".." in pure_path.parts and not document.foreign:
        return "it leads out of the model's folder"
    return ""
