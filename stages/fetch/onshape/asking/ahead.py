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
    pin, pending, is_exact = answers.ahead(needs_of(assembly))
    for owner in features.owners(body):
        request = requests.features(owner.key, assembly.document)
        cached_list = client.lookup(request)
        if cached_list is None:
            pending[request] = ()
        # The variables that a list names are known once it is there.
        variables = requests.variables(owner.key, assembly.document)
        is_settled = cached_list is not None and not features.name_variables(cached_list, owner)
        is_exact = is_exact and (is_settled or client.lookup(variables) is not None)
    return CallsAhead(pin, pending, is_exact)
