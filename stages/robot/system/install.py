"""Installed packages: their versions, and the command that installs an optional one."""

import functools

OPTIONAL = {
    "hydra-joblib-launcher": ">=1.2,<2",
    "joblib": ">=1.5,<2",
    "pillow": ">=11.3,<14",
    "pin": ">=4.0,<5",
    "pycollada": ">=0.8,<1",
    "socksio": ">=1.0,<2",
    "usd-core": ">=26.3,<27",
    "xacro": ">=2.1,<3",
}
"""The versions of each, as in pyproject.toml."""


def install(*packages: str) -> str:
    """Returns the command that installs these packages. It names the packages themselves, since our extras
    are known to pip only where our own package is on an index."""
    return " ".join(["pip install", *(f"'{name}{OPTIONAL[name]}'" for name in packages)])


@functools.cache
def installed(library: str) -> str:
    """The version of an installed distribution, found without importing it; "absent" where there is none."""
    # Here, since most who import this module ask for no version, and it takes as long as all the rest of it.
    from importlib.metadata import PackageNotFoundError, version

    try:
        return version(library)
    except PackageNotFoundError:
        return "absent"
