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
        of_package = is_of_package(file.text)
        text = file.text.partition("://")[2].lstrip("/") if of_package else file.text
        wrong = _leads_out(text, document)
        if file.path is None:
            wrong = f'no folder of a package "{package_of(file.text)}" has this file'
        if wrong:
            yield document.finding(file.element, file.attribute, f'"{file.text}": {wrong}')
    if document.language == "mjcf":
        yield from _folders(document)


def _folders(document: ModelDocument) -> Iterator[Finding]:
    for compiler in document.root.iterfind("compiler"):
        for name in ("meshdir", "texturedir", "assetdir"):
            wrong = _leads_out(compiler.get(name, ""), document)
            if wrong and compiler not in document.included:
                yield document.finding(compiler, name, f'"{compiler.get(name)}": {wrong}')


def _leads_out(text: str, document: ModelDocument) -> str:
    plain = PurePosixPath(text)
    if text.startswith("file://") or plain.is_absolute() or PureWindowsPath(text).drive:
        return "an absolute path, which is of one computer"
    if ".." in plain.parts and not document.foreign:
        return "it leads out of the model's folder"
    return ""
