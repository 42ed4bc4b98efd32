"""What the types of a scene cannot say: names that resolve, trees that are trees, numbers that make sense."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Iterable
from functools import partial
from typing import Any

import msgspec
import numpy as np

from warpmuscle.core.decoding import to_type
from warpmuscle.core.errors import SceneError
from warpmuscle.core.limits import GREATEST_NUMBER, LIMITS, check_size
from warpmuscle.core.plain_text import number_of
from warpmuscle.scene import Character, InitialState, Scene, drawable
from warpmuscle.scene.gait_states.checks import check_gait_states
from warpmuscle.scene.joints import joint_type
from warpmuscle.scene.joints.coupled import check_displacement
from warpmuscle.scene.number import Free
from warpmuscle.scene.parameters import constant_scene, free_parameters
from warpmuscle.scene.trusted_code import check_entries, named_code
from warpmuscle.scene.validation.checks import Checks, known, near
from warpmuscle.scene.validation.commands import check_commands
from warpmuscle.scene.validation.constraints import check_closed, check_constraints
from warpmuscle.scene.validation.contact import check_body_contact, check_ground, check_pairs
from warpmuscle.scene.validation.controller import check_control_rate, check_controller
from warpmuscle.scene.validation.forces import check_forces
from warpmuscle.scene.validation.impairments import check_impairments
from warpmuscle.scene.validation.learning import check_task
from warpmuscle.scene.validation.motion import check_motion
from warpmuscle.scene.validation.muscles import check_muscles
from warpmuscle.scene.validation.objective import check_objective, check_robustness, check_stages
from warpmuscle.scene.validation.objects import check_objects
from warpmuscle.scene.validation.skeleton import check_skeleton
from warpmuscle.scene.validation.water import check_water

SOUND = 64  # scenes that are remembered to be sound


def check_scene(scene: Scene) -> None:
    """Check everything about a scene that its types cannot.

    Raises:
        SceneError: the first thing wrong, with its key, such as `character.joints.lHip.parent`; indices in lists are
            numbers: `controller.states.0.trajectories.SWING_Hip.components.1.angle.3`.
    """
    known = constant_scene(scene)
    if known is not None and known.checked:
        return
    content = _content(scene)
    if content is None or content not in _sound:
        to_type(_plain(scene), Scene)  # a scene made in Python has not been checked against the types
        _Check(scene).scene()
        _remember(content)
    if known is not None:
        known.checked = True


_sound: dict[bytes, None] = {}  # contents of the scenes that were found to be sound last


def _content(scene: Scene) -> bytes | None:
    """A digest of all that decides whether a scene is sound, in a fiftieth of the time that this takes to find out.

    None where a scene holds what only Python has, such as numbers of NumPy.
    """
    try:
        text = msgspec.msgpack.encode(scene)
    except (TypeError, ValueError, OverflowError, RecursionError, msgspec.MsgspecError):
        return None
    return hashlib.sha256(text + repr(LIMITS).encode()).digest()


def _remember(content: bytes | None) -> None:
    if content is not None:
        _sound[content] = None
    for oldest in list(_sound)[:-SOUND]:
        _sound.pop(oldest, None)


class _Check(Checks):
    """The checks of one scene; each method raises SceneError or returns."""

    def scene(self) -> None:
        """Check the whole scene."""
        scene = self.checked
        check_commands(self)
        self.numbers()
        self.ranges("", scene)
        if not scene.name.strip():
            raise SceneError("the scene needs a name", key="name")
        self.sizes(scene)
        if scene.time_step > scene.duration:
            raise SceneError(
                f"time_step {scene.time_step:g} is longer than the duration {scene.duration:g}", "time_step"
            )
        check_entries(scene)
        for entry in scene.custom:
            known(entry, named_code(scene).values(), "part", f"custom.{entry}", "that this scene uses")
        self.names(scene)
        check_skeleton(self)
        check_constraints(self)
        self.feet(scene)
        check_muscles(self)
        check_impairments(self)
        check_motion(self)
        check_forces(self)
        check_controller(self)
        check_gait_states(self)
        self.initial_state(scene.initial_state, scene.character)
        check_closed(scene)
        check_ground(self)
        check_body_contact(self)
        check_objects(self)
        check_water(self)
        check_pairs(scene.failure.self_collision_pairs, scene.character, "failure.self_collision_pairs")
        check_objective(self, "objective", scene.objective)
        check_robustness("robustness", scene.robustness)
        self.tracking(scene)
        self.recorded_norms(scene)
        check_control_rate(self)
        check_stages(self)
        self.opensim(scene)
        check_task(self)

    def sizes(self, scene: Scene) -> None:
        """There is neither too much of anything, nor does it take too many steps."""
        parameters = len(free_parameters(scene))
        for name, size, key in (
            ("bodies", len(scene.character.bodies), "character.bodies"),
            ("muscles", len(scene.character.muscles), "character.muscles"),
            ("parameters", parameters, ""),
            ("steps", scene.duration / scene.time_step, "duration"),
            ("runs", scene.robustness.runs, "robustness.runs"),
        ):
            check_size(name, size, partial(SceneError, key=key))

    def opensim(self, scene: Scene) -> None:
        """The root has a coordinate for each of its displacements, and markers are on bodies."""
        model = scene.opensim
        if model is None:
            return
        moves = [] if model.root is None else [*model.root.rotations, *model.root.translations]
        if len(moves) != len(model.root_coordinates):
            message = (
                f"{number_of(len(model.root_coordinates), 'name')} for "
                f"{number_of(len(moves), 'displacement')} of the root"
            )
            raise SceneError(message, key="opensim.root_coordinates")
        for name, coupling in model.couplers.items():
            known(coupling.joint, scene.character.joints, "joint", f"opensim.couplers.{name}.joint")
            check_displacement(self, f"opensim.couplers.{name}", coupling)
        for name, marker in model.markers.items():
            known(marker.body, scene.character.bodies, "body", f"opensim.markers.{name}.body")
        for number, mesh in enumerate(model.meshes):
            known(mesh.body, scene.character.bodies, "body", f"opensim.meshes.{number}.body")
            if not drawable(mesh.file):
                message = "is the name of a .vtp, .stl or .obj file, without a folder"
                raise SceneError(message, key=f"opensim.meshes.{number}.file")

    def tracking(self, scene: Scene) -> None:
        """A tracked gait has one source, and joints of the character; a weight of tracking has a gait."""
        tracking = scene.tracking
        if tracking is None:
            return
        if bool(tracking.scene) == bool(tracking.file):
            raise SceneError("give either a scene or a file to track", key="tracking")
        for index, joint in enumerate(tracking.joints):
            known(joint, scene.character.joints, "joint", f"tracking.joints.{index}")
        for joint in tracking.weights:
            known(joint, scene.character.joints, "joint", f"tracking.weights.{joint}")

    def recorded_norms(self, scene: Scene) -> None:
        """Recorded gait cycles have a file."""
        if scene.norms is not None and not scene.norms.file:
            raise SceneError("name a result file with motions", key="norms.file")

    def numbers(self) -> None:
        """Every number is finite and of a size that can be computed with; what a number follows is a free parameter."""
        for key, number in self.every:
            if isinstance(number, Free) and number.same_as and number.same_as not in self.free:
                raise SceneError(self._why_not_followed(number.same_as, key), key=f"{key}.same_as")
            if isinstance(number, int | float | np.number) and not math.isfinite(number):
                raise SceneError(f"{number} is not a finite number", key=key)
            if isinstance(number, Free):
                self.computable(key, *self.interval(number), number.step)
            elif isinstance(number, float | np.floating):
                self.computable(key, float(number))

    def computable(self, key: str, *numbers: float) -> None:
        """Numbers are not beyond what single precision can multiply."""
        worst = max(map(abs, numbers))
        if not worst <= GREATEST_NUMBER:
            raise SceneError(
                f"{worst:g} is beyond {GREATEST_NUMBER:g}, the greatest number that a scene takes", key=key
            )

    def _why_not_followed(self, target: str, key: str) -> str:
        if target == key:
            return "a number cannot follow itself"
        if any(path == target and isinstance(number, Free) for path, number in self.every):
            return f"{target!r} follows another number itself; name that one instead"
        return f"{target!r} is not a free parameter{near(target, self.free)}"

    def names(self, scene: Scene) -> None:
        """Refuse names that no file can hold."""
        part = scene.character
        tables: dict[str, Iterable[str]] = {"bodies": part.bodies, "joints": part.joints, "muscles": part.muscles}
        tables["surfaces"] = part.surfaces
        keyed = [("name", scene.name), *((f"stages.{k}.name", stage.name) for k, stage in enumerate(scene.stages))]
        keyed += [(f"character.{what}", name) for what, table in tables.items() for name in table]
        keyed += [("forces", name) for name in scene.forces]
        for key, name in keyed:
            if "\0" in name or name != name.encode(errors="replace").decode():
                raise SceneError(f"{name!r} has a character that no file can hold", key=key)

    def feet(self, scene: Scene) -> None:
        """Feet are two bodies of the character."""
        key = "character.feet" if scene.character.feet is not None else "controller.feet"
        for index, foot in enumerate(scene.feet or ()):
            known(foot, scene.character.bodies, "body", f"{key}.{index}")
        if scene.feet is not None and scene.feet[0] == scene.feet[1]:
            raise SceneError(f"left and right are both {scene.feet[0]!r}", key=key)

    def initial_state(self, initial: InitialState, character: Character) -> None:
        """Orientations are rotations, and joints exist; a file has been read by now."""
        if initial.file:
            raise SceneError("is read with the scene's own file, or by `--set`", key="initial_state.file")
        for field in ("time", "replay"):
            if getattr(initial, field):
                raise SceneError("is used only with initial_state.file", key=f"initial_state.{field}")
        self.not_zero("initial_state.root_orientation", initial.root_orientation, "quaternion")
        for name, joint in initial.joints.items():
            key = f"initial_state.joints.{name}"
            known(name, character.joints, "joint", key)
            joint_type(character.joints[name]).check_state(self, key, joint)
        for name in initial.activations:
            known(name, character.muscles, "muscle", f"initial_state.activations.{name}")


def _plain(scene: Scene) -> Any:
    """The scene as dicts, lists and plain values; NumPy's scalars count as plain numbers."""

    def item(value: Any) -> Any:
        if getattr(value, "shape", None) == ():
            return value.item()
        raise SceneError(f"a scene cannot hold a {type(value).__name__}")

    return msgspec.to_builtins(scene, enc_hook=item)
