"""Defines the source `sample`: a robot of the gallery, which the package contains as a bundle."""

from __future__ import annotations

from collections.abc import Mapping
from importlib.resources import files
from typing import ClassVar

from linkwright.stages.fetch.bundle.source import BundleSource


class SampleSource(BundleSource):
    """The source that reads a bundle beside this module."""

    advice: ClassVar[str] = "install linkwright again"

    def label(self) -> str:
        return f"the gallery's {self._keys.robot}"

    def preflight(self, environ: Mapping[str, str]) -> None:
        pass

    def read(self) -> bytes:
        return files("linkwright.stages.fetch.bundle.sample").joinpath(f"{self._keys.robot}.zip").read_bytes()
