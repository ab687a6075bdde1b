"""Lists the elements and attributes of MJCF that a version of MuJoCo added or removed.

Each version is compared with the preceding version, as `mj_printSchema` of 3.11.0, 3.16.0, 3.17.0 and 4.0.0
lists them.
"""

from collections.abc import Mapping

Words = Mapping[str, tuple[str, ...]]
"""Element → its attributes; an empty tuple means the element itself."""

ADDED_WORDS: Mapping[str, Words] = {
    "3.16": {
        "pid": (),
        "orientation": (),
        "general": ("ffrange", "inheritrange", "velrange"),
        "body": ("fuse",),
        "light": ("softness",),
        "site": ("mesh",),
        "flexcomp": ("mesh",),
        "flex": ("nodecoord",),
        "compiler": ("savecanonical", "savecompiled"),
        "flag": ("ipc",),
        "insidesite": ("enclosed",),
        "tactile": ("cutoff",),
    },
    "3.17": {
        "texture": ("class", "embed"),
        "compiler": ("passthrough",),
        "elasticity": ("section", "sectionsize"),
    },
    "4.0": {
        "geom": ("castshadow",),
        "joint": ("springyield",),
        "tendon": ("springyield",),
        "fixed": ("springyield",),
        "spatial": ("springyield",),
        "elasticity": ("shear", "yield"),
        "key": ("plastic",),
        "flag": ("speculative",),
    },
}
"""Version → the words that it added."""

ADDED_VALUES: Mapping[tuple[str, str, str], str] = {("option", "integrator", "discrete"): "3.16"}
"""(element, attribute, value) → the version that added the value."""

REMOVED_WORDS: Mapping[str, Words] = {"4.0": {"composite": (), "flexvert": ()}}
"""Version → the words that it removed."""
