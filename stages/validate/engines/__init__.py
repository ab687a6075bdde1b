"""Physics engines as readers of model files: a module for each engine."""

from linkwright.stages.validate.compiled import Engine
from linkwright.stages.validate.engines import mujoco_engine

ENGINES: tuple[Engine, ...] = (mujoco_engine,)
