"""Free numbers of a scene with states of gait as SCONE's file of parameters."""

from __future__ import annotations

import re
from collections.abc import Collection
from pathlib import Path

from warpmuscle.formats.lines import Ignored
from warpmuscle.formats.scone.controller import LEGS, THRESHOLDS
from warpmuscle.formats.scone.numbers import AUTO_FACTOR, LEAST_SPREAD
from warpmuscle.formats.scone.parameters import Parameter, write_parameters
from warpmuscle.formats.scone.reflexes import OF_ANGLE, OF_MOTOR, OF_MUSCLE, OF_POINT
from warpmuscle.scene import GaitReflex, GaitStates, Scene
from warpmuscle.scene.parameters import free_parameters

PREFIX = re.compile(r"(S[01]{5})_(.+)")
UNNAMED = "SCONE has no parameter of this name; left out"


def parameter_name(path: str, scene: Scene) -> str:
    """SCONE's name of a free number of a scene; empty if it has none."""
    table, _, rest = path.partition(".")
    if table == "forces":
        return _motor_name(rest, scene)
    if table != "gait_states" or scene.gait_states is None:
        return ""
    if rest.startswith("patterns."):
        return _pattern_name(rest.removeprefix("patterns."), scene.gait_states)
    reflex, _, field = rest.removeprefix("reflexes.").rpartition(".")
    if reflex == "noise":
        return f"{field}_noise"
    if reflex in ("", "right"):
        leg = LEGS["right" if reflex else "left"] if scene.gait_states.right is not None else ""
        return next((f"{leg}{word}" for word, own in THRESHOLDS.items() if own == field), "")
    one = scene.gait_states.reflexes.get(reflex)
    if one is None:
        return ""
    name = _prefixed(reflex, one.muscle, scene.gait_states.reflexes)
    word = _word(one, field)
    if field in ("within_low", "within_high"):
        return f"{name}-{one.within_joint}.{word}"
    return f"{name}.{word}" if word else ""


def _motor_name(path: str, scene: Scene) -> str:
    """SCONE's name of a number of a reflex that drives a motor."""
    name, _, field = path.partition(".parameters.")
    axis, _, what = field.partition("_")
    words = [word for word, own in OF_MOTOR.items() if own == what]
    reflex = scene.forces[name].scone_names.get(axis, "") if name in scene.forces else ""
    return f"{reflex}.{words[0]}" if reflex and words else ""


def _prefixed(key: str, muscle: str, keys: Collection[str]) -> str:
    """The name of a key, which may begin with states or the controller's name, and end with a number of its own."""
    first, _, number = key.rpartition("_")
    if number.isdecimal() and first in keys:  # the same name, as SCONE has it for several reflexes
        key = first
    start, own, rest = key.partition(f"_{muscle}")
    if own and (not rest or rest[0] in "-_"):
        return f"{start}.{muscle}{rest}"
    found = PREFIX.fullmatch(key)
    return f"{found[1]}.{found[2]}" if found is not None else key


def _pattern_name(path: str, states: GaitStates) -> str:
    """SCONE's name of a value or an interval of a pattern."""
    key, _, rest = path.partition(".")
    field, _, index = rest.partition(".")
    if key not in states.patterns or not index.isdigit():
        return ""
    value = "C" if states.patterns[key].shape == "polynomial" else "Y"
    name = _prefixed(key, states.patterns[key].muscle, states.patterns)
    return f"{name}.{value if field == 'values' else 'DT'}{index}"


def _word(reflex: GaitReflex, field: str) -> str:
    """What SCONE calls a number of a reflex."""
    own = {"delay": "delay", "within_low": "pos_min", "within_high": "pos_max"}
    positions = reflex.point is not None or reflex.balance is not None
    angles = bool(reflex.joint) or reflex.turn is not None
    for word, name in (OF_POINT if positions else OF_ANGLE if angles else OF_MUSCLE).items():
        own.setdefault(name, word)
    return own.get(field, "")


def write_scene_parameters(scene: Scene, path: Path) -> list[Ignored]:
    """Write the free numbers of a scene as a .par file; those that SCONE has no name for.

    Before them stand the offsets and the load by which its scenario came to its start. Best value and mean are those
    that the scene starts from, the spread that which SCONE gives where there is none.

    Raises:
        SceneError: the file cannot be written.
    """
    rows, lost = dict[str, Parameter](), []
    for name, value in scene.initial_state.scone_parameters.items():
        rows[name] = _row(name, value)
    for one in free_parameters(scene):
        name = parameter_name(one.name, scene)
        if not name:
            lost.append(Ignored(path, 0, one.name, UNNAMED))
        elif name not in rows:
            rows[name] = _row(name, one.value)
        elif rows[name].best != one.value:
            lost.append(Ignored(path, 0, one.name, f"SCONE has one number {name} for several of them; the first stays"))
    write_parameters(path, rows.values())
    return lost


def _row(name: str, value: float) -> Parameter:
    return Parameter(name, value, value, max(AUTO_FACTOR * abs(value), LEAST_SPREAD))
