"""Reads the state of a document: the microversions of a workspace and of its tabs."""

from collections.abc import Mapping

import orjson

from linkwright.stages.robot.errors import ProtocolError

_HINT = "run the same command again; if it fails each time, the API has changed"


def microversion(body: bytes) -> str:
    """Returns the microversion in a `currentmicroversion` reply. Raises ProtocolError if it is missing."""
    data = _json(body, "the current microversion")
    version = data.get("microversion") if isinstance(data, dict) else None
    if not isinstance(version, str) or not version:
        msg = "the reply with the current microversion does not name one"
        raise ProtocolError(msg, hint=_HINT)
    return version


def tab_microversions(body: bytes) -> Mapping[str, str]:
    """Returns element id → the microversion of that element alone, from an `elements` reply.

    Tabs without a microversion are left out: they count as changed. Raises ProtocolError for an invalid
    reply.
    """
    versions = ((tab.get("id"), tab.get("microversionId")) for tab in _tab_list(body))
    return {str(element): str(version) for element, version in versions if element and version}


def tab_name(body: bytes, element: str) -> str:
    """Returns the name of a tab in an `elements` reply; "" if the tab or the list of tabs is missing."""
    reply = _json(body, "the tabs of a document")
    tabs = reply if isinstance(reply, list) else []
    names = (tab.get("name") for tab in tabs if isinstance(tab, dict) and tab.get("id") == element)
    return next((name for name in names if isinstance(name, str)), "")


def require_tab(body: bytes, element: str) -> None:
    """Raises ProtocolError if an `elements` reply is invalid, or lacks a tab that must exist."""
    if not any(tab.get("id") == element for tab in _tab_list(body)):
        msg = f"the reply with the tabs of a document lacks {element}, the tab of the assembly"
        raise ProtocolError(msg, hint="run the same command again; nothing of that reply was kept")


def _tab_list(body: bytes) -> list[dict[str, object]]:
    """Returns the tabs in an `elements` reply. Raises ProtocolError for an invalid reply."""
    data = _json(body, "the tabs of a document")
    if not isinstance(data, list) or not all(isinstance(tab, dict) for tab in data):
        msg = "the reply with the tabs of a document is not a list of tabs"
        raise ProtocolError(msg, hint=_HINT)
    return data


def _json(body: bytes, subject: str) -> object:
    try:
        data: object = orjson.loads(body)
    except orjson.JSONDecodeError:
        msg = f"the reply with {subject} is not JSON, or was cut short"
        raise ProtocolError(msg, hint=_HINT) from None
    return data
