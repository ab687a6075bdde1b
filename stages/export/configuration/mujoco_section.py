"""Defines the configuration of MuJoCo's own settings, `scene.option` and `scene.compiler`: every attribute of
the MuJoCo that is installed and of all that are supported (its XML reference, `option`, `flag`, `compiler`).

Attributes that neither the configuration, the source nor a target sets keep MuJoCo's default and are not
written, except those of `DEFAULTS`.
"""

from collections.abc import Mapping
from typing import Annotated, Any, Literal

from pydantic import (
    BeforeValidator,
    Field,
    SerializerFunctionWrapHandler,
    create_model,
    model_serializer,
    model_validator,
)

from linkwright.stages.robot.section import (
    Flag,
    NonNegative,
    Number,
    Positive,
    Section,
    Text,
    Triple,
    invalid,
)

Whole = Annotated[int, Field(strict=True, ge=0)]
Switch = Literal["enable", "disable"]
Automatic = Annotated[
    Literal["true", "false", "auto"],
    BeforeValidator(lambda value: str(value).lower() if isinstance(value, bool) else value),
]


class _Sparse(Section):
    """Attributes of an element of MuJoCo; null: not set, and left out of the file."""

    @model_serializer(mode="wrap")
    def _without_nulls(self, handler: SerializerFunctionWrapHandler) -> dict[str, Any]:
        # A long list of nulls would hide what counts.
        return {name: value for name, value in handler(self).items() if value is not None}

    def explicit(self) -> dict[str, Any]:
        """Returns name → value of the attributes that are set, without subsections."""
        values = {name: getattr(self, name) for name in type(self).model_fields}
        return {
            name: value
            for name, value in values.items()
            if value is not None and not isinstance(value, Section)
        }

    def sections(self) -> dict[str, "_Sparse"]:
        """Returns the subsections by name."""
        values = {name: getattr(self, name) for name in type(self).model_fields}
        return {name: value for name, value in values.items() if isinstance(value, _Sparse)}


def _section(
    name: str, text: str, fields: Mapping[str, tuple[Any, Any, str]], base: type[_Sparse] = _Sparse
) -> Any:
    """Makes a class of section. `text`: its docstring; `fields`: name → (type, default, meaning), where a
    field whose default is None may also be null."""
    section_fields: dict[str, Any] = {
        key: (kind if default is not None else kind | None, Field(default=default, description=meaning))
        for key, (kind, default, meaning) in fields.items()
    }
    return create_model(name, __base__=base, __doc__=text, __module__=__name__, **section_fields)


def _attributes(kind: Any, element: str, *names: str) -> dict[str, tuple[Any, None, str]]:
    """Returns the fields for attributes of an element of MuJoCo that have the same type: name → (type,
    default, meaning)."""
    return dict.fromkeys(names, (kind, None, f"As MuJoCo's attribute of `<{element}>`."))


RESERVED_ATTRIBUTES = (
    "angle", "assetdir", "autolimits", "coordinate", "eulerseq", "meshdir", "strippath", "texturedir",
)  # fmt: skip
"""Attributes of `<compiler>` that a user cannot set: they would change the meaning of the robot's file, or
hide its meshes."""


class _Compiler(_Sparse):
    @model_validator(mode="before")
    @classmethod
    def _check_reserved(cls, value: Any) -> Any:
        wrong = [name for name in RESERVED_ATTRIBUTES if isinstance(value, dict) and name in value]
        if wrong:
            raise invalid(f"{', '.join(wrong)} would give the robot's own file another meaning: leave it out")
        return value


DEFAULTS = {"timestep": 0.002, "integrator": "implicitfast"}
"""Values of the options that are written even if nothing sets them."""

FlagsSection = _section(
    "FlagsSection",
    "MuJoCo's `<flag>`: parts of the simulation that are switched on or off.",
    _attributes(
        Switch, "flag", "actuation", "autoreset", "clampctrl", "constraint", "contact", "damper", "diagexact",
        "energy", "equality", "eulerdamp", "filterparent", "frictionloss", "fwdinv", "gravity", "invdiscrete",
        "ipc", "island", "limit", "midphase", "multiccd", "nativeccd", "override", "passive", "refsafe",
        "sensor", "sleep", "speculative", "spring", "warmstart",
    ),
)  # fmt: skip

OptionSection = _section(
    "OptionSection",
    "MuJoCo's `<option>`; defaults are those of an MJCF source, otherwise MuJoCo's own. The first four keys, "
    "and the options of an MJCF source, are in the robot's own file, since its stability depends on them.",
    {
        "timestep": (
            Positive,
            None,
            f"Time step of the simulation [s]; null: that of an MJCF source, else {DEFAULTS['timestep']:g}.",
        ),
        "integrator": (
            Literal["Euler", "RK4", "implicit", "implicitfast", "discrete"],
            None,
            "Integrator, from one time step to the next; `discrete` needs MuJoCo 3.13. null: that of an MJCF "
            f"source, else {DEFAULTS['integrator']}.",
        ),
        "cone": (Literal["pyramidal", "elliptic"], None, "Shape of the friction cones; null: MuJoCo's own."),
        "impratio": (
            Positive,
            None,
            "How much stiffer friction is than contact [-]; 10 to 100 keep feet from slipping with elliptic "
            "cones. null: MuJoCo's own.",
        ),
        **_attributes(Triple, "option", "gravity", "wind", "magnetic"),
        **_attributes(
            NonNegative, "option", "density", "viscosity", "tolerance", "ls_tolerance", "noslip_tolerance"
        ),
        **_attributes(NonNegative, "option", "ccd_tolerance", "sleep_tolerance", "apirate"),
        **_attributes(Whole, "option", "iterations", "ls_iterations", "noslip_iterations", "ccd_iterations"),
        **_attributes(Whole, "option", "sdf_iterations", "sdf_initpoints"),
        **_attributes(Number, "option", "o_margin"),
        **_attributes(tuple[Number, Number], "option", "o_solref"),
        **_attributes(tuple[Number, Number, Number, Number, Number], "option", "o_solimp", "o_friction"),
        **_attributes(tuple[Whole, ...], "option", "actuatorgroupdisable"),
        **_attributes(Literal["PGS", "CG", "Newton"], "option", "solver"),
        **_attributes(Literal["dense", "sparse", "auto"], "option", "jacobian"),
        "flag": (FlagsSection, FlagsSection(), "Parts of the simulation that are switched on or off."),
    },
)

LengthRangeSection = _section(
    "LengthRangeSection",
    "MuJoCo's `<lengthrange>`: how the range of lengths of actuators is found.",
    {
        **_attributes(Literal["none", "muscle", "muscleuser", "all"], "lengthrange", "mode"),
        **_attributes(Flag, "lengthrange", "useexisting", "uselimit"),
        **_attributes(
            NonNegative, "lengthrange", "accel", "maxforce", "timeconst", "timestep", "inttotal", "interval"
        ),
        **_attributes(NonNegative, "lengthrange", "tolrange"),
    },
)

CompilerSection = _section(
    "CompilerSection",
    "MuJoCo's `<compiler>`, except attributes that decide how the robot's own file is read.",
    {
        **_attributes(
            Flag, "compiler", "alignfree", "balanceinertia", "discardvisual", "fitaabb", "fusestatic"
        ),
        **_attributes(
            Flag, "compiler", "savecanonical", "savecompiled", "saveinertial", "usethread", "passthrough"
        ),
        **_attributes(NonNegative, "compiler", "boundmass", "boundinertia"),
        **_attributes(Number, "compiler", "settotalmass"),
        **_attributes(Automatic, "compiler", "inertiafromgeom"),
        **_attributes(tuple[Whole, Whole], "compiler", "inertiagrouprange"),
        **_attributes(Text, "compiler", "conflict"),
        "lengthrange": (
            LengthRangeSection,
            LengthRangeSection(),
            "How the range of lengths of actuators is found.",
        ),
    },
    _Compiler,
)

ROBOT_FILE_OPTIONS = ("timestep", "integrator", "cone", "impratio")
"""Attributes of `<option>` that affect stability: the robot's own file has them, not only the scene."""
