"""Lists the environment variables that Linkwright reads."""

from textwrap import fill
from typing import NamedTuple


class Variable(NamedTuple):
    """An environment variable, an example of its value, and its meaning."""

    name: str
    value: str
    meaning: str


VARIABLES = (
    Variable("ONSHAPE_ACCESS_KEY", "", "access key of Onshape's API, from here or from .env, never YAML"),
    Variable("ONSHAPE_SECRET_KEY", "", "secret key of Onshape's API, from here or from .env, never YAML"),
    Variable("ONSHAPE_AUTH", "signature", "sign each request with the keys: the secret is never sent"),
    Variable("ONSHAPE_ACCESS_TOKEN", "", "a bearer token, in place of the two keys"),
    Variable("LINKWRIGHT_CACHE", "DIR", "the folder of the cache, where `cache.dir` names none"),
    Variable(
        "LINKWRIGHT_TRUST", "FILE", "a robot's file that may set `source.trust`, `plugins`, any `output`"
    ),
    Variable("LINKWRIGHT_HOST", "URL", "a server on this computer that `source.url` of a file may name"),
    Variable("LINKWRIGHT_PAGE", "plain", "pages without the live view and builds without a picture, for CI"),
    Variable("LINKWRIGHT_TRACEBACK", "1", "show the traceback of an error"),
    Variable("HTTPS_PROXY", "URL", "a proxy for Onshape; NO_PROXY names hosts that need none"),
    Variable("SSL_CERT_FILE", "FILE", "certificates to trust; SSL_CERT_DIR names a folder of them"),
    Variable("ROS_PACKAGE_PATH", "DIRS", "folders with ROS packages; so does AMENT_PREFIX_PATH"),
)
"""The variables in the order of `--help-all`: first those of Linkwright itself."""


def text() -> str:
    """Returns the variables as `--help-all` shows them."""
    rows = [
        (f"{variable.name}={variable.value}" if variable.value else variable.name, variable.meaning)
        for variable in VARIABLES
    ]
    width = max(len(name) for name, _ in rows)
    return "\n".join(
        fill(
            meaning.replace("`", ""),
            80,
            initial_indent=f"  {name:{width}}  ",
            subsequent_indent=" " * (width + 4),
        )
        for name, meaning in rows
    )
