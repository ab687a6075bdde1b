"""Defines the source `sample`: the robot that is shipped with the package, as a bundle."""

from __future__ import annotations

from collections.abc import Mapping
from importlib.resources import files
from typing import ClassVar

from linkwright.stages.fetch.bundle.source import BundleSource


class SampleSource(BundleSource):
    """The source that reads the bundle in the package."""

    advice: ClassVar[str] = "install linkwright again"

    def label(self) -> str:
        return "the sample"

    def preflight(self, environ: Mapping[str, str]) -> None:
        pass

    def read(self) -> bytes:
        return files("linkwright.stages.fetch").joinpath("sample.zip").read_bytes()
