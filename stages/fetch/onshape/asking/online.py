"""Fetches from the server: sets variables first; uses the last complete fetch where the quota is used up."""

from linkwright.stages.fetch.onshape.asking.cached_client import CachedClient
from linkwright.stages.fetch.onshape.asking.live import LiveAnswers
from linkwright.stages.fetch.onshape.asking.session import Session
from linkwright.stages.fetch.onshape.asking.variables import Variables
from linkwright.stages.fetch.onshape.gather import gather
from linkwright.stages.fetch.onshape.section import OnshapeSourceSection
from linkwright.stages.fetch.onshape.url import AssemblyUrl
from linkwright.stages.fetch.source import FetchContext, Fetched
from linkwright.stages.robot.bundle import OnshapeBundle
from linkwright.stages.robot.errors import Diagnostic, QuotaExhausted, SourceError


def fetch(keys: OnshapeSourceSection, context: FetchContext) -> Fetched:
    """The bundle of the assembly at `keys.url`; errors as `stages.fetch.fetch`."""
    url, calls = keys.url, context.calls
    with Session(keys, context) as session:
        client = CachedClient(
            session, context.replies, offline=keys.offline, refresh=keys.refresh, max_calls=keys.max_calls
        )
        client.began, client.while_waiting = context.began, context.while_waiting
        used = client
        found: tuple[Diagnostic, ...] = ()
        try:
            url = _with_variables(url, keys, client, session, context)
            answers = LiveAnswers(url, keys, client, context.progress)
            try:
                bundle = gather(answers)
            except QuotaExhausted as exhausted:
                if url.pinned:
                    raise
                used = CachedClient(
                    session, context.replies, offline=True, refresh=False, max_calls=keys.max_calls
                )
                answers = LiveAnswers(url, keys, used, context.progress)
                bundle = _fetched_last(answers, exhausted)
                found = (_quota(exhausted, accepted=keys.stale),)
        finally:
            session.account(calls)
            calls.saved = used.saved
    stale = bool(found) and not keys.stale
    diagnostics = (*answers.diagnostics, *found)
    title = answers.title()
    return Fetched(bundle, calls.made, calls.saved, diagnostics, title, stale, answers.lasts)


def _with_variables(
    url: AssemblyUrl,
    keys: OnshapeSourceSection,
    client: CachedClient,
    session: Session,
    context: FetchContext,
) -> AssemblyUrl:
    """The address of the assembly with its variables set; restores changes that an earlier build left."""
    variables = Variables(url, client, session, context.progress)
    client.undisturbed = variables.undisturbed
    variables.restore_left()
    return variables.applied(keys.variables) if keys.variables else url


def _fetched_last(answers: LiveAnswers, exhausted: QuotaExhausted) -> OnshapeBundle:
    """The bundle from cached replies only; raises `exhausted` where they are incomplete."""
    try:
        return gather(answers)
    except SourceError:
        raise exhausted from None


def _quota(exhausted: QuotaExhausted, *, accepted: bool) -> Diagnostic:
    msg = f"{exhausted.message}; this is the assembly as it was last fetched completely"
    hint = "build again when the quota is renewed, or with another key"
    if not accepted:
        hint += "; source.stale=true counts a build from the last fetch as success"
    return Diagnostic("W-QUOTA", msg, exhausted.where, hint)
