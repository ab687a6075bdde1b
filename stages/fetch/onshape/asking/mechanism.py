"""Gets only the replies that describe the mechanism of an assembly: its definition, and perhaps the masses of
its parts."""

from collections.abc import Callable, Sequence

from linkwright.stages.fetch.onshape import requests
from linkwright.stages.fetch.onshape.asking.cached_client import CachedClient
from linkwright.stages.fetch.onshape.asking.live import LiveAnswers
from linkwright.stages.fetch.onshape.gather import LimitReplies, Needs, Reply, StudioReplies
from linkwright.stages.fetch.onshape.replies.features import Owner
from linkwright.stages.robot.text.plural import count


class MechanismAnswers:
    """The replies of a server about the mechanism of an assembly.

    It asks for no triangles and no lists of features, and for mass properties only with `masses`. `answers`:
    all replies about the assembly, of which only the definition is taken.
    """

    def __init__(
        self, answers: LiveAnswers, client: CachedClient, progress: Callable[[str], None], *, masses: bool
    ) -> None:
        self._answers = answers
        self._client = client
        self._progress = progress
        self._masses = masses

    def versions(self) -> tuple[str, str]:
        return self._answers.versions()

    def configuration(self) -> str:
        return self._answers.configuration()

    def definition(self) -> Reply:
        return self._answers.definition()

    def studios(self, needs: Sequence[Needs]) -> Sequence[StudioReplies]:
        if not self._masses:
            return [StudioReplies((), None) for _ in needs]
        studio_requests = [requests.mass_properties(need.studio, need.root) for need in needs]
        calls = sum(self._client.lookup(request) is None for request in studio_requests)
        self._progress(f"{count(len(needs), 'part studio')}: {count(calls, 'call')} for their masses")
        bodies = self._client.all(studio_requests)
        return [StudioReplies((Reply(request, bodies[request]),), None) for request in studio_requests]

    def features(self, owners: Sequence[Owner], root: str) -> Sequence[LimitReplies]:
        return [LimitReplies(None) for _ in owners]
