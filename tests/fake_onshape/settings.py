"""Configurations of a document's elements: their parameters, and Onshape's text for a choice of values."""

from dataclasses import dataclass, field
from urllib.parse import parse_qsl, quote_plus

DEFAULT = "default"


class BadSettingError(ValueError):
    """A configuration that an element does not have."""


@dataclass(frozen=True)
class Choice:
    """A list of options: id → label; the first is the default."""

    id: str
    name: str
    options: dict = field(hash=False)

    @property
    def default(self):
        return next(iter(self.options))

    def record(self):
        kind = {"btType": "BTMEnumOption-592"}
        options = [{**kind, "option": option, "optionName": label} for option, label in self.options.items()]
        named = {"enumName": f"{self.id}_conf", "namespace": "", "options": options}
        return _record("Enum-105", "ENUM", self, **named, defaultValue=self.default)

    def check(self, text):
        return text in self.options


@dataclass(frozen=True)
class Switch:
    """True or false."""

    id: str
    name: str
    default: str = "false"

    def record(self):
        return _record("Boolean-2550", "BOOLEAN", self, defaultValue=self.default == "true")

    def check(self, text):
        return text in ("true", "false")


@dataclass(frozen=True)
class Size:
    """A quantity with a unit; `least` and `most` are in that unit."""

    id: str
    name: str
    default: str
    least: float
    most: float
    unit: str = "millimeter"
    measure: str = "LENGTH"

    def record(self):
        number = float(self.default.split()[0])
        bounds = {"defaultValue": number, "minValue": self.least, "maxValue": self.most, "units": self.unit}
        bounds = {"btType": "BTQuantityRange-181", **bounds}
        return _record("Quantity-1826", "QUANTITY", self, quantityType=self.measure, rangeAndDefault=bounds)

    def check(self, text):
        number, _, unit = text.partition(" ")
        try:
            float(number)
        except ValueError:
            return False
        return bool(unit) or self.measure in ("REAL", "INTEGER")


@dataclass(frozen=True)
class Words:
    """Any text."""

    id: str
    name: str
    default: str = ""

    def record(self):
        return _record("String-872", "STRING", self, defaultValue=self.default)

    def check(self, text):
        return isinstance(text, str)


def values(parameters, text):
    """Parameter id → value, the defaults included; BadSettingError for what an element does not have.

    An element without parameters takes any text and does not mind it.
    """
    if not parameters:
        return {}
    by_name = {parameter.id: parameter for parameter in parameters}
    by_key = {name: parameter.default for name, parameter in by_name.items()}
    pairs = [] if text in ("", DEFAULT) else parse_qsl(text, True, True, separator=";")
    for name, value in pairs:
        if name not in by_name or not by_name[name].check(value):
            message = f"{name} cannot be {value}." if name in by_name else f"There is no parameter {name}."
            raise BadSettingError(message)
        by_key[name] = value
    return by_key


def text_of(values):
    """Onshape's text for values by parameter id."""
    return ";".join(f"{name}={quote_plus(value)}" for name, value in values.items()) or DEFAULT


def reply(parameters, microversion):
    """What the server says about an element's configuration."""
    skew = {"microversionSkew": False, "rejectMicroversionSkew": False}
    return {
        "btType": "BTConfigurationResponse-2019",
        "configurationParameters": [parameter.record() for parameter in parameters],
        "currentConfiguration": [],
        "sourceMicroversion": microversion,
        "serializationVersion": "1.2.17",
        "libraryVersion": 0,
        **skew,
    }


def _record(kind, plain, parameter, **more):
    return {
        "btType": f"BTMConfigurationParameter{kind}",
        "parameterId": parameter.id,
        "parameterName": parameter.name,
        "parameterType": plain,
        "isCosmetic": False,
        "valid": True,
        **more,
    }
