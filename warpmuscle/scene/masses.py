"""How heavy a character and its muscles are; the heats of a muscle are rates a kilogram of it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from msgspec.structs import replace

from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import SceneError
from warpmuscle.core.number_rows import first_number
from warpmuscle.scene import Body, Character, Muscle, MuscleModel, Scene
from warpmuscle.scene.muscles import is_cable
from warpmuscle.scene.parameters import at_start

DENSITY = 1059.7  # kg/m^3 (Mendez 1960)
COMMON_TENSION = 2.5e5  # Pa, the default of OpenSim's probes and of SCONE
TINY_MASS = 1e-9  # kg, which can be divided by where nothing has a mass
LARGEST_SHARE = 0.45  # of the body; in women 0.31 of it is skeletal muscle, in men 0.38 (Janssen 2000)


def muscle_mass(muscle: Muscle, tension: Any) -> Any:
    """Mass of a numeric muscle, kg, from its specific tension, Pa; an array (n,) if any of its numbers is one.

    Mass = density f_max l_opt / specific tension (Umberger 2003; Wang 2012). None of an actuator or a ligament.
    """
    if is_cable(muscle):
        return 0.0
    return DENSITY * np.asarray(muscle.f_max) * np.asarray(muscle.l_opt) / np.asarray(tension)


def specific_tension(muscle: Muscle, model: MuscleModel) -> Any:
    """Specific tension of a muscle, Pa: its own, or that of all muscles."""
    return model.specific_tension if muscle.specific_tension is None else muscle.specific_tension


def muscle_masses(muscles: Sequence[Muscle], model: MuscleModel) -> list[float]:
    """Mass of each of some numeric muscles, kg; of an instance, where they have numbers of their own, the first."""
    return [first_number(muscle_mass(muscle, specific_tension(muscle, model))) for muscle in muscles]


def total_mass(muscles: Sequence[Muscle], model: MuscleModel) -> float:
    """Mass of numeric muscles together, kg."""
    return sum(muscle_masses(muscles, model))


def common_mass(muscles: Sequence[Muscle]) -> float:
    """Mass of numeric muscles together, kg, if all had the specific tension that other programs take."""
    return sum(first_number(muscle_mass(muscle, COMMON_TENSION)) for muscle in muscles)


def at_common_tension(scene: Scene) -> Scene:
    """The scene with muscles that all have the specific tension that other programs take."""
    muscles = {name: replace(muscle, specific_tension=None) for name, muscle in scene.character.muscles.items()}
    character = replace(scene.character, muscles=muscles)
    return replace(
        scene, character=character, muscle_model=replace(scene.muscle_model, specific_tension=COMMON_TENSION)
    )


def massless(body: Body) -> bool:
    """Whether a body is nothing but a place between joints."""
    return all(map(is_zero, (body.mass, *body.inertia)))


def is_zero(number: Any) -> bool:
    """Whether a number of a scene is 0, and no parameter."""
    return isinstance(number, int | float) and number == 0.0


def body_mass(character: Character) -> float:
    """Mass of a numeric character, kg."""
    return float(sum(first_number(body.mass) for body in character.bodies.values()))


def center_of_mass(character: Character, positions: Mapping[str, Floats]) -> Floats:
    """Centre of mass (3,) of a numeric character, m, from positions (3,) of its bodies; 0 where nothing has a mass."""
    moments = [first_number(body.mass) * positions[name] for name, body in character.bodies.items()]
    return np.asarray(np.sum(moments, axis=0) / max(body_mass(character), TINY_MASS))


def muscle_mass_text(muscles: Sequence[Muscle], model: MuscleModel) -> str:
    """Mass and specific tension of some numeric muscles in words, and what other programs would take.

    An example: 27.5 kg of muscle at 0.6 MPa (66 kg at 0.25 MPa).
    """
    mass, common = total_mass(muscles, model), common_mass(muscles)
    tensions = [first_number(specific_tension(muscle, model)) for muscle in muscles]
    low, high = min(tensions), max(tensions)
    text = f"{mass:.3g} kg of muscle at {low / 1e6:.3g} MPa"
    if low < high:
        text += f" to {high / 1e6:.3g} MPa, {COMMON_TENSION * common / mass / 1e6:.3g} MPa in the mean"
    same = low == high == COMMON_TENSION
    return text if same else f"{text} ({common:.3g} kg at {COMMON_TENSION / 1e6:g} MPa)"


def mass_warnings(scene: Scene) -> list[SceneError]:
    """Whether a character has more muscle than a body has room for, free parameters at their start values.

    Args:
        scene: checked scene.

    Returns:
        Nothing, or an error that is not raised, so that a reader can give it file and line.
    """
    if not scene.character.muscles:
        return []
    plain = at_start(scene)
    mass = total_mass(list(plain.character.muscles.values()), plain.muscle_model)
    body = body_mass(plain.character)
    if mass <= LARGEST_SHARE * body or body == 0.0:
        return []
    message = (
        f"{mass:.3g} kg of muscle are {100.0 * mass / body:.3g} % of a body of {body:.3g} kg, where people have 31 to "
        "38 %, so that metabolic energy comes out too high; check specific_tension (Pa), f_max (N) and l_opt (m)"
    )
    return [SceneError(message, key="muscle_model.specific_tension")]
