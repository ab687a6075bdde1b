"""Fetches from the server: sets variables first; uses the last complete fetch if the quota is used up."""

from linkwright.stages.fetch.onshape import definition
from linkwright.stages.fetch.onshape.asking.ahead import calls_ahead
from linkwright.stages.fetch.onshape.asking.cached_client import CachedClient
from linkwright.stages.fetch.onshape.asking.live import LiveAnswers
from linkwright.stages.fetch.onshape.asking.mechanism import MechanismAnswers
from linkwright.stages.fetch.onshape.asking.session import Session
from linkwright.stages.fetch.onshape.asking.variables import Variables
from linkwright.stages.fetch.onshape.gather import gather
from linkwright.stages.fetch.onshape.section import OnshapeSourceSection
from linkwright.stages.fetch.onshape.url import AssemblyUrl
from linkwright.stages.fetch.source import CallsAhead, FetchContext, Fetched
from linkwright.stages.robot.bundle import OnshapeBundle
from linkwright.stages.robot.errors import Diagnostic, QuotaExhausted, SourceError


def fetch(keys: OnshapeSourceSection, context: FetchContext) -> Fetched:
    """Fetches the bundle of the assembly at `keys.url`. Raises the errors of `stages.fetch.fetch`."""
    url, calls = keys.url, context.calls
    with Session(keys, context) as session:
        client = answering_client = _client(keys, session, context)
        remarks: tuple[Diagnostic, ...] = ()
        try:
            url = _with_variables(url, keys, client, session, context)
            answers = LiveAnswers(url, keys, client, context.progress)
            try:
                bundle = gather(answers)
            except QuotaExhausted as exhausted:
                if url.pinned:
                    raise
                answering_client = CachedClient(
                    session, context.replies, offline=True, refresh=False, max_calls=keys.max_calls
                )
                answers = LiveAnswers(url, keys, answering_client, context.progress)
                bundle = _fetched_last(answers, exhausted)
                remarks = (_quota_warning(exhausted, accepted=keys.stale),)
        finally:
            session.account(calls)
            calls.saved = answering_client.saved
    is_stale = bool(remarks) and not keys.stale
    diagnostics = (*answers.diagnostics, *remarks)
    title = answers.title()
    return Fetched(bundle, calls.made, calls.saved, diagnostics, title, is_stale, answers.lasts)


def survey(keys: OnshapeSourceSection, context: FetchContext, *, masses: bool) -> Fetched:
    """Fetches the definition of the assembly, and with `masses` the mass properties of each part studio, as a
    bundle without triangles. Raises the errors of `stages.fetch.survey`.

    A workspace is asked for its definition, even if an earlier one is cached: the number of calls is the same
    whether it changed or not.
    """
    calls = context.calls
    with Session(keys, context) as session:
        client = _client(keys, session, context)
        try:
            url = _with_variables(keys.url, keys, client, session, context)
            latest = keys.model_copy(update={"refresh": not keys.offline})
            answers = LiveAnswers(url, latest, client, context.progress)
            bundle = gather(MechanismAnswers(answers, client, context.progress, masses=masses))
        finally:
            session.account(calls)
            calls.saved = client.saved
    return Fetched(bundle, calls.made, calls.saved, title=answers.title())


def ahead(keys: OnshapeSourceSection, context: FetchContext) -> CallsAhead:
    """Returns the calls that `fetch` will make, once the definition of the assembly is known. Raises the
    errors of `fetch`."""
    with Session(keys, context) as session:
        client = _client(keys, session, context)
        try:
            url = _with_variables(keys.url, keys, client, session, context)
            answers = LiveAnswers(url, keys, client, context.progress)
            body = answers.definition().body
            return calls_ahead(answers, body, definition.read(body), client)
        finally:
            session.account(context.calls)
            context.calls.saved = client.saved


def _client(keys: OnshapeSourceSection, session: Session, context: FetchContext) -> CachedClient:
    client = CachedClient(
        session,
        context.replies,
        offline=keys.offline,
        refresh=keys.refresh,
        max_calls=keys.max_calls,
        sweep=context.sweep,
    )
    client.while_waiting = context.while_waiting
    return client


def _with_variables(
    url: AssemblyUrl,
    keys: OnshapeSourceSection,
    client: CachedClient,
    session: Session,
    context: FetchContext,
) -> AssemblyUrl:
    """Returns the address of the assembly with its variables set; restores changes that an earlier build
    left."""
    variables = Variables(url, client, session, context.progress)
    client.undisturbed = variables.undisturbed
    variables.restore_left()
    return variables.set_values(keys.variables) if keys.variables else url


def _fetched_last(answers: LiveAnswers, exhausted: QuotaExhausted) -> OnshapeBundle:
    """Returns the bundle from cached replies only; raises `exhausted` if they are incomplete."""
    try:
        return gather(answers)
    except SourceError:
        raise exhausted from None


def _quota_warning(exhausted: QuotaExhausted, *, accepted: bool) -> Diagnostic:
    msg = f"{exhausted.message}; this is the assembly as it was last fetched completely"
    hint = "build again when the quota is renewed, or with another key"
    if not accepted:
        hint += "; source.stale=true counts a build from the last fetch as success"
    return Diagnostic("W-QUOTA", msg, exhausted.where, hint)
