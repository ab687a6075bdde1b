"""Lists the size limits of replies, by kind [bytes, decompressed].

Each limit is many times the size in the largest documents, and small enough that a reply of that
size fits in memory even if it consists of the shortest possible JSON values: as Python objects
these take thirty times their bytes. Only triangles may be much larger, since they are read in pieces.
"""

import re
from collections.abc import Sequence

_MB = 1 << 20

TRIANGLES = 1024 * _MB
"""Limit of triangles: at about 300 bytes a triangle, 3.5 million triangles in a part studio."""

DEFINITION = 64 * _MB
"""Limit of definitions: at up to 1.5 kB an instance, 44,000 instances in an assembly."""

_BY_PATH: Sequence[tuple[str, int]] = (
    # tessellated faces of a part studio
    (r"/tessellatedfaces$", TRIANGLES),
    # glTF of a part studio: half as large as its faces
    (r"/gltf$", 512 * _MB),
    # the definition of an assembly, in a bundle also without its request
    (r"^/assemblies/.*/e/[^/]+$|^[^/]", DEFINITION),
    # the features of an assembly: about 3 kB a mate, 11,000 mates
    (r"^/assemblies/.*/features$", 32 * _MB),
    # the mass properties of an assembly, as one body
    (r"^/assemblies/.*/massproperties$", 1 * _MB),
    # the mass properties of the parts of a studio, or of a part: about 1.5 kB a part, 22,000 parts
    (r"/massproperties$", 32 * _MB),
    # the present microversion of a workspace: a single id
    (r"/currentmicroversion$", 1 * _MB),
    # the tabs of a document: about 1 kB a tab, 16,000 tabs
    (r"^/documents/.*/elements$", 16 * _MB),
    # the parameters of a configuration, with all their options
    (r"/configuration$", 16 * _MB),
    # the variables that an element may use
    (r"/variables$", 16 * _MB),
)
"""Pattern of a request's path → the limit of its reply; the first match is used."""

_ANY_OTHER = 16 * _MB
"""Limit of all other replies."""

REFUSAL = 64 * 1024
"""Largest part of an error reply that is read: its message is short."""


def largest(request: str) -> int:
    """Returns the size limit of the reply to a request [bytes, decompressed]."""
    path = request.partition("?")[0]
    return next((bound for pattern, bound in _BY_PATH if re.search(pattern, path)), _ANY_OTHER)


def in_words(size: int) -> str:
    """Returns a size limit in words: "64 MB"."""
    return f"{size // _MB} MB"
