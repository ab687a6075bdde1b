"""What an author writes: part studios, parts, assemblies, mates. SI units, radians.

    document = Document("Door")
    studio = document.studio("Parts")
    frame = studio.part("Frame", solids.box(1, 0.1, 2), density=700)
    leaf = studio.part("Leaf", solids.box(0.9, 0.04, 1.9), density=700)
    door = document.assembly("Door")
    post = door.add(frame, fixed=True)
    wing = door.add(leaf)
    door.revolute("Hinge", (wing, frame_on_wing), (post, frame_on_post), value=0.3, limits=(0, 1.5))

A mate's value q is the pose of its first entity's mate frame in its second's: Rz(q) or Tz(q), or what
`mates` says for the others. The author gives values; all poses follow from them (`kinematics`). A mate
that closes a loop is declared with `closing=True`; its value is whatever the rest makes it.
"""

import copy

from tests.fake_onshape import ids, settings
from tests.fake_onshape.assembly import Assembly
from tests.fake_onshape.elements import ORIGIN, Occurrence, Studio
from tests.fake_onshape.variables import VariableStudio

__all__ = ["ORIGIN", "Assembly", "Document", "Home", "Occurrence"]


class Home:
    """Where elements live: a document, and its pinned state.

    `tabs`: element ids of tabs that an edit changed → their own microversions since then.
    """

    def __init__(self, name, document=None):
        self.name = name
        self.document = document or self
        self.id = ids.hex_id(name, "document")
        self.workspace = ids.hex_id(name, "workspace")
        self.version = ids.hex_id(name, "version")
        self.microversion = ids.hex_id(name, "microversion")
        self.studios, self.assemblies, self.variable_studios = [], [], []
        self.tabs = {}

    def tab_microversion(self, element):
        """The microversion of an element alone, which only its own edits change."""
        return self.tabs.get(element.element) or ids.hex_id(self.name, "microversion", element.element)

    def part(self, name):
        """The first part of that name."""
        return next(part for studio in self.studios for part in studio.parts if part.name == name)

    def studio(self, name):
        """A new part studio."""
        self.studios.append(Studio(self, name))
        return self.studios[-1]

    def variable_studio(self, name, table, values=None):
        """A new variable studio: name → (type, expression)."""
        self.variable_studios.append(VariableStudio(self, name, dict(table), dict(values or {})))
        return self.variable_studios[-1]

    def assembly(self, name):
        """A new assembly."""
        self.assemblies.append(Assembly(self, name))
        self.document.changed()
        return self.assemblies[-1]

    @property
    def linked(self):
        """Whether this is another document, used through one of its versions."""
        return self.document is not self


class Document(Home):
    """A document; its first assembly is the root unless `root` says otherwise.

    What the document knows about itself (`tree`, `poses`, `mass_matrix`, ...) is in `truth`.
    """

    def __init__(self, name):
        super().__init__(name)
        self.libraries, self.values, self._truth, self._root = [], {}, None, None
        self.parameters, self._build, self._variants = (), None, {}
        self.driven = None

    def configure(self, parameters, build):
        """Gives the root assembly configurations: `build(values)` makes the document in one of them.

        `values`: parameter id → text. This document is the one in the default configuration.
        """
        self.parameters, self._build = tuple(parameters), build

    def at(self, configuration):
        """The document with its root in a configuration: Onshape's text for it."""
        values = settings.values(self.parameters, configuration)
        if not self.parameters or configuration in ("", settings.DEFAULT):
            return self
        if configuration not in self._variants:
            made = self._variants[configuration] = self._build(values)
            made.microversion, made.tabs = self.microversion, self.tabs
        return self._variants[configuration]

    def with_variables(self, element, table):
        """A copy with another table in one variable studio; `driven(document, expressions)` changes what
        depends on it."""
        after = self.edited()
        studio = next(tab for tab in after.variable_studios if tab.element == element)
        studio.table = dict(table)
        after.tabs[element] = ids.hex_id(after.microversion, element)
        if after.driven is not None:
            rows = [row for tab in after.variable_studios for row in tab.table.items()]
            after.driven(after, {name: expression for name, (_, expression) in rows})
            after.changed()
        return after

    def edited(self, *tabs):
        """A copy to change, at a new microversion; of its elements those named `tabs` have a new one."""
        after = copy.deepcopy(self)
        after.microversion = ids.hex_id(self.microversion, "edited")
        after._variants = {}
        for element in [*after.studios, *after.assemblies]:
            if element.name in tabs:
                after.tabs[element.element] = ids.hex_id(after.microversion, element.element)
        after.changed()
        return after

    def library(self, name):
        """Another document, linked by version: parts and assemblies of it can be used here."""
        self.libraries.append(Home(name, self))
        return self.libraries[-1]

    @property
    def homes(self):
        return [self, *self.libraries]

    @property
    def root(self):
        return self._root or self.assemblies[0]

    @root.setter
    def root(self, assembly):
        self._root = assembly
        self.changed()

    def set_value(self, owner, mate, value):
        """The value of a mate inside one occurrence of its assembly (else the mate's own)."""
        self.values[owner.path, mate.id] = value
        self.changed()

    def changed(self):
        """Forget what was derived; the builder's own methods call this."""
        self._truth = None

    @property
    def truth(self):
        """The document's own kinematics and dynamics: a `truth.Truth`."""
        if self._truth is None:
            from tests.fake_onshape.truth import Truth

            self._truth = Truth(self)
        return self._truth
