"""Damages of set-up files, of the model beside recordings, and of tables as other programs write them."""

from __future__ import annotations

from collections.abc import Callable
from random import Random

from damaging.damage import Damage, beheaded, changed_line, cut, spliced, written_elsewhere
from damaging.trial import Trial


def _replaced(what: str, name: str, old: bytes, new: bytes, told: str | None) -> Damage:
    """The first place of a text is another."""

    def change(trial: Trial, rng: Random) -> None:
        trial.edit(what, lambda data: data.replace(old, new, 1))

    return Damage(name, change, told)


def _setup(name: str, old: bytes, new: bytes, told: str | None) -> Damage:
    return _replaced("setup", name, old, new, told)


def _first_marker(name: str, new: Callable[[str], str], told: str | None) -> Damage:
    """The task of the first marker is another."""

    def change(trial: Trial, rng: Random) -> None:
        old = f'<IKMarkerTask name="{trial.marker_names[0]}">'
        trial.edit("setup", lambda data: data.replace(old.encode(), new(old).encode(), 1))

    return Damage(name, change, told)


def _no_markers(trial: Trial, rng: Random) -> None:
    trial.edit("setup", lambda data: data.replace(b"IKMarkerTask", b"IKSomeTask"))


def _coordinates_elsewhen(trial: Trial, rng: Random) -> None:
    trial.coordinates.times = trial.coordinates.times + 50.0


def _two_tasks(trial: Trial, rng: Random) -> None:
    trial.edit("setup", changed_line(6, lambda line: line + b"\n" + line.replace(b"<weight>1", b"<weight>7")))


SETUP: list[Damage] = [
    cut("setup", r"."), spliced("setup"), beheaded("setup"),
    _setup("another tool", b"InverseKinematicsTool", b"InverseKinematicsTools", r"not sound XML"),
    _setup("a set-up of scaling", b"IKTaskSet", b"ScaleTaskSet", r"not sound XML"),
    _setup("no table of coordinates", b"walk.mot", b"other.mot", r"no such file"),
    _setup("a folder for a table", b"walk.mot", b".", r"."),
    _setup("table unnamed", b"walk.mot", b"", r"coordinate_file"),
    _setup("another coordinate", b'<IKCoordinateTask name="', b'<IKCoordinateTask name="hoof_', r"does not have"),
    _setup("another kind of value", b"from_file", b"from_memory", r"value_type"),
    _setup("weight is a word", b"<weight>1<", b"<weight>much<", r"is not a number"),
    _setup("weight below zero", b"<weight>1<", b"<weight>-1<", r"0 or more"),
    _setup("weight is not a number", b"<weight>1<", b"<weight>nan<", r"is not a number"),
    _setup("weight is infinite", b"<weight>1<", b"<weight>inf<", r"is not a number|finite|beyond"),
    _setup("weight beyond measure", b"<weight>1<", b"<weight>1e300<", r"beyond"),
    _setup("times run back", b"<time_range>", b"<time_range>99 ", r"numbers|runs from"),
    _setup("times elsewhere", b"<time_range>0", b"<time_range>10", r"runs from|no frame"),
    _setup("one time", b"<time_range>", b"<time_range/><x_range>", r"not sound XML"),
    _setup("entities", b"<OpenSimDocument", b"<!DOCTYPE a [<!ENTITY x 'y'>]><OpenSimDocument", r"document type"),
    _first_marker("a marker of neither", lambda old: old.replace('name="', 'name="hoof_'), r"neither the model"),
    _first_marker("a marker without a name", lambda old: "<IKMarkerTask>", r"no name"),
    Damage("no markers", _no_markers, r"marker"),
    Damage("two tasks of one marker", _two_tasks, ""),
    Damage("coordinates of another time", _coordinates_elsewhen, r"reach|time"),
    *written_elsewhere("setup"),
]  # fmt: skip

MODEL: list[Damage] = [
    cut("model", r"."), spliced("model"), beheaded("model"),
    _replaced("model", "a body without mass", b"<mass>", b"<mass>-", r"."),
    _replaced("model", "mass is not a number", b"<mass>", b"<mass>nan ", r"."),
    _replaced("model", "another document", b"<Model", b"<Mode1", r"."),
    _replaced("model", "no bodies", b"<BodySet", b"<BodySets", r"."),
    *(damage for damage in written_elsewhere("model") if "commas" not in damage.name),
]  # fmt: skip

ELSEWHERE: dict[str, list[Damage]] = {
    what: written_elsewhere(what) for what in ("markers", "coordinates", "loads", "described", "emg")
}
