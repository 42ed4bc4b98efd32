"""Scenes of a sweep as they are searched: what nothing uses is found for all that differ in numbers only at once."""

from __future__ import annotations

from collections.abc import Sequence

from warpmuscle.core.errors import Error
from warpmuscle.model.unused_parameters import of_the_body, unused_in, unused_parameters
from warpmuscle.optimization.optimize import searched_without, weighed
from warpmuscle.scene import Scene
from warpmuscle.scene.parameters import free_parameters, start_values
from warpmuscle.sweep.union import MergedScene, groups

AT_ONCE = 4096  # parameters of scenes whose models lie side by side: some 100 MB


def weighed_scenes(scenes: Sequence[Scene]) -> list[Scene | Error]:
    """Each scene with an objective and free parameters, or why it has none."""
    found: list[Scene | Error] = []
    for scene in scenes:
        try:
            found.append(weighed(scene))
        except Error as error:
            found.append(error)
    return found


def searched_scenes(scenes: Sequence[Scene | Error]) -> list[Scene | Error]:
    """Each scene as `optimization.optimize.searched` has it, or why it cannot be searched; see `weighed_scenes`."""
    found = list(scenes)
    sound = [(number, scene) for number, scene in enumerate(scenes) if isinstance(scene, Scene)]
    for group in groups([scene for _, scene in sound]):
        members = [sound[place] for place in group]
        each = max(AT_ONCE // max(len(free_parameters(members[0][1])), 1), 1)
        for first in range(0, len(members), each):
            part = members[first : first + each]
            for (number, scene), names in zip(part, _unused([scene for _, scene in part]), strict=True):
                try:
                    found[number] = names if isinstance(names, Error) else searched_without(scene, names)
                except Error as error:
                    found[number] = error
    return found


def _unused(scenes: Sequence[Scene]) -> Sequence[list[str] | Error]:
    """Names of unused parameters of scenes of a group, or why they cannot be told."""
    try:
        if len(scenes) == 1:
            return [unused_parameters(scenes[0])]
        own = [of_the_body(scene) for scene in scenes]
        merged = MergedScene(own)
        return unused_in(merged.scene, [(free_parameters(one), start_values(one)) for one in own], merged.values)
    except Error as error:
        return [error] * len(scenes)
