"""Sets variables of a document for a build, which writes to the user's CAD and is undone at once.

The variables are changed in their variable studios, the microversion of that state is noted, and the previous
values are restored; the build then reads that microversion, which never changes. A studio's table is written
whole, with only the set values changed: whether the server would replace or merge a partial table is not
documented.

The previous values are stored before anything is written: if the process is killed in between, the
next build restores them.
"""

from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from hashlib import sha256
from typing import Any

import orjson

from linkwright.stages.fetch.onshape import definition, requests
from linkwright.stages.fetch.onshape.asking.cached_client import CachedClient
from linkwright.stages.fetch.onshape.asking.freshness import Workspace
from linkwright.stages.fetch.onshape.asking.session import Session
from linkwright.stages.fetch.onshape.replies import documents
from linkwright.stages.fetch.onshape.url import AssemblyUrl
from linkwright.stages.robot.errors import (
    AuthError,
    Diagnostic,
    NotFound,
    ProtocolError,
    QuotaExhausted,
    RateLimited,
    SourceError,
)
from linkwright.stages.robot.text.plural import count
from linkwright.stages.robot.text.units import SI, Measure

_CONFIG_KEY = "source.variables"
_SENT_FIELDS = ("name", "type", "expression", "description")

Table = list[dict[str, Any]]
"""The variables of a studio, in the format of the API."""


@dataclass(frozen=True, slots=True)
class _Change:
    """The variables of a variable studio, before and after."""

    studio: str
    before: Table
    after: Table


class Variables:
    """A reader and writer of the variables of the workspace at `url`."""

    def __init__(
        self, url: AssemblyUrl, client: CachedClient, session: Session, progress: Callable[[str], None]
    ) -> None:
        self._url = url
        self._client = client
        self._session = session
        self._progress = progress
        self._subject = f"/documents/d/{url.document}/{url.pin}#variables"

    def restore_left(self) -> None:
        """Restores the variables that a killed build had changed."""
        if not self._url.pinned and not self._client.offline and self._unrestored_changes():
            with self.undisturbed():
                pass

    @contextmanager
    def undisturbed(self) -> Iterator[None]:
        """Keeps the users' values in place within this context: no other build changes the variables.

        Waits until another build has restored them; variables that a killed build had changed are restored
        first.
        """
        with self._client.lock(self._subject):
            unrestored = self._unrestored_changes()
            if unrestored:
                self._progress("restoring the variables that a killed build had changed")
                self._put_back([_Change(**change) for change in unrestored], only_if_ours=True)
            yield

    def set_values(self, settings: Mapping[str, Any]) -> AssemblyUrl:
        """Returns the address, pinned to the microversion at which the variables have the values of
        `settings`.

        Raises SourceError with the variables that the document lacks; in that case no value is changed.
        """
        with self.undisturbed():
            microversion_before = self._microversion()
            microversion = self._client.recall(self._state(microversion_before, settings)).get("microversion")
            if microversion:
                return self._pinned(str(microversion))
            changes = self._changes(settings)
            if not changes:
                return self._pinned(microversion_before)
            self._plan(len(settings), 2 * len(changes) + 2)
            self._client.remember(self._subject, {"changes": [_plain(change) for change in changes]})
            written: list[_Change] = []
            try:
                for change in changes:
                    self._set(change, written)
                microversion_set = self._microversion()
            except BaseException as first:
                self._put_back(written, only_if_ours=False, first=first)
                raise
            self._put_back(written, only_if_ours=False)
            # The same values in the same state of the document need no second write.
            self._client.remember(
                self._state(self._microversion(), settings), {"microversion": microversion_set}
            )
            return self._pinned(microversion_set)

    def _plan(self, variables: int, writing: int) -> None:
        """Reports the calls to come; raises SourceError before the first write if they are too many.

        `writing`: calls to write, to restore and to ask for the microversion. The calls of the build itself
        are known from the last complete build: the definition, and two for each part studio of this document,
        whose replies are not yet cached for the new state.
        """
        workspace = Workspace(self._url, self._client)
        last = workspace.last_microversion()
        body = self._client.lookup(workspace.definition(last)) if last else None
        studios = definition.read(body).parts if body else ()
        own_studios = [key for key in studios if (key.document, key.pin) == (self._url.document, f"m/{last}")]
        building = 1 + 2 * len(own_studios)
        self._client.allow(writing + building)
        min_calls = self._client.calls_made + writing + building
        self._progress(
            f"setting {count(variables, 'variable')} of the document, and restoring their previous values: "
            f"{writing} calls; with the build at least {building} more, {min_calls} in all"
        )

    def _set(self, change: _Change, written: list[_Change]) -> None:
        """Writes the new values of a studio; adds the change to `written` unless it certainly failed."""
        written.append(change)
        try:
            self._write(change.studio, change.after)
        except AuthError as refusal:
            written.pop()
            msg = "the API key may not write the variables of the document"
            hint = "give the key write permission, or set the variables in Onshape"
            raise AuthError(f"{msg}: {refusal.message}", refusal.where, hint) from refusal
        except (NotFound, QuotaExhausted, RateLimited):
            written.pop()
            raise

    def _put_back(
        self, changes: Sequence[_Change], *, only_if_ours: bool, first: BaseException | None = None
    ) -> None:
        """Restores the previous values; with `only_if_ours`, only if the values are still those that we
        wrote.

        Tries every studio, even after a failure. Raises SourceError if a studio fails; the error names the
        error that ended the build (`first`) as well, and the values left to restore stay stored.
        """
        failed = [
            (change, error)
            for change in changes
            if (error := self._restored(change, only_if_ours=only_if_ours))
        ]
        self._client.remember(self._subject, {"changes": [_plain(change) for change, _ in failed]})
        if not failed:
            return
        errors = [error for _, error in failed]
        if isinstance(first, SourceError):
            errors.insert(0, first)
        names = [name for change, _ in failed for name in _assignments(change)]
        # A dict keeps the order and reports equal errors of several studios once.
        why = "; ".join(dict.fromkeys(error.message for error in errors))
        hints = dict.fromkeys(error.hint for error in errors if error.hint)
        msg = f"variables of the document could not be restored to {', '.join(names)}: {why}"
        hint = "run the same command again, which restores them first, or set them in Onshape"
        raise SourceError(msg, _CONFIG_KEY, "; ".join([hint, *hints])) from (first or errors[0])

    def _restored(self, change: _Change, *, only_if_ours: bool) -> SourceError | None:
        """Restores the variables of a studio; returns the error if that fails."""
        sent = False
        try:
            present = _values(self._table(change.studio)) if only_if_ours else _values(change.after)
            if present == _values(change.after):
                sent = True
                self._write(change.studio, change.before, restoring=True)
            elif present != _values(change.before):
                self._progress(
                    f"variable studio {change.studio} was edited in the meantime and is left as it is"
                )
        except SourceError as error:
            outcome = "was not restored" if sent else "could not be read, so it was not changed"
            msg = f"variable studio {change.studio} {outcome}: {error.message}"
            return SourceError(msg, error.where, error.hint)
        return None

    def _changes(self, settings: Mapping[str, Any]) -> list[_Change]:
        tables = {studio: self._table(studio) for studio in self._studios()}
        studio_of = {row["name"]: studio for studio, table in tables.items() for row in table}
        studio_counts = Counter(row["name"] for table in tables.values() for row in table)
        problems = [
            Diagnostic(
                "E-VARIABLE",
                f"{studio_counts[name]} variable studios of the document have this variable",
                f"{_CONFIG_KEY}.{name}",
                "give it another name in all of them but one",
            )
            for name in settings
            if studio_counts[name] > 1
        ]
        problems += [
            Diagnostic(
                "E-VARIABLE",
                "no variable studio of the document has this variable",
                f"{_CONFIG_KEY}.{name}",
                f"it has: {', '.join(sorted(studio_of)) or 'none'}",
            )
            for name in settings
            if name not in studio_of
        ]
        changes = []
        for studio in sorted({studio_of[name] for name in settings if name in studio_of}):
            old_table = tables[studio]
            new_table = [
                {**row, "expression": expression(settings[row["name"]], str(row.get("type")))}
                if studio_of[row["name"]] == studio and row["name"] in settings
                else row
                for row in old_table
            ]
            without_value = [str(row["name"]) for row in old_table if not row.get("expression")]
            if new_table != old_table and without_value:
                text = f"its variable studio has variables without a known value, such as #{without_value[0]}"
                hint = "a configured variable cannot be written back: use source.configuration"
                problems.append(Diagnostic("E-VARIABLE", text, f"{_CONFIG_KEY} ({studio})", hint))
            elif new_table != old_table:
                changes.append(_Change(studio, old_table, new_table))
        if problems:
            msg = f"the variables cannot be set: {count(len(problems), 'problem')}"
            raise SourceError(msg, _CONFIG_KEY, problems=problems)
        return changes

    def _studios(self) -> list[str]:
        """Returns the ids of the document's variable studios."""
        body = self._client.uncached_reply(requests.tabs(self._url.document, self._url.pin[2:]))
        tabs = orjson.loads(body)
        return sorted(str(tab["id"]) for tab in tabs if tab.get("elementType") == "VARIABLESTUDIO")

    def _table(self, studio: str) -> Table:
        """Returns the present variables of a studio; the variables of a studio that it refers to are not
        written."""
        request = requests.variable_studio(self._url.document, self._url.pin[2:], studio)
        rows = [
            row
            for table in orjson.loads(self._client.uncached_reply(request))
            if not table.get("variableStudioReference")
            for row in table.get("variables") or ()
        ]
        if any(not isinstance(row.get("name"), str) for row in rows):
            msg = "the reply with the variables has a variable without a name"
            raise ProtocolError(msg, _CONFIG_KEY, "run the same command again; the API may have changed")
        return [{key: row[key] for key in _SENT_FIELDS if row.get(key) is not None} for row in rows]

    def _write(self, studio: str, table: Table, *, restoring: bool = False) -> None:
        request = requests.variable_studio(self._url.document, self._url.pin[2:], studio)
        self._session.ready().post(request, orjson.dumps(table), restoring=restoring)

    def _microversion(self) -> str:
        request = requests.current_microversion(self._url.document, self._url.pin[2:])
        return documents.microversion(self._client.uncached_reply(request))

    def _pinned(self, microversion: str) -> AssemblyUrl:
        return replace(self._url, pin=f"m/{microversion}")

    def _state(self, microversion: str, settings: Mapping[str, Any]) -> str:
        """Returns the key under which these values at a state of the document are stored."""
        values = orjson.dumps(dict(settings), option=orjson.OPT_SORT_KEYS)
        return f"/documents/d/{self._url.document}/m/{microversion}#variables={sha256(values).hexdigest()}"

    def _unrestored_changes(self) -> list[dict[str, Any]]:
        changes = self._client.recall(self._subject).get("changes")
        return changes if isinstance(changes, list) else []


def expression(value: Any, kind: str) -> str:
    """Returns a value as the expression of a variable of the type `kind`; bare numbers are SI."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        return value
    measures: Mapping[str, Measure] = {"LENGTH": "length", "ANGLE": "angle"}
    unit = SI[measures[kind]] if kind in measures else ""
    return f"{value!r} {unit}".rstrip()


def _plain(change: _Change) -> dict[str, Any]:
    return {"studio": change.studio, "before": change.before, "after": change.after}


def _assignments(change: _Change) -> list[str]:
    """Returns the assignments that a user has to make to restore a studio by hand."""
    rows = zip(change.before, change.after, strict=True)
    return [f"{old['name']} = {old.get('expression')}" for old, new in rows if old != new]


def _values(table: Table) -> dict[str, Any]:
    return {row["name"]: row.get("expression") for row in table}
