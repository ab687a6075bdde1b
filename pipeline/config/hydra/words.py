# ruff: noqa: E501
"""Translates messages of Hydra and OmegaConf into Linkwright's messages about the same error."""

import re
from collections.abc import Collection
from typing import NamedTuple

from linkwright.pipeline.config.messages import nearest


class Words(NamedTuple):
    """The text of a problem, its place and its hint."""

    text: str
    where: str = ""
    hint: str = ""


Rules = dict[str, Words]
"""The pattern of a message of Hydra → our message, with the pattern's groups in braces. Further words in braces
are `near`, suggested groups for `group`, and `settings`, suggested settings for `key`."""

_TREE_HINT = "linkwright --cfg job shows the tree"

COMPOSITION_RULES: Rules = {
    r"In '?(?P<file>[^':]+)'?: Could not override '(?P<group>[^'@]+).*'. Did you mean to override (?P=group)\?": Words(
        "its defaults list cannot override {group}",
        "{file}.yaml",
        "let a robot or an experiment choose it, in its own defaults list",
    ),
    r"In '?(?P<file>[^':]+)'?: Could not override '(?P<group>[^'@]+)": Words(
        "its defaults list overrides {group}, and there is no such group", "{file}.yaml", "{near}"
    ),
    r"In '?(?P<file>[^':]+)'?: Override '.*?' is defined before '(?P<entry>.*?)'": Words(
        "in its defaults list an override precedes {entry}",
        "{file}.yaml",
        "put the lines with `override` at the end of the list",
    ),
    r"In '?(?P<file>[^':]+)'?: Multiple values for (?P<group>[^\s.]+)": Words(
        "its defaults list chooses {group}, which is chosen already",
        "{file}.yaml",
        "add `override`: - override /{group}: ...",
    ),
    r"(?P<group>\S+) appears more than once in the final defaults list": Words(
        "is chosen twice in defaults lists", "{group}", "add `override`: - override /{group}: ..."
    ),
    r"Error resolving interpolation '(?P<text>[^']*)'": Words(
        "a defaults list cannot use this interpolation", "{text}", "write the name of the option itself"
    ),
    r"Could not append to config\. An item is already at '(?P<key>[^']+)'": Words(
        "exists already", "+{key}", "leave out the +"
    ),
    r"Could not delete from config\. '(?P<key>[^']+)' does not exist": Words(
        "does not exist, so it cannot be deleted", "~{key}", _TREE_HINT
    ),
    r"Could not delete '(?P<key>[^'=]+)[^']*'\. No match in the defaults list": Words(
        "does not exist, so it cannot be deleted", "~{key}", _TREE_HINT
    ),
    r"Could not delete from config\. The value of '(?P<key>[^']+)' is (?P<value>.*?) and not ": Words(
        "is not deleted: its value is {value}", "~{key}", "leave out the value: ~{key}"
    ),
    r"force-add of config groups is not supported: '\+\+(?P<line>[^']+)'": Words(
        "++ is for keys, and this is a group", "++{line}", "{line}"
    ),
    r"Could not override 'hydra\.launcher\.(?P<key>[^']+)'": Words(
        "is not a setting of this launcher", "hydra.launcher.{key}", "{settings}"
    ),
    r"Could not override '(?P<group>[^'@]+)": Words("there is no such group", "{group}", "{near}"),
    r"In '?(?P<file>[^':]+)'?: \w+ raised while composing config:\s*(?P<cause>[^\n]*)(.*full_key: (?P<key>\S+))?": Words(
        "has a value that is not allowed: {cause}", "{file}.yaml {key}", "check the file there"
    ),
    r"Error merging override (?P<key>[^=\n]*)=[^\n]*\s*Value '(?P<value>[^'\n]*)'[^\n]* could not be converted to Integer": Words(
        "must be a whole number (given {value})", "{key}"
    ),
    r"Error merging override (?P<line>[^\n]*)\s*(?P<cause>[^\n]*)": Words(
        "is not allowed there: {cause}", "{line}", _TREE_HINT
    ),
    r"Error merging '(?P<file>[^']+)' with schema": Words(
        "has the name of a plug-in's settings, but other keys or types",
        "{file}.yaml",
        "give the file another name",
    ),
    r"Config '?(?P<file>[^' ]+)'? must be an OmegaConf config": Words(
        "must be a mapping: lines of `key: value`", "{file}.yaml", "remove everything else"
    ),
}  # fmt: skip
"""Messages of Hydra's composition."""

INTERPOLATION_RULES: Rules = {
    r"Interpolation key '(?P<key>[^']+)' not found": Words(
        "refers to {key}, which does not exist", hint="an interpolation needs the full key: ${{vars.reach}}"
    ),
    r"Environment variable '(?P<name>[^']+)' not found": Words(
        "the environment variable {name} is not set",
        hint="export {name}=..., or give a default: ${{oc.env:{name},0}}",
    ),
    r"Unsupported interpolation type (?P<name>\S+)": Words(
        "there is no resolver {name}",
        hint="resolvers: oc.env, oc.decode, oc.select, oc.create, oc.dict.keys, oc.dict.values, now",
    ),
    r"[Rr]ecursi": Words("refers to itself", hint="break the cycle of ${{...}}"),
    r"Interpolation to a missing value|Missing mandatory value|MissingMandatoryValue": Words(
        "refers to a value that is not given", hint="give that value"
    ),
}
"""Messages of OmegaConf's resolution of interpolations."""

PARSER_RULES: Rules = {
    r"token recognition error at: '(?P<text>.+)'": Words("{text} needs quotes"),
    r"(mismatched|extraneous) input '<EOF>'": Words("it ends too early"),
    r"(mismatched|extraneous) input '(?P<text>.*?)'( expecting|$)": Words("{text} is not expected there"),
    r"no viable alternative at input '(?P<text>.*)'": Words("{text} is not allowed there"),
    r"missing (?P<text>\S+) at": Words("{text} is missing"),
}
"""Messages of the parser of overrides."""


def translate(
    text: str, rules: Rules, groups: Collection[str] = (), settings: Collection[str] = ()
) -> Words | None:
    """Returns our message for a message of Hydra or OmegaConf; None if no pattern matches."""
    for pattern, words in rules.items():
        match = re.search(pattern, text, re.DOTALL)
        if match:
            texts = {name: (text or "").strip() for name, text in match.groupdict().items()}
            group = texts.get("group", "")
            name = group.removeprefix("robot/")
            slash_hint = f"write /{name}: a group's name begins with a slash" if name in groups else ""
            texts["near"] = slash_hint or nearest(group, groups) or f"groups: {', '.join(groups)}"
            suggestion = nearest(texts.get("key", ""), settings)
            texts["settings"] = suggestion or f"settings: {', '.join(settings)}"
            return Words(*(template.format(**texts).strip() for template in words))
    return None
