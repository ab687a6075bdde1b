"""Every file is named by a path that holds wherever the folder is: relative, and within it."""

from collections.abc import Iterator
from pathlib import PurePosixPath, PureWindowsPath

from linkwright.stages.robot.check import CheckLevel, Finding
from linkwright.stages.validate.reading.asset_files import is_of_package, named_files, package_of
from linkwright.stages.validate.reading.documents import ModelDocument


def level(document: ModelDocument) -> CheckLevel:
    """Another program's file may count on a package that lies elsewhere."""
    return "warning" if document.foreign else "error"


def findings(document: ModelDocument) -> Iterator[Finding]:
    """Absolute paths, paths that lead out of the folder, and packages that are not here. A file of others may
    name what lies beside its folder, as packages of ROS do."""
    for one in named_files(document):
        if one.element in document.included:
            continue
        of_package = is_of_package(one.text)
        text = one.text.partition("://")[2].lstrip("/") if of_package else one.text
        wrong = _leads_out(text, document)
        if one.path is None:
            wrong = f'no folder of a package "{package_of(one.text)}" has this file'
        if wrong:
            yield document.finding(one.element, one.attribute, f'"{one.text}": {wrong}')
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
