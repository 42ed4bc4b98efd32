"""What a run of a sweep, `--set` or `load(set=...)` changes in a scene: numbers, tables, groups, sizes of bodies.

A key is the dotted path of a value in the scene, such as `objective.target_speed` or `controller.states.0.time`; or a
pattern of paths, whose parts may have `*`, `?` and `[...]`: `character.muscles.?SOL.f_max`; or `scale.BODY`, likewise
with patterns.

A value replaces what is there; a table is put into a table that is there, as in a scene that is based on another one,
but replaces a number: `{ value = 0.7, min = 0.5, max = 0.9 }`. Numbers that follow a number (`same_as`) go on following
it, also if it is no longer free. A value `{ factor = 0.5 }` multiplies the numbers with these keys and no others (see
`scaling.multiplied`). The value of `scale.BODY` is the factor of its lengths (see `scaling.scaled_segments`); with
`{ factor = 0.9, muscles = true }` the lengths of fibres and tendons follow, as by OpenSim's ScaleTool.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any

import msgspec

from warpmuscle.core.arguments import as_kind
from warpmuscle.core.decoding import to_type
from warpmuscle.core.errors import SceneError
from warpmuscle.formats.recorded.start import with_recorded_start
from warpmuscle.formats.toml import merge
from warpmuscle.scene import Scene
from warpmuscle.scene.number import Free
from warpmuscle.scene.parameters import leaves, rebuilt
from warpmuscle.scene.scaling import multiplied, scaled_segments
from warpmuscle.scene.validation.checks import near
from warpmuscle.scene.validation.scene import check_scene

SCALE = "scale"
BY_JOINT = ("actuation", "initial_state.joints")


@dataclass(frozen=True)
class Override:
    """One change of a scene, and the line in which it stands; 0 if it stands in no file."""

    key: str
    value: Any
    line: int = 0


def with_values(scene: Scene, values: Mapping[str, Any] | None) -> Scene:
    """The scene with other values by key, as of `load`; the scene itself without any.

    Raises:
        ArgumentError: values that are no mapping. SceneError: see `overridden`.
    """
    if values is None:
        return scene
    return overridden(scene, [Override(str(key), value) for key, value in as_kind(dict, values, "set").items()])


@dataclass(frozen=True)
class Changed:
    """A scene with some changes, which may not be sound before others have followed."""

    scene: Scene
    touched: Mapping[str, Override]  # by path of what it has changed


def changed(before: Changed, overrides: Sequence[Override], file: Path | None = None) -> Changed:
    """The same with further changes, one after the other; raises SceneError as `overridden`."""
    scene, touched = before.scene, dict(before.touched)
    for override in overrides:
        try:
            scene, paths = _applied(scene, override)
        except SceneError as error:
            raise _placed(error, override, file) from None
        touched |= dict.fromkeys(paths, override)
    return Changed(scene, touched)


def overridden(scene: Scene, overrides: Sequence[Override], file: Path | None = None) -> Scene:
    """The scene with these changes, one after the other; it is not changed itself.

    Raises:
        SceneError: with file, line and key of the override that cannot be made, or that leaves no sound scene.
    """
    return sound(changed(Changed(scene, {}), overrides, file), file)


def sound(found: Changed, file: Path | None = None) -> Scene:
    """The scene with its changes, checked; raises SceneError as `overridden`."""
    scene, touched = found.scene, found.touched
    try:
        scene = with_recorded_start(scene, [Path() if file is None else file.parent])
        check_scene(scene)
    except SceneError as error:
        wrong = error.key
        guilty = max(touched, key=lambda path: (_in_line(path, wrong), _common(path, wrong)), default="")
        if not guilty or _common(guilty, wrong) == 0:
            raise
        raise _placed(error, touched[guilty], file) from None
    return scene


def is_factor(value: Any) -> bool:
    """Whether this value multiplies, rather than replaces."""
    return isinstance(value, dict) and set(value) == {"factor"}


def _placed(error: SceneError, override: Override, file: Path | None) -> SceneError:
    """The error at the override's place; it names the override, and the path of what is wrong if that is another."""
    key = override.key
    message = error.message if error.key in ("", key) else f"{error.key}: {error.message}"
    return SceneError(message, key, file, override.line if file is not None else 0)


def _common(path: str, other: str) -> int:
    """How many parts two paths have in common from the front."""
    parts = zip(path.split("."), other.split("."), strict=False)
    return next((i for i, (a, b) in enumerate(parts) if a != b), min(path.count("."), other.count(".")) + 1)


def _in_line(path: str, other: str) -> bool:
    """Whether one of two paths leads through the other."""
    return f"{path}.".startswith(f"{other}.") or f"{other}.".startswith(f"{path}.")


def _applied(scene: Scene, override: Override) -> tuple[Scene, Iterable[str]]:
    """The scene with one change, and the paths of what it has changed."""
    key, value = override.key, override.value
    names = key.split(".")
    if names[0] == SCALE and len(names) == 2:
        factor, muscles = _size(value)
        bodies = matching(names[1:], ((body,) for body in scene.character.bodies))
        if not bodies:
            raise SceneError(f"no body is called {names[1]!r}{near(names[1], scene.character.bodies)}")
        chosen = {body: factor for (body,) in bodies}
        return scaled_segments(scene, chosen, muscles), [f"character.bodies.{body}" for body in chosen]
    if not is_factor(value) and not is_pattern(key):
        return _with(scene, [(names, value)]), [key]
    every = {tuple(path.split(".")): leaf for path, leaf in leaves(scene)}
    matched = matching(names, every)
    if not matched:
        check_exists(scene, names)
        raise SceneError(f"no number has a path of this pattern{_fitting(names, every)}")
    paths = [".".join(path) for path in matched]
    if not is_factor(value):
        return _with(scene, [(list(path), value) for path in matched]), paths
    if not isinstance(value["factor"], int | float) or isinstance(value["factor"], bool):
        raise SceneError("the factor must be a number")
    return multiplied(scene, dict.fromkeys(paths, float(value["factor"]))), paths


def _fitting(pattern: Sequence[str], paths: Iterable[tuple[str, ...]]) -> str:
    """A hint at the first part of a pattern that fits no path, and at what is there in its place."""
    left = list(paths)
    for depth, part in enumerate(pattern):
        known = sorted({path[depth] for path in left if len(path) > depth})
        left = [path for path in left if len(path) > depth and fnmatchcase(path[depth], part)]
        if not left:
            return f": nothing fits {part!r}{near(part, known)}" if known else ""
    return ""


def _size(value: Any) -> tuple[float, bool]:
    """The factor of a body's lengths, and whether those of its muscles follow."""
    muscles = False
    if isinstance(value, dict) and set(value) <= {"factor", "muscles"}:
        value, muscles = value.get("factor"), value.get("muscles", False)
    if isinstance(value, bool) or not isinstance(value, int | float) or not isinstance(muscles, bool):
        message = "a body is scaled by a number, the factor of its lengths, or by { factor = 0.9, muscles = true }"
        raise SceneError(message)
    return float(value), muscles


def is_pattern(key: str) -> bool:
    """Whether a path stands for others."""
    return any(character in key for character in "*?[")


def matching(pattern: Sequence[str], paths: Iterable[tuple[str, ...]]) -> list[tuple[str, ...]]:
    """The paths of which each part matches the part of the pattern."""
    return [
        path
        for path in paths
        if len(path) == len(pattern) and all(fnmatchcase(a, b) for a, b in zip(path, pattern, strict=True))
    ]


def _with(scene: Scene, values: Sequence[tuple[list[str], Any]]) -> Scene:
    """The scene with values at paths."""
    data = _plain(scene)
    for names, value in values:
        check_exists(scene, names, isinstance(value, dict))
        _put(data, scene, names, value)
    changed = to_type(data, Scene)
    leaf_at = dict(leaves(changed))
    replaced = {".".join(names) for names, _ in values}

    def following(path: str, leaf: Any) -> Any:
        """A number that follows one that is no longer free, or follows itself, as that one is."""
        if not isinstance(leaf, Free) or leaf.same_as not in replaced or path in replaced:
            return leaf
        source = leaf_at.get(leaf.same_as)
        if isinstance(source, Free):
            return _following_through(leaf, source, path) if source.same_as else leaf
        return leaf.following(source) if isinstance(source, int | float) else leaf

    return rebuilt(changed, following)


def _following_through(leaf: Free, source: Free, path: str) -> Free:
    """A number that follows a number which itself follows one now: it follows that one."""
    if not source.through:
        if not leaf.through:
            return Free(same_as=source.same_as, factor=leaf.factor * source.factor)
        if source.factor == 1.0:
            return Free(same_as=source.same_as, through=leaf.through)
    elif not leaf.through:
        points = tuple((at, value * leaf.factor) for at, value in source.through)
        return Free(same_as=source.same_as, through=points)
    raise SceneError(f"goes through points over {leaf.same_as}, which follows {source.same_as} now", key=path)


def _put(data: Any, scene: Scene, names: list[str], value: Any) -> None:
    """Put a value at a path into the data of a scene, from which values that equal their defaults are missing."""
    node: Any = scene
    for name in names[:-1]:
        node = _member(node, name)
        if isinstance(data, list):
            data = data[int(name)]
        else:
            data = data.setdefault(name, {} if node is None else _plain(node))
    last = names[-1]
    node = _member(node, last)
    if isinstance(data, list):
        data[int(last)] = value
    elif isinstance(value, dict) and isinstance(node, msgspec.Struct | dict | list) and not isinstance(node, Free):
        data.setdefault(last, _plain(node))
        merge(data, {last: value})
    else:
        data[last] = value


def check_exists(scene: Scene, names: list[str], new: bool = False) -> None:
    """Raise SceneError with a hint unless a path leads to something.

    Args:
        new: the last part may be a new entry of a table of named things, such as a joint's in `actuation`; one of a
            table of plain values, such as a stage's in place of the objective's, may be new in any case.
    """
    node: Any = scene
    for depth, name in enumerate(names):
        if node is None:  # a table that the scene has not got so far; its type is checked later
            return
        if is_pattern(name):
            return
        known = _names(node)
        if ".".join(names[:depth]) in BY_JOINT:  # tables in which a joint may be named for the first time
            known = list(dict.fromkeys([*known, *scene.character.joints]))
        if name not in known:
            of_parts = isinstance(node, dict) and any(isinstance(part, msgspec.Struct) for part in node.values())
            if depth == len(names) - 1 and isinstance(node, dict) and (new or not of_parts):
                return
            place = ".".join(names[:depth])
            hint = near(name, known)
            if not hint and known:
                hint = f"; there {'is' if len(known) == 1 else 'are'} {', '.join(known[:12])}" + (
                    ", ..." if len(known) > 12 else ""
                )
            raise SceneError(f"unknown key: there is no {name!r} in {place or 'a scene'}{hint}")
        node = _member(node, name)


def _plain(part: Any) -> Any:
    """A part of a scene as tables, lists and plain values, as a file would hold it."""
    return msgspec.json.decode(msgspec.json.encode(part))


def _names(node: Any) -> list[str]:
    """Names of what a part of a scene has; those of a number are what a free parameter has."""
    if isinstance(node, msgspec.Struct):
        return list(node.__struct_fields__)
    if isinstance(node, dict):
        return list(node)
    return [str(index) for index in range(len(node))] if isinstance(node, list | tuple) else []


def _member(node: Any, name: str) -> Any:
    if isinstance(node, dict):
        return node.get(name)
    if isinstance(node, list | tuple):
        return node[int(name)] if name.isdigit() and int(name) < len(node) else None
    return getattr(node, name, None)
