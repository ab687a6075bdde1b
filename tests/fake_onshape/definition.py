"""The assembly definition of a document, in the shapes of Onshape's v16 and v17."""

import random

from tests.fake_onshape import settings
from tests.fake_onshape.elements import Connector, Group, Mate, Relation
from tests.fake_onshape.mates import FREEDOMS, bounds


def definition(document, *, configuration="default", shuffle=None, limits=True):
    """The definition as plain data.

    `shuffle`: a seed that reorders instances, occurrences, features, patterns and parts (they mean the same).
    `limits`: False leaves limits out, as recordings of versions before v17 do.
    """
    return _Writer(document, configuration, shuffle, limits).write()


class _Writer:
    def __init__(self, document, configuration, shuffle, limits):
        self.document, self.configuration, self.limits = document, configuration, limits
        self.random = None if shuffle is None else random.Random(shuffle)

    def write(self):
        root = self.document.root
        poses = self.document.truth.poses()
        occurrences = [
            {
                "path": list(path),
                "transform": [float(number) for number in poses[path].ravel()],
                "fixed": place.instance.fixed or path in self.document.truth.tree.held,
                "hidden": place.instance.hidden,
            }
            for path, place in self.document.truth.places.items()
        ]
        written = {**self._assembly(root, self.configuration), "occurrences": self._shuffled(occurrences)}
        values = settings.values(self.document.parameters, self.configuration)
        written["fullConfiguration"] = settings.text_of(values) if values else self.configuration
        return {
            "rootAssembly": written,
            "subAssemblies": self._shuffled([self._assembly(*used) for used in self._used(False)]),
            "parts": self._shuffled([self._part(*used) for used in self._used(True)]),
            "partStudioFeatures": [],
        }

    def _used(self, parts):
        """[(source, configuration)] of the parts, or of the sub-assemblies, in use: each once."""
        used = {}
        for place in self.document.truth.places.values():
            instance = place.instance
            if instance.is_part == parts:
                source, setting = instance.source, instance.configuration
                key = (source.studio.element, source.id, setting) if parts else (source.element, setting)
                used[key] = source, setting
        return list(used.values())

    def _assembly(self, assembly, configuration):
        patterns = [_pattern(pattern) for pattern in assembly.patterns if pattern.type != "MIRROR"]
        mirrors = [_mirror(pattern) for pattern in assembly.patterns if pattern.type == "MIRROR"]
        return {
            **_address(assembly, configuration),
            "instances": self._shuffled([self._instance(instance) for instance in assembly.instances]),
            "features": self._shuffled([self._feature(feature) for feature in assembly.features]),
            "patterns": self._shuffled(patterns),
            "parametricInstances": self._shuffled(mirrors),
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
            Relation: ("mateRelation", self._relation),
            Group: ("mateGroup", self._group),
            Connector: ("mateConnector", self._connector),
        }
        kind, write = kinds[type(feature)]
        data = {"name": feature.name, **write(feature)}
        suppressed = getattr(feature, "suppressed", False)
        return {"id": feature.id, "featureType": kind, "suppressed": suppressed, "featureData": data}

    def _mate(self, mate):
        limits = bounds(mate.type, mate.limits)
        made = {
            "mateType": mate.type,
            "matedEntities": [],
            "mateLimits": {
                name: float(end)
                for freedom, pair in zip(FREEDOMS[mate.type], limits, strict=True)
                for name, end in zip(freedom.limit_names, pair, strict=True)
                if end is not None
            },
        }
        for occurrence, frame in mate.entities[: 1 if mate.broken else 2]:
            entity = {"matedOccurrence": list(occurrence.path), "matedCS": _axes(frame)}
            made["matedEntities"].append(entity | ({"mateConnectorCS": _axes(frame)} if self.limits else {}))
        if not self.limits:
            del made["mateLimits"]
        return made

    def _relation(self, relation):
        return {
            "relationType": relation.type,
            "relationLength" if relation.by_length else "relationRatio": float(relation.amount),
            "reverseDirection": relation.reverse,
            "mates": [
                {"featureId": mate.id, "occurrence": list(owner.path)} for owner, mate in relation.mates
            ],
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


def _pattern(pattern):
    return {
        "id": pattern.id,
        "type": pattern.type,
        "name": pattern.name,
        "suppressed": False,
        "seedToPatternInstances": {
            seed.last.id: [copy.last.id for copy in copies]
            for seed, copies in zip(pattern.seeds, pattern.copies, strict=True)
        },
    }


def _mirror(pattern):
    return {
        "id": pattern.id,
        "type": "Mirror",
        "name": pattern.name,
        "suppressed": False,
        "children": [
            {"instanceIds": [copy.last.id for copy in copies], "seedOccurrence": seed.last.id}
            for seed, copies in zip(pattern.seeds, pattern.copies, strict=True)
        ],
    }


def _axes(frame):
    columns = {"xAxis": frame[:3, 0], "yAxis": frame[:3, 1], "zAxis": frame[:3, 2], "origin": frame[:3, 3]}
    return {name: [float(number) for number in column] for name, column in columns.items()}
