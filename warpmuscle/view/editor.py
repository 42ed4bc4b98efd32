"""A session of changes to the numbers and curves of a scene by hand: what pages are sent, undo, and what is saved."""

from __future__ import annotations

import math
import re
import shlex
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import msgspec

from warpmuscle.core.limits import GREATEST_NUMBER
from warpmuscle.core.plain_text import few_of
from warpmuscle.formats import toml
from warpmuscle.scene import Scene
from warpmuscle.scene.number import Free
from warpmuscle.scene.parameters import free_parameters, leaves, start_values, substitute
from warpmuscle.view.editing.names import shown_unit
from warpmuscle.view.editing.numbers import Editable, editable, slider_range
from warpmuscle.view.edits import Edits, Point, edited, key_now
from warpmuscle.view.messages import Edit
from warpmuscle.view.packing import encodable

MOST_POINTS = 64  # of a curve
UNDOS = 200  # that can be taken back
ONE_CHANGE = 1.0  # s between two changes of one number that are taken back as one
NAMED = 8  # changes that the description of a saved scene names

ASKS = ("save", "settings", "points")  # edits that change nothing

Target = tuple[str, ...]


class Editor:
    """What was changed of a scene so far.

    Attributes:
        scene: as it is now. edits: what was changed of the one that it began with.
        pending: whether that is yet to be used by the simulation: then call `accept`, or `refuse`.
    """

    def __init__(self, scene: Scene, clock: Callable[[], float] = time.monotonic) -> None:
        self._first, self._clock = scene, clock
        self.numbers, self.curves = editable(scene)
        self._curve = {one.key: one for one in self.curves}
        self.scene, self.edits, self.pending = scene, Edits(), False
        self._good = scene, Edits(), 0
        self._before: list[Edits] = []
        self._undone: list[Edits] = []
        self._last: tuple[Target, float] = ((), -math.inf)
        self._begin = self._numbers()

    def takes(self, edit: Edit) -> bool:
        """Whether a page may have sent this."""
        of_curve = edit.edit in ("move", "insert", "remove", "straighten", "points")
        several = len(self.curves) if of_curve else len(self.numbers) if edit.edit == "number" else 0
        given = [number for number in (edit.at, edit.value) if number is not None]
        if not all(math.isfinite(number) and abs(number) <= GREATEST_NUMBER for number in given):
            return False
        wanted = {"move": 2, "insert": 2, "number": len(given)}.get(edit.edit, 0)
        if len(given) != wanted or (edit.edit == "number" and edit.at is not None):
            return False
        return 0 <= edit.target < max(several, 1) and 0 <= edit.point <= MOST_POINTS

    def use(self, edit: Edit) -> str:
        """Change what a page asks for; returns why not, in a line, else nothing."""
        if edit.edit in ("undo", "redo"):
            self._go(edit.edit)
        elif edit.edit == "back":
            self._put(Edits(), ("back",))
        elif edit.edit == "number":
            self.set_number(self.numbers[edit.target].key, edit.value)
        elif edit.edit not in ASKS:
            return self._bend(edit)
        return ""

    def set_number(self, key: str, value: float | None) -> None:
        """Give a number of the scene another value, or its own if None; of a knot that is gone nothing happens."""
        owner, name, place = (*key.rsplit(".", 2), "", "")[:3]
        curve = self._curve.get(owner)
        if curve is not None and name in (curve.across, curve.along):
            points = [
                one if str(one.origin) != place else one._replace(at=value) if name == curve.across
                else one._replace(value=value)
                for one in self.edits.points(curve)
            ]  # fmt: skip
            self._put_points(curve.key, points, (curve.key, place))
            return
        numbers = {**self.edits.numbers, key: value}
        target = (key, "back") if value is None else (key,)
        self._put(replace(self.edits, numbers={k: v for k, v in numbers.items() if v is not None}), target)

    def _bend(self, edit: Edit) -> str:
        """Change a curve."""
        curve = self.curves[edit.target]
        points = list(self.edits.points(curve))
        if edit.edit == "straighten":
            curves = {key: one for key, one in self.edits.curves.items() if key != curve.key}
            self._put(replace(self.edits, curves=curves), (curve.key, "back"))
            return ""
        if edit.edit == "insert":
            if len(points) >= MOST_POINTS:
                return f"a curve has {MOST_POINTS} points at most here"
            points.insert(edit.point, Point(-1, edit.at, edit.value))
        elif edit.point >= len(points):
            return ""  # another page has taken it out
        elif edit.edit == "move":
            points[edit.point] = Point(points[edit.point].origin, edit.at, edit.value)
        else:
            del points[edit.point]
        place = str(edit.point) if edit.edit == "move" else f"{edit.edit} {len(points)}"
        self._put_points(curve.key, points, (curve.key, place))
        return ""

    def _put_points(self, key: str, points: list[Point], target: Target) -> None:
        own = tuple(points) == tuple(Point(place) for place in range(self._curve[key].knots))
        curves = {name: one for name, one in self.edits.curves.items() if name != key or not own}
        self._put(replace(self.edits, curves=curves if own else {**curves, key: tuple(points)}), target)

    def _put(self, edits: Edits, target: Target) -> None:
        """Go on with other changes, which can be taken back together with the last ones of the same target."""
        now = self._clock()
        if edits == self.edits:
            return
        if self._last[0] != target or now - self._last[1] > ONE_CHANGE or not self._before:
            self._before = [*self._before, self.edits][-UNDOS:]
        self._undone, self._last = [], (target, now)
        self.edits, self.pending = edits, True

    def _go(self, where: str) -> None:
        there, other = (self._before, self._undone) if where == "undo" else (self._undone, self._before)
        if there:
            other.append(self.edits)
            self.edits, self.pending, self._last = there.pop(), True, ((), -math.inf)

    def make(self) -> Scene:
        """The scene with the changes; raises SceneError if it cannot have them."""
        return edited(self._first, self._curve, self.edits)

    def accept(self, scene: Scene) -> None:
        """The simulation goes on with this scene, as `make` made it."""
        self.scene, self.pending = scene, False
        self._good = scene, self.edits, len(self._before)

    def refuse(self) -> None:
        """The simulation cannot go on so: back to the last changes with which it did."""
        self.scene, self.edits, kept = self._good
        self._before, self._undone, self.pending = self._before[:kept], [], False
        self._last = ((), -math.inf)

    def only_controller(self) -> bool:
        """Whether the changes since the last accepted ones are in the controller, and nothing else follows those."""
        before = self._good[1]
        keys = {key for key in (*before.numbers, *self.edits.numbers)
                if before.numbers.get(key) != self.edits.numbers.get(key)}  # fmt: skip
        keys |= {key for key in (*before.curves, *self.edits.curves)
                 if before.curves.get(key) != self.edits.curves.get(key)}  # fmt: skip
        return all(key.startswith("controller.") for key in keys) and not self._followed_outside

    @property
    def _followed_outside(self) -> bool:
        return any(
            isinstance(leaf, Free) and leaf.same_as.startswith("controller.") and not key.startswith("controller.")
            for key, leaf in leaves(self._first)
        )

    def for_page(self) -> dict[str, Any]:
        """What the page is sent about all numbers and curves as the scene has them."""
        groups = list(dict.fromkeys(one.group for one in (*self.curves, *self.numbers)))
        places = {one.key: place for place, one in enumerate(self.numbers)}
        follows = {key: leaf.same_as for key, leaf in leaves(self._first) if isinstance(leaf, Free)}
        numbers = []
        for one in self.numbers:
            value = self._begin[one.key]
            field = next(name for name in reversed(one.path) if not name.isdigit())
            low, high = slider_range(field, one.unit, value)
            unit, factor = shown_unit(one.unit)
            entry = self._named(one, groups) | {"value": value, "min": low, "max": high}
            entry |= {"unit": encodable(unit), "factor": factor}
            numbers.append(entry | ({"follows": encodable(follows[one.key])} if follows.get(one.key) else {}))
        curves = [
            self._named(one, groups)
            | self._knots(one.key, one.across, one.along, self._begin)
            | {"straight": one.straight, "duration": places.get(one.duration, -1)}
            for one in self.curves
        ]
        names = [encodable(group) for group in groups]
        return {"groups": names, "numbers": numbers, "curves": curves, "most": MOST_POINTS}

    def _named(self, one: Editable, groups: list[str]) -> dict[str, Any]:
        return {"group": groups.index(one.group), "name": encodable(one.name), "unit": encodable(one.unit),
                "key": encodable(one.key)}  # fmt: skip

    def values(self) -> dict[str, Any]:
        """What differs from the scene as it was, and what can be taken back."""
        now = self._numbers()
        numbers = {place: now[one.key] for place, one in enumerate(self.numbers)
                   if now.get(one.key) != self._begin[one.key]}  # fmt: skip
        curves = {}
        for place, one in enumerate(self.curves):
            knots = self._knots(one.key, one.across, one.along, now)
            if knots != self._knots(one.key, one.across, one.along, self._begin):
                curves[place] = knots
        return {"numbers": numbers, "curves": curves, "undo": len(self._before), "redo": len(self._undone),
                "moved": [place for place, one in enumerate(self.numbers) if one.key in self.edits.numbers],
                "bent": [place for place, one in enumerate(self.curves) if one.key in self.edits.curves]}  # fmt: skip

    def parameters(self) -> dict[str, float]:
        """Values of free parameters as they are now, by the names that they had; without those that are gone."""
        now = {parameter.name: parameter.value for parameter in free_parameters(self.scene)}
        names = {parameter.name: key_now(self._curve, self.edits, parameter.name) for parameter in
                 free_parameters(self._first)}  # fmt: skip
        return {name: now[key] for name, key in names.items() if key is not None and key in now}

    def _numbers(self) -> dict[str, float]:
        """Plain numbers by key, where commands are at their references."""
        scene = self.scene
        references = {name: one.reference for name, one in scene.commands.items()}
        plain = substitute(scene, start_values(scene), references)
        found: dict[str, Any] = {}
        for key, leaf in _leaves(scene):
            for name in leaf.per if isinstance(leaf, Free) else ():
                found |= {f"{key}.per.{below}": rate.value if isinstance(rate, Free) else rate
                          for below, rate in leaf.rates(name)}  # fmt: skip
        return found | {key: leaf for key, leaf in _leaves(plain) if isinstance(leaf, int | float)}

    def _knots(self, key: str, across: str, along: str, numbers: Mapping[str, float]) -> dict[str, Any]:
        knots: dict[str, list[float]] = {"at": [], "along": []}
        while (place := f"{key}.{across}.{len(knots['at'])}") in numbers:
            knots["along"].append(numbers[f"{key}.{along}.{len(knots['at'])}"])
            knots["at"].append(numbers[place])
        return knots

    def answer(self, edit: Edit) -> dict[str, Any]:
        """What pages are sent where one of them asks for the scene as it is."""
        if edit.edit == "save":
            name, text = self.file()
            return {"saved": {"name": name, "text": text}}
        return {"copied": self.settings() if edit.edit == "settings" else self.points(edit.target)}

    def file(self) -> tuple[str, str]:
        """Name and text of a TOML file of the scene as it is now."""
        name = f"{self._first.name}_edited"
        text = toml.dumps(msgspec.structs.replace(self.scene, name=name, description=self._description()))
        return re.sub(r"[^\w-]+", "_", name, flags=re.ASCII)[:80] + ".toml", encodable(text)

    def settings(self) -> str:
        """A command that simulates the scene with the changes."""
        now, edits = self._numbers(), self.edits
        values = [f"{key}={_short(now[key])}" for key in edits.numbers if key in now]
        for curve in map(self._curve.__getitem__, edits.curves):
            knots = self._knots(curve.key, curve.across, curve.along, now)
            lists = {curve.across: _list(knots["at"]), curve.along: _list(knots["along"])}
            if curve.knots:
                values += [f"{curve.key}.{name}={value}" for name, value in lists.items()]
            else:  # the scene has no such curve
                inner = ", ".join(f"{name} = {value}" for name, value in lists.items())
                values.append(f"{curve.key}={{ {inner} }}")
        options = "".join(f" \\\n  --set {shlex.quote(encodable(value))}" for value in values)
        return f"warpmuscle simulate {shlex.quote(encodable(self._first.name))}{options}"

    def points(self, target: int) -> str:
        """A curve as it is now, as lines of a scene's TOML file."""
        curve = self.curves[target]
        knots = self._knots(curve.key, curve.across, curve.along, self._numbers())
        at, along = _list(knots["at"]), _list(knots["along"])
        return encodable(f"# {curve.key}\n{curve.across} = {at}\n{curve.along} = {along}\n")

    def _description(self) -> str:
        """How the scene came about."""
        now, edits = self._numbers(), self.edits
        words = [f"{key} = {now.get(key, value):.6g}" for key, value in edits.numbers.items()]
        words += [f"points of {key}" for key in edits.curves]
        if not words:
            return self._first.description
        return f"{self._first.name}, changed by hand in the live viewer: {few_of(words, NAMED)}."


def _short(number: float) -> str:
    """A number as TOML, with the digits that matter to a simulation in single precision."""
    return repr(float(f"{number:.9g}"))


def _list(numbers: Sequence[float]) -> str:
    return f"[{', '.join(map(_short, numbers))}]"


def _leaves(scene: Scene) -> Any:
    """Leaves of what can be edited."""
    yield from leaves(scene.controller, "controller")
    yield from leaves(scene.custom_controller_parameters, "custom_controller_parameters")
    yield from leaves(scene.character.muscles, "character.muscles")
