"""Variable studios: named expressions that a document's elements use."""

from dataclasses import dataclass, field

from tests.fake_onshape import ids


@dataclass(eq=False)
class VariableStudio:
    """A table of variables: name → (type, expression). `values`: name → its value as text, where that
    is not the expression itself."""

    home: object
    name: str
    table: dict = field(default_factory=dict)
    values: dict = field(default_factory=dict)

    @property
    def element(self):
        return ids.hex_id(self.home.name, self.name, "variable studio")

    def records(self):
        return [
            {
                "name": name,
                "type": kind,
                "expression": expression,
                "value": self.values.get(name, expression),
                "description": "",
            }
            for name, (kind, expression) in self.table.items()
        ]


def tables(home, element):
    """The variable tables that an element uses: its own, and those of all variable studios."""
    own = [studio for studio in home.variable_studios if studio.element == element]
    if own:
        return [{"variables": own[0].records()}]
    referred = [
        {
            "variableStudioReference": {"referenceElementId": studio.element, "entireVariableStudio": True},
            "variables": studio.records(),
        }
        for studio in home.variable_studios
    ]
    return [{"variables": []}, *referred]
