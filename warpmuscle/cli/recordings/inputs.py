"""What `warpmuscle inverse` is given: motions, loads, EMG and reserves, from files and options."""

from __future__ import annotations

import warnings
from typing import TYPE_CHECKING

from warpmuscle.core.errors import Error
from warpmuscle.core.plain_text import number_of

if TYPE_CHECKING:
    from pathlib import Path

    from warpmuscle.inverse.body_model import BodyModel
    from warpmuscle.inverse.emg import Emg
    from warpmuscle.inverse.kinematics import Kinematics
    from warpmuscle.inverse.trial import Coordinates, Loads

C3D = ".c3d"
MARKERS = (".trc", C3D)  # files of markers rather than coordinates


def read_motions(
    paths: list[Path], body: BodyModel, setup: Path | None, device: str | None, up: str | None, forward: str | None
) -> tuple[list[Kinematics | None], list[Coordinates]]:
    """What fits the markers of files, and the coordinates of all."""
    fitted = [_fitted(path, body, setup, device, up, forward) for path in paths]
    return fitted, [_motion(path, body, own) for path, own in zip(paths, fitted, strict=True)]


def _fitted(
    path: Path, body: BodyModel, setup: Path | None, device: str | None, up: str | None, forward: str | None
) -> Kinematics | None:
    """What fits the markers of a file; None of a file of coordinates."""
    if path.suffix.lower() not in MARKERS:
        return None
    from warpmuscle.inverse.files import read_markers
    from warpmuscle.inverse.kinematics import inverse_kinematics

    markers = path if up is None and forward is None else read_markers(path, up=up, forward=forward)
    return inverse_kinematics(body.scene, markers, setup=setup, device=device)


def _motion(path: Path, body: BodyModel, fitted: Kinematics | None) -> Coordinates:
    """Coordinates of a file, or those that fit its markers."""
    from warpmuscle.inverse.files import read_coordinates

    return read_coordinates(path, body.scene) if fitted is None else fitted.coordinates


def read_all_loads(
    paths: list[Path], motions: list[Path], up: str | None, forward: str | None, needed: bool
) -> list[Loads | None]:
    """Loads of all trials; without any, if they are needed, those of the plates of a C3D that has the markers."""
    from warpmuscle.inverse.loads import read_loads

    count = len(motions)
    if len(paths) not in (0, 1, count):
        given = f"{number_of(len(paths), 'time')} for {number_of(count, 'motion')}"
        raise Error(f"--loads is given {given}; give it once, or once for each")
    if not paths:
        return [_plates_in(path, up, forward) if needed and path.suffix.lower() == C3D else None for path in motions]
    found: list[Loads | None] = [read_loads(path, up=up, forward=forward) for path in paths]
    return found * count if len(found) == 1 else found


def _plates_in(path: Path, up: str | None, forward: str | None) -> Loads | None:
    """Loads of the plates of a C3D, which says so if it has none."""
    from warpmuscle.inverse.laboratory.c3d_plates import loads_of_c3d
    from warpmuscle.inverse.trial import TrialWarning

    found = loads_of_c3d(path, up, forward)
    if found is None:
        warnings.warn(
            f"{path} has no force plates, and there is no --loads: what the ground carries is left to the root, and "
            "moments of legs are wrong by it",
            TrialWarning, stacklevel=2,
        )  # fmt: skip
    return found


def predicted_loads(
    body: BodyModel, motions: list[Coordinates], loads: list[Path] | None, cutoff: float | None
) -> list[Loads | None]:
    """Ground forces of all trials that the motions need."""
    from warpmuscle.inverse.without_plates.ground_forces import ground_forces

    if loads:
        raise Error("--no-plates finds the ground's forces, so --loads gives none; leave one of them out")
    return [ground_forces(body, motion, cutoff) for motion in motions]


def read_all_emg(paths: list[Path], count: int, body: BodyModel, channels: list[str]) -> list[Emg | None]:
    """EMG of all trials."""
    from warpmuscle.inverse.emg import read_emg

    if len(paths) not in (0, count):
        raise Error(
            f"--emg is given {number_of(len(paths), 'time')} for {number_of(count, 'motion')}; give it once for each"
        )
    if channels and not paths:
        raise Error("--channel says which channel of --emg is of a muscle, and there is no --emg")
    named = _named(channels)
    return [read_emg(path, body.muscles, named or None) for path in paths] or [None] * count


def _named(channels: list[str]) -> dict[str, str]:
    """Channels by muscle."""
    found: dict[str, str] = {}
    for text in channels:
        muscle, equals, name = (part.strip() for part in text.partition("="))
        if not (muscle and equals and name):
            raise Error(f"--channel {text!r} is not MUSCLE=NAME; write soleus_r=EMG1")
        if muscle in found:
            raise Error(f"--channel is given twice for {muscle!r}; leave one out")
        found[muscle] = name
    return found


def reserves_of(given: list[str]) -> float | dict[str, float]:
    """Strengths of reserves: one for all, or by name beside it."""
    from warpmuscle.inverse.activations import RESERVE

    common, named = RESERVE, {}
    for text in given:
        name, equals, value = text.rpartition("=")
        try:
            number = float(value)
        except ValueError:
            raise Error(f"--reserve {text!r}: {value!r} is not a number; write 0.1 or knee_angle_r=10") from None
        if equals:
            named[name.strip()] = number
        else:
            common = number
    return {"": common} | named if named else common
