"""Many cases of one kind: a few in every run, the others in the slow suite."""

import pytest


def mostly_slow(cases, keep):
    """The cases for `pytest.mark.parametrize`, with all but the first `keep` of them marked slow."""
    marked = []
    for index, case in enumerate(cases):
        if index < keep:
            marked.append(case)
        else:
            values = case if isinstance(case, tuple) else (case,)
            marked.append(pytest.param(*values, marks=pytest.mark.slow))
    return marked
