"""Ground forces as OpenSim's external loads: a `.mot` with forces, points and torques, and the `.xml` that names it."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Protocol
from xml.etree import ElementTree

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import Error
from warpmuscle.core.files import replace_file
from warpmuscle.core.plain_text import readable
from warpmuscle.formats.sto import storage_text

TO_OPENSIM = np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]])  # x forward, y up, z right


class Load(Protocol):
    """A force on a body over F frames, world axes."""

    @property
    def body(self) -> str: ...
    @property
    def force(self) -> Floats: ...  # (F, 3) N
    @property
    def point(self) -> Floats: ...  # (F, 3) m
    @property
    def torque(self) -> Floats: ...  # (F, 3) N m, about the point


def write_loads(loads: Sequence[Load], time: Floats, path: str | Path) -> Path:
    """Write a `.mot` and beside it, under the same name, the `.xml`, whose path is returned.

    Raises:
        Error: another suffix, or a file cannot be written.
    """
    path = Path(path)
    if path.suffix.lower() not in (".mot", ".sto"):
        raise Error(f"{path.name!r}: ground forces are written as .mot or .sto, and the .xml beside it")
    names, columns = ["time"], [np.asarray(time, np.float64)[:, None]]
    for load in loads:
        for what, values in (("force_v", load.force), ("force_p", load.point), ("torque_", load.torque)):
            names += [f"{load.body}_ground_{what}{axis}" for axis in "xyz"]
            columns.append(values @ TO_OPENSIM.T)
    described = path.with_suffix(".xml")
    replace_file(path, storage_text(readable(path.stem), names, np.concatenate(columns, axis=1)))
    replace_file(described, _xml(loads, path))
    return described


def _xml(loads: Sequence[Load], data: Path) -> str:
    """Text of the loads' description."""
    document = ElementTree.Element("OpenSimDocument", Version="40000")
    every = ElementTree.SubElement(document, "ExternalLoads", name=readable(data.stem))
    members = ElementTree.SubElement(every, "objects")
    for load in loads:
        entry = ElementTree.SubElement(members, "ExternalForce", name=f"{load.body}_ground")
        for tag, text in {
            "applied_to_body": load.body,
            "force_expressed_in_body": "ground",
            "point_expressed_in_body": "ground",
            "force_identifier": f"{load.body}_ground_force_v",
            "point_identifier": f"{load.body}_ground_force_p",
            "torque_identifier": f"{load.body}_ground_torque_",
        }.items():
            ElementTree.SubElement(entry, tag).text = text
    ElementTree.SubElement(document[0], "datafile").text = data.name
    ElementTree.indent(document)
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + ElementTree.tostring(document, encoding="unicode") + "\n"
