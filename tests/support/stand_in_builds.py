"""Builds that make nothing, in the place of the real one: for tests of what calls it."""

import os

from linkwright.pipeline.report import Report


def ended(plan, status=0, **more):
    """The report of a build of this plan with this exit status."""
    return Report("built", plan.name, str(plan.folder), plan.until, status, **more)


class Recorder:
    """A build that succeeds, and remembers its plans and the environment."""

    def __init__(self):
        self.plans, self.environs = [], []

    def __call__(self, plan):
        self.plans.append(plan)
        self.environs.append(dict(os.environ))
        return ended(plan)
