"""The assembly definition of a document, in the shape of Onshape's v16."""

import random

from tests.onshape import settings
from tests.onshape.document import Document
from tests.onshape.elements import Connector, Gear, Group, Mate

# Which of `mateLimits` bounds a mate's own motion.
LIMIT_NAMES = {
    "REVOLUTE": ("limitAxialZMin", "limitAxialZMax"),
    "SLIDER": ("limitZMin", "limitZMax"),
}


def definition(document: Document, *, configuration="default", shuffle=None, swap=(), limits=True):
    """The definition as plain data.

    `shuffle`: a seed that reorders instances, occurrences, features and parts (they mean the same).
    `swap`: names of mates whose two entities change places; their values and limits change sign.
    `limits`: False leaves limits out, as servers before 2026 do.
    """
    return _Writer(document, configuration, shuffle, frozenset(swap), limits).write()


class _Writer:
    def __init__(self, document, configuration, shuffle, swap, limits):
        self.document, self.configuration, self.swap, self.limits = document, configuration, swap, limits
        self.random = None if shuffle is None else random.Random(shuffle)

    def write(self):
        root = self.document.root
        poses = self.document.truth.poses()
        occurrences = [
            {
                "path": list(path),
                "transform": [float(number) for number in poses[path].ravel()],
                "fixed": place.instance.fixed,
                "hidden": place.instance.hidden,
            }
            for path, place in self.document.truth.places.items()
        ]
        written = {**self._assembly(root, self.configuration), "occurrences": self._shuffled(occurrences)}
        values = settings.values(self.document.parameters, self.configuration)
        written["fullConfiguration"] = settings.text_of(values) if values else self.configuration
        return {
            "rootAssembly": written,
            "subAssemblies": self._shuffled(
                [self._assembly(assembly, configuration) for assembly, configuration in self._subassemblies()]
            ),
            "parts": self._shuffled([self._part(part, setting) for part, setting in self._parts()]),
            "partStudioFeatures": [],
        }

    def _places(self):
        return [place.instance for place in self.document.truth.places.values()]

    def _subassemblies(self):
        used = {
            (i.source.element, i.configuration): (i.source, i.configuration)
            for i in self._places()
            if not i.is_part
        }
        return list(used.values())

    def _parts(self):
        used = {
            (i.source.studio.element, i.source.id, i.configuration): (i.source, i.configuration)
            for i in self._places()
            if i.is_part
        }
        return list(used.values())

    def _assembly(self, assembly, configuration):
        return {
            **_address(assembly, configuration),
            "instances": self._shuffled([self._instance(instance) for instance in assembly.instances]),
            "features": self._shuffled([self._feature(feature) for feature in assembly.features]),
            "patterns": [],
            "parametricInstances": [],
        }

    @staticmethod
    def _instance(instance):
        record = {"id": instance.id, "name": instance.name, "suppressed": instance.suppressed}
        if instance.is_part:
            part = instance.source
            record |= {"type": "Part", "partId": part.id, "isStandardContent": False}
            return record | _address(part.studio, instance.configuration)
        return record | {"type": "Assembly"} | _address(instance.source, instance.configuration)

    @staticmethod
    def _part(part, configuration):
        record = {
            "partId": part.id,
            "bodyType": part.body,
            "isStandardContent": False,
            **_address(part.studio, configuration),
        }
        if part.connectors:
            record["mateConnectors"] = [
                {"featureId": feature, "mateConnectorCS": _axes(frame)}
                for feature, frame in part.connectors.items()
            ]
        return record

    def _feature(self, feature):
        kinds = {
            Mate: ("mate", self._mate),
            Gear: ("mateRelation", self._gear),
            Group: ("mateGroup", self._group),
            Connector: ("mateConnector", self._connector),
        }
        kind, write = kinds[type(feature)]
        data = {"name": feature.name, **write(feature)}
        suppressed = getattr(feature, "suppressed", False)
        return {"id": feature.id, "featureType": kind, "suppressed": suppressed, "featureData": data}

    def _mate(self, mate):
        entities, (low, high) = mate.entities, mate.limits
        if mate.name in self.swap:
            entities = entities[::-1]
            low, high = (None if end is None else -end for end in (high, low))
        limits = zip(LIMIT_NAMES.get(mate.type, ()), (low, high), strict=False)
        made = {
            "mateType": mate.type,
            "mateLimits": {name: float(end) for name, end in limits if end is not None},
            "matedEntities": [
                {
                    "matedOccurrence": list(occurrence.path),
                    "matedCS": _axes(frame),
                    "mateConnectorCS": _axes(frame),
                }
                for occurrence, frame in entities
            ],
        }
        if not self.limits:
            del made["mateLimits"]
            for entity in made["matedEntities"]:
                del entity["mateConnectorCS"]
        return made

    def _gear(self, gear):
        swapped = sum(mate.name in self.swap for _, mate in gear.mates) == 1
        return {
            "relationType": "GEAR",
            "relationRatio": float(gear.ratio),
            "reverseDirection": gear.reverse != swapped,
            "mates": [{"featureId": mate.id, "occurrence": list(owner.path)} for owner, mate in gear.mates],
        }

    @staticmethod
    def _group(group):
        return {"occurrences": [{"occurrence": list(occurrence.path)} for occurrence, _ in group.members]}

    @staticmethod
    def _connector(connector):
        return {"occurrence": list(connector.occurrence.path), "mateConnectorCS": _axes(connector.frame)}

    def _shuffled(self, records):
        if self.random is not None:
            self.random.shuffle(records)
        return records


def _address(element, configuration):
    home = element.home
    address = {
        "documentId": home.id,
        "elementId": element.element,
        "documentMicroversion": home.microversion,
        "configuration": configuration,
        "fullConfiguration": configuration,
    }
    if home.linked:
        address["documentVersion"] = home.version
    return address


def _axes(frame):
    columns = {"xAxis": frame[:3, 0], "yAxis": frame[:3, 1], "zAxis": frame[:3, 2], "origin": frame[:3, 3]}
    return {name: [float(number) for number in column] for name, column in columns.items()}
