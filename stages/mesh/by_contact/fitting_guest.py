"""Guest process that fits ends for this project's own process: requests and replies are pickles."""

import pickle

from stages.mesh.by_contact.fitting import EndToFit


def answer(request: bytes) -> bytes:
    """To an `EndToFit`: its pieces, of those that it had before the number, and its `End`. To nothing:
    nothing."""
    if not request:
        return b""
    end: EndToFit = pickle.loads(request)
    given = {chunk: number for number, chunk in enumerate(chunk for start in end.starts for chunk in start)}
    made, fit = end.fitted()
    return pickle.dumps(([given.get(chunk, chunk) for chunk in made], fit))
