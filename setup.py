"""Ships the folders `conf`, `pipeline` and `stages` as packages of `linkwright`."""

from setuptools import find_packages, setup

ROOMS = find_packages(include=["conf", "pipeline*", "stages*"], exclude=["pipeline.package"])

setup(
    packages=["linkwright", *(f"linkwright.{room}" for room in ROOMS)],
    package_dir={
        "linkwright": "pipeline/package",
        "linkwright.conf": "conf",
        "linkwright.pipeline": "pipeline",
        "linkwright.stages": "stages",
    },
)
