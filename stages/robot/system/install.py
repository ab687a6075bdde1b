"""Finds the versions of installed packages, and the command that installs an optional package."""

import functools

OPTIONAL = {
    "hydra-joblib-launcher": ">=1.2,<2",
    "hydra-optuna-sweeper": ">=1.3,<2",
    "hydra-ray-launcher": ">=1.2.2,<2",
    "hydra-submitit-launcher": ">=1.2,<2",
    "joblib": ">=1.5,<2",
    "optuna": ">=2.10.1,<6",
    "pillow": ">=11.3,<14",
    "pin": ">=4.0,<5",
    "pycollada": ">=0.8,<1",
    "ray": ">=2.55,<3",
    "socksio": ">=1.0,<2",
    "submitit": ">=1.5,<2",
    "usd-core": ">=26.3,<27",
    "xacro": ">=2.1,<3",
}
"""Optional package → its accepted versions, as in pyproject.toml."""


def install(*packages: str) -> str:
    """Returns the command that installs these optional packages. It does not use the extras of our own
    package, which pip knows only if our package is on an index."""
    return " ".join(["pip install", *(f"'{name}{OPTIONAL[name]}'" for name in packages)])


@functools.cache
def installed(library: str) -> str:
    """Returns the version of a distribution, without importing it; "absent" if it is not installed."""
    # Late: this import is slow, and few callers ask for a version.
    from importlib.metadata import PackageNotFoundError, version

    try:
        return version(library)
    except PackageNotFoundError:
        return "absent"
