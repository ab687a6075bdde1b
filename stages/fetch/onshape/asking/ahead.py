"""Counts the calls that a fetch will make, once the definition of its assembly is known."""

from linkwright.stages.fetch.onshape import requests
from linkwright.stages.fetch.onshape.asking.cached_client import CachedClient
from linkwright.stages.fetch.onshape.asking.live import LiveAnswers
from linkwright.stages.fetch.onshape.definition import Definition
from linkwright.stages.fetch.onshape.gather import needs_of
from linkwright.stages.fetch.onshape.replies import features
from linkwright.stages.fetch.source import CallsAhead


def calls_ahead(answers: LiveAnswers, body: bytes, assembly: Definition, client: CachedClient) -> CallsAhead:
    """Returns the calls that `answers`, whose definition is `body`, will make for `assembly`."""
    pin, pending, exact = answers.ahead(needs_of(assembly))
    for owner in features.owners(body):
        request = requests.features(owner.key, assembly.document)
        kept = client.kept(request)
        if kept is None:
            pending[request] = ()
        # The variables that a list names are known once it is there.
        variables = requests.variables(owner.key, assembly.document)
        settled = kept is not None and not features.name_variables(kept, owner)
        exact = exact and (settled or client.kept(variables) is not None)
    return CallsAhead(pin, pending, exact)
