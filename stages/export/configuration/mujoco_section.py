"""Configuration of MuJoCo's own settings, `scene.option` and `scene.compiler`: every attribute of the MuJoCo
that is installed and of all that are supported (its XML reference, `option`, `flag`, `compiler`).

What is not given stays MuJoCo's default and is not written.
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
    """Attributes of which only those that are given are written."""

    @model_serializer(mode="wrap")
    def _only_given(self, handler: SerializerFunctionWrapHandler) -> dict[str, Any]:
        # A long list of nulls would hide what counts.
        return {name: value for name, value in handler(self).items() if value is not None}

    def given(self) -> dict[str, Any]:
        """The attributes that have a value, by name; without sections of their own."""
        every = {name: getattr(self, name) for name in type(self).model_fields}
        return {
            name: value
            for name, value in every.items()
            if value is not None and not isinstance(value, Section)
        }

    def sections(self) -> dict[str, "_Sparse"]:
        """The sections below, by name."""
        every = {name: getattr(self, name) for name in type(self).model_fields}
        return {name: value for name, value in every.items() if isinstance(value, _Sparse)}


def _section(
    name: str, text: str, fields: Mapping[str, tuple[Any, Any, str]], base: type[_Sparse] = _Sparse
) -> Any:
    """A section of these fields: type, default and meaning."""
    made: dict[str, Any] = {
        key: (kind if default is not None else kind | None, Field(default=default, description=meaning))
        for key, (kind, default, meaning) in fields.items()
    }
    return create_model(name, __base__=base, __doc__=text, __module__=__name__, **made)


def _of(kind: Any, element: str, *names: str) -> dict[str, tuple[Any, None, str]]:
    return dict.fromkeys(names, (kind, None, f"As MuJoCo's attribute of `<{element}>`."))


READS_THE_FILE = (
    "angle", "assetdir", "autolimits", "coordinate", "eulerseq", "meshdir", "strippath", "texturedir",
)  # fmt: skip
"""Attributes of `<compiler>` that are not for the user: with another value the robot's file would mean
something else, or its meshes would not be found."""


class _Compiler(_Sparse):
    @model_validator(mode="before")
    @classmethod
    def _not_how_the_file_is_read(cls, value: Any) -> Any:
        wrong = [name for name in READS_THE_FILE if isinstance(value, dict) and name in value]
        if wrong:
            raise invalid(f"{', '.join(wrong)} would give the robot's own file another meaning: leave it out")
        return value


DEFAULTS = {"timestep": 0.002, "integrator": "implicitfast"}
"""Options that are always given."""

FlagsSection = _section(
    "FlagsSection",
    "MuJoCo's `<flag>`: parts of the simulation that are switched on or off.",
    _of(
        Switch, "flag", "actuation", "autoreset", "clampctrl", "constraint", "contact", "damper", "diagexact",
        "energy", "equality", "eulerdamp", "filterparent", "frictionloss", "fwdinv", "gravity", "invdiscrete",
        "ipc", "island", "limit", "midphase", "multiccd", "nativeccd", "override", "passive", "refsafe",
        "sensor", "sleep", "speculative", "spring", "warmstart",
    ),
)  # fmt: skip

OptionSection = _section(
    "OptionSection",
    "MuJoCo's `<option>`; what is not given is an MJCF source's, else MuJoCo's own. The first four are in "
    "the robot's own file, since its stability depends on them, and so is what an MJCF source says.",
    {
        "timestep": (
            Positive,
            None,
            f"Time step of the simulation [s]; null: that of an MJCF source, else {DEFAULTS['timestep']:g}.",
        ),
        "integrator": (
            Literal["Euler", "RK4", "implicit", "implicitfast", "discrete"],
            None,
            "How MuJoCo goes from one step to the next; `discrete` needs MuJoCo 4. null: as an MJCF source "
            f"says, else {DEFAULTS['integrator']}.",
        ),
        "cone": (Literal["pyramidal", "elliptic"], None, "Shape of the friction cones; null: MuJoCo's own."),
        "impratio": (
            Positive,
            None,
            "How much stiffer friction is than contact [-]; 10 to 100 keep feet from slipping with elliptic "
            "cones. null: MuJoCo's own.",
        ),
        **_of(Triple, "option", "gravity", "wind", "magnetic"),
        **_of(NonNegative, "option", "density", "viscosity", "tolerance", "ls_tolerance", "noslip_tolerance"),
        **_of(NonNegative, "option", "ccd_tolerance", "sleep_tolerance", "apirate"),
        **_of(Whole, "option", "iterations", "ls_iterations", "noslip_iterations", "ccd_iterations"),
        **_of(Whole, "option", "sdf_iterations", "sdf_initpoints"),
        **_of(Number, "option", "o_margin"),
        **_of(tuple[Number, Number], "option", "o_solref"),
        **_of(tuple[Number, Number, Number, Number, Number], "option", "o_solimp", "o_friction"),
        **_of(tuple[Whole, ...], "option", "actuatorgroupdisable"),
        **_of(Literal["PGS", "CG", "Newton"], "option", "solver"),
        **_of(Literal["dense", "sparse", "auto"], "option", "jacobian"),
        "flag": (FlagsSection, FlagsSection(), "Parts of the simulation that are switched on or off."),
    },
)

LengthRangeSection = _section(
    "LengthRangeSection",
    "MuJoCo's `<lengthrange>`: how the range of lengths of actuators is found.",
    {
        **_of(Literal["none", "muscle", "muscleuser", "all"], "lengthrange", "mode"),
        **_of(Flag, "lengthrange", "useexisting", "uselimit"),
        **_of(
            NonNegative, "lengthrange", "accel", "maxforce", "timeconst", "timestep", "inttotal", "interval"
        ),
        **_of(NonNegative, "lengthrange", "tolrange"),
    },
)

CompilerSection = _section(
    "CompilerSection",
    "MuJoCo's `<compiler>`, but for what decides how the robot's own file is read.",
    {
        **_of(Flag, "compiler", "alignfree", "balanceinertia", "discardvisual", "fitaabb", "fusestatic"),
        **_of(Flag, "compiler", "savecanonical", "savecompiled", "saveinertial", "usethread", "passthrough"),
        **_of(NonNegative, "compiler", "boundmass", "boundinertia"),
        **_of(Number, "compiler", "settotalmass"),
        **_of(Automatic, "compiler", "inertiafromgeom"),
        **_of(tuple[Whole, Whole], "compiler", "inertiagrouprange"),
        **_of(Text, "compiler", "conflict"),
        "lengthrange": (
            LengthRangeSection,
            LengthRangeSection(),
            "How the range of lengths of actuators is found.",
        ),
    },
    _Compiler,
)

IN_THE_ROBOT = ("timestep", "integrator", "cone", "impratio")
"""Attributes of `<option>` with which the robot's stability was judged: they stand in its own file."""
