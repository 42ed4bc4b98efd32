"""Set-up files of OpenSim's inverse kinematics and scaling tools: weights of markers, measurements, what to place."""

from __future__ import annotations

from dataclasses import dataclass, field
from os import PathLike
from pathlib import Path

from warpmuscle.core.errors import SceneError
from warpmuscle.formats.osim.elements import Element, parse


@dataclass(frozen=True)
class CoordinateTask:
    """What a coordinate should be besides."""

    weight: float
    kind: str  # default_value: as in the model; manual_value; from_file
    value: float = 0.0  # rad or m, of a manual value


@dataclass(frozen=True)
class Tasks:
    """Weights of markers and coordinates in a fit; those that are not applied are left out."""

    file: Path
    markers: dict[str, float] = field(default_factory=dict)
    coordinates: dict[str, CoordinateTask] = field(default_factory=dict)
    times: tuple[float, float] | None = None  # s, of the frames that count
    coordinate_file: str = ""  # as it stands in the set-up


@dataclass(frozen=True)
class Measurement:
    """How far pairs of markers are apart, in mean, and which bodies are scaled by that along which axes."""

    name: str
    line: int
    pairs: tuple[tuple[str, str], ...]
    bodies: dict[str, str]  # names of axes of each, such as `XYZ`


@dataclass(frozen=True)
class ScaleSetup:
    """How a generic model becomes one of a subject."""

    file: Path
    mass: float | None  # kg
    keep_mass_distribution: bool
    order: tuple[str, ...]  # measurements, manualScale
    measurements: tuple[Measurement, ...]
    factors: dict[str, tuple[float, float, float]]  # by body, given by hand
    times: tuple[float, float] | None  # s, of the frames that are measured
    tasks: Tasks  # of the pose in which markers are placed
    place: bool  # whether markers are placed
    marker_file: str  # names of files, as they stand in the set-up; empty if they do not
    placer_file: str
    model_file: str


def read_tasks(path: str | PathLike[str]) -> Tasks:
    """The tasks of an `InverseKinematicsTool`, or of a file with an `IKTaskSet` alone.

    Raises:
        SceneError: it cannot be read, or holds no such set; with file and line.
    """
    root = parse(Path(path))
    top = _first(root, "InverseKinematicsTool")
    tasks = _first(top or root, "IKTaskSet")
    if tasks is None:
        root.fail("holds no <IKTaskSet>: the set-up of an InverseKinematicsTool is needed")
    return _tasks(Path(path), tasks, _times(top), _word(top, "coordinate_file"))


def read_scale_setup(path: str | PathLike[str]) -> ScaleSetup:
    """The set-up of a `ScaleTool`.

    Raises:
        SceneError: it cannot be read, or is none; with file and line.
    """
    path = Path(path)
    root = parse(path)
    top = _first(root, "ScaleTool")
    if top is None:
        root.fail("holds no <ScaleTool>")
    scaler, placer, maker = (_first(top, tag) for tag in ("ModelScaler", "MarkerPlacer", "GenericModelMaker"))
    task_set = _first(placer, "IKTaskSet")
    file = _word(placer, "coordinate_file")
    tasks = _tasks(path, task_set, _times(placer), file) if task_set is not None else Tasks(path)
    mass = _child(top, "mass")
    keep = _child(scaler, "preserve_mass_distribution")
    order = _child(scaler, "scaling_order")
    given = mass.number() if mass is not None and mass.words() else 0.0
    return ScaleSetup(
        path,
        given if given > 0.0 else None,
        keep.truth() if keep is not None and keep.words() else False,
        tuple(order.words()) if order is not None else ("measurements",),
        tuple(_measurement(one) for one in _members(scaler, "MeasurementSet", "Measurement") if _applied(one)),
        dict(_factors(one) for one in _members(scaler, "ScaleSet", "Scale") if _applied(one)),
        _times(scaler),
        tasks,
        placer is not None and _applied(placer),
        *(_word(holder, tag) for holder, tag in (
            (scaler, "marker_file"), (placer, "marker_file"), (maker, "model_file"),
        )),
    )  # fmt: skip


def _tasks(path: Path, holder: Element, times: tuple[float, float] | None, coordinate_file: str) -> Tasks:
    found = Tasks(path, times=times, coordinate_file=coordinate_file)
    for one in holder.all():
        if one.tag not in ("IKMarkerTask", "IKCoordinateTask") or not _applied(one):
            continue
        weight = _child(one, "weight")
        value = weight.number() if weight is not None and weight.words() else 1.0
        if not value >= 0.0:
            one.fail(f"its weight must be 0 or more, not {value:g}")
        if not one.name:
            one.fail("has no name")
        if one.tag == "IKMarkerTask":
            found.markers[one.name] = value
        elif value > 0.0:
            kind = _word(one, "value_type") or "manual_value"
            given = _child(one, "value")
            if kind not in ("default_value", "manual_value", "from_file"):
                one.fail(f"its value_type {kind!r} is none of default_value, manual_value, from_file")
            number = given.number() if given is not None and given.words() and kind == "manual_value" else 0.0
            found.coordinates[one.name] = CoordinateTask(value, kind, number)
    return found


def _measurement(one: Element) -> Measurement:
    pairs, bodies = [], {}
    for pair in _members(one, "MarkerPairSet", "MarkerPair"):
        markers = _child(pair, "markers")
        words = markers.words() if markers is not None else []
        if len(words) != 2:
            pair.fail(f"needs the names of two markers, has {len(words)}")
        pairs.append((words[0], words[1]))
    for body in _members(one, "BodyScaleSet", "BodyScale"):
        axes = _child(body, "axes")
        found = "".join(axes.words()).upper() if axes is not None else ""
        if not found or set(found) - set("XYZ"):
            body.fail(f"its axes are some of X Y Z, not {found!r}")
        bodies[body.name] = found
    if not pairs and bodies:
        one.fail("has no pairs of markers; switch it off by <apply>false</apply>")
    return Measurement(one.name, one.line, tuple(pairs), bodies)


def _factors(one: Element) -> tuple[str, tuple[float, float, float]]:
    scales = _child(one, "scales")
    if scales is None:
        one.fail("has no <scales>")
    x, y, z = scales.numbers(3)
    if min(x, y, z) <= 0.0:
        one.fail(f"a body is scaled by positive factors, not {x:g} {y:g} {z:g}")
    return _word(one, "segment"), (x, y, z)


def _times(holder: Element | None) -> tuple[float, float] | None:
    found = _child(holder, "time_range")
    if found is None or not found.words():
        return None
    low, high = found.numbers(2, infinite=True)
    if low > high:
        raise SceneError(f"its time_range runs from {low:g} back to {high:g} s", file=found.file, line=found.line)
    return low, high


def _first(holder: Element | None, tag: str) -> Element | None:
    return next((one for one in holder.all() if one.tag == tag), None) if holder is not None else None


def _child(holder: Element | None, tag: str) -> Element | None:
    return holder.child(tag) if holder is not None else None


def _word(holder: Element | None, tag: str) -> str:
    found = _child(holder, tag)
    word = found.word() if found is not None else ""
    return "" if word in ("Unassigned", "Unassigned.") else word


def _members(holder: Element | None, tag: str, kind: str) -> list[Element]:
    found = _first(holder, tag)
    return [one for one in found.all() if one.tag == kind] if found is not None else []


def _applied(one: Element) -> bool:
    found = _child(one, "apply")
    return found.truth() if found is not None and found.words() else True
