"""What the muscles of a recorded motion spend, how much of their force is passive, and whether they tremble."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
import warp as wp
from msgspec.structs import replace

from warpmuscle.core.array_types import Floats
from warpmuscle.core.number_rows import first_number
from warpmuscle.kernels.muscle import effort
from warpmuscle.kernels.muscle.metabolics import DOWN, UP
from warpmuscle.model.build import muscles_model
from warpmuscle.model.muscle_shapes import shaped_kind
from warpmuscle.results.recording import Recording
from warpmuscle.scene import Scene
from warpmuscle.scene.accounting import basal_rate
from warpmuscle.scene.masses import at_common_tension, body_mass
from warpmuscle.scene.muscles import law_of

TREMBLING = 15.0  # Hz, beyond which there is none of the control of a gait
LEAST_LENGTH = 1e-6  # m, of a fibre
STEEPEST = 0.995  # sine of the pennation, as of the shortest fibre
LEAST_SPEED = 0.2  # m/s, below which energy over distance says little
FORMULAS = {
    "wang": effort.WANG, "umberger": effort.UMBERGER, "bhargava": effort.BHARGAVA, "margaria": effort.MARGARIA,
}  # fmt: skip


BHARGAVA_NET, BHARGAVA_STRICT = "cost of transport, Bhargava net", "cost of transport, Bhargava strict"


class Spent(NamedTuple):
    """What muscles spend, in the mean over a motion."""

    power: float  # W/kg, metabolic, of the muscles and of the body at rest, over the mass of the body
    common_power: float  # the same with muscles of the mass that other programs take, see `masses.COMMON_TENSION`
    passive_share: float  # of the tension of all muscles


def spent(recording: Recording, scene: Scene) -> Spent | None:
    """Metabolic power of the muscles, by the model of the scene's objective, and the passive share of their forces.

    Torques cost nothing here: of a scene that they help to drive, only the muscles count.

    Args:
        scene: without free parameters.

    Returns:
        None without muscles, or where these have no curves of the package: ideal, legacy, or with custom curves.
    """
    if not _has_costs(recording, scene):
        return None
    rest = first_number(basal_rate(scene.objective))
    mass = body_mass(scene.character)
    passive, power = (float(values.sum(axis=1).mean()) for values in _passive_and_power(recording, scene))
    common = float(muscle_power(recording, at_common_tension(scene)).sum(axis=1).mean())
    tension = float(recording.muscle_force.sum(dtype=float))
    share = min(passive * recording.frames / tension, 1.0) if tension > 0.0 else 0.0
    return Spent(rest + power / mass, rest + common / mass, share)


def bhargava_costs(recording: Recording, scene: Scene, speed: float) -> dict[str, float | None]:
    """The cost of transport by Bhargava's formula in two ways, J/(kg m), with 1.2 W/kg at rest; none without muscles.

    Net: lengthening fibres give back what work they take. Strict: as OpenSim's probe has it by default, no muscle's
    power is negative, and each muscle's heat is at least 1 W/kg.
    """
    objective = replace(scene.objective, metabolic_model="bhargava", metabolic_work=None, basal_rate=None)
    scene = replace(scene, objective=objective)
    if not _has_costs(recording, scene):
        return {}
    rest, mass = first_number(basal_rate(objective)), body_mass(scene.character)
    _, powers = _passive_and_powers(recording, scene, [effort.BHARGAVA, effort.BHARGAVA_STRICT])
    net, strict = (rest + float(power.sum(axis=1).mean()) / mass for power in powers)
    return {BHARGAVA_NET: cost_of_transport(net, speed), BHARGAVA_STRICT: cost_of_transport(strict, speed)}


class FibrePowers(NamedTuple):
    """What the parts of fibres give, W, (F, M) each; negative what they take."""

    active: Floats  # the contractile element
    passive: Floats  # the passive fibre, which is elastic
    damping: Floats  # what is left of the whole fibre


def fibre_powers(recording: Recording, scene: Scene) -> FibrePowers | None:
    """Mechanical powers of the parts of every fibre; None where there are no costs, see `spent`.

    A fibre at an angle to its tendon has the power of the tension along the tendon, which grows with 1/cosine as its
    own speed along the tendon does.

    Args:
        scene: without free parameters.
    """
    if not _has_costs(recording, scene):
        return None
    along, (work,) = _passive_and_powers(recording, scene, [effort.MARGARIA])
    speed = recording.muscle_fibre_velocity.astype(float)
    active = np.where(speed < 0.0, UP * work, -DOWN * work)  # the formula counts nothing but this work
    muscles = [scene.character.muscles[name] for name in recording.muscle_names]
    length = recording.muscle_fibre_length.astype(float)
    width = np.array([first_number(one.l_opt) * np.sin(first_number(one.pennation)) for one in muscles])
    cosine = np.sqrt(1.0 - np.square(np.minimum(width / np.maximum(length, LEAST_LENGTH), STEEPEST)))
    passive = -along * speed / cosine
    whole = -recording.muscle_force.astype(float) * speed / cosine
    return FibrePowers(active, passive, whole - active - passive)


def cost_of_transport(power: float, speed: float) -> float | None:
    """Metabolic power, W/kg, over a speed, m/s, in J/(kg m); None where the speed is too low to say something."""
    return power / speed if speed >= LEAST_SPEED else None


def muscle_power(recording: Recording, scene: Scene) -> Floats:
    """Metabolic power (F, M), W, of every muscle at every frame, by the model of the scene's objective."""
    return _passive_and_power(recording, scene)[1]


def _has_costs(recording: Recording, scene: Scene) -> bool:
    """Whether a motion has muscles, with curves of the package."""
    return bool(recording.muscle_names and recording.frames) and has_formulas(scene)


def has_formulas(scene: Scene) -> bool:
    """Whether metabolic formulas count for a scene's muscles, whose curves are those of the package."""
    kind = scene.muscle_model
    custom_curves = kind.active_force_length or kind.passive_force_length or kind.force_velocity
    return law_of(kind) == "hill" and not custom_curves


def _passive_and_power(recording: Recording, scene: Scene) -> tuple[Floats, Floats]:
    """Passive forces, N, and metabolic power by the formula of the objective, W, (F, M) each."""
    passive, powers = _passive_and_powers(recording, scene, [FORMULAS[scene.objective.metabolic_model]])
    return passive, powers[0]


def _passive_and_powers(recording: Recording, scene: Scene, formulas: list[int]) -> tuple[Floats, list[Floats]]:
    """Passive forces, N, and metabolic power by each formula, W, (F, M) each."""
    names = ("muscle_activation", "muscle_excitation", "muscle_fibre_length", "muscle_fibre_velocity")
    return passive_and_powers(scene, recording.muscle_names, [recording[name] for name in names], formulas)


def passive_and_powers(
    scene: Scene, muscle_names: Sequence[str], values: Sequence[Floats], formulas: Sequence[int]
) -> tuple[Floats, list[Floats]]:
    """Passive forces, N, and metabolic power by each formula of `kernels.muscle.effort`, W, (F, M) each.

    Args:
        scene: whose objective says how negative work counts. values: activation and excitation (F, M) of these muscles,
            length, m, and lengthening speed, m/s, of their fibres.
    """
    model, kernel = muscles_model(scene, tuple(muscle_names), "cpu"), _kernel(scene, muscle_names)
    quantities = [wp.array(one.astype(np.float32), dtype=float, device="cpu") for one in values]
    passive, powers = wp.zeros_like(quantities[0]), [wp.zeros_like(quantities[0]) for _ in formulas]
    for formula, power in zip(formulas, powers, strict=True):
        wp.launch(
            kernel,
            dim=quantities[0].shape,
            inputs=[model, formula, *quantities],
            outputs=[passive, power],
            device="cpu",
        )
    return passive.numpy().astype(float), [power.numpy().astype(float) for power in powers]


def load_kernel(scene: Scene) -> None:
    """Have ready what the others launch for a scene all of whose muscles are simulated, compiled now if need be."""
    if scene.character.muscles and has_formulas(scene):
        _kernel(scene, list(scene.character.muscles)).module.load("cpu", 1)


def _kernel(scene: Scene, muscle_names: Sequence[str]) -> Any:
    muscles = [scene.character.muscles[name] for name in muscle_names]
    return effort.muscle_effort_of(shaped_kind(muscles, scene.muscle_model))


def trembling(time: Floats, activation: Floats, above: float = TREMBLING) -> float | None:
    """Part of the power of activations (F, M) about their means that lies above a frequency, Hz.

    The mean over muscles, weighted by that power, of Hann-windowed spectra. Steps of an activation, such as at a
    touch-down, have a little of it without any trembling.

    Returns:
        None where it cannot be told: fewer frames a second than twice the frequency, a motion of less than a second,
        or activations that do not change.
    """
    if len(time) < 3 or time[-1] - time[0] < 1.0 or activation.shape[1] == 0:
        return None
    interval = float(time[-1] - time[0]) / (len(time) - 1)
    if 0.5 / interval <= above:
        return None
    window = np.hanning(len(time))[:, None]
    values = activation - np.average(activation, axis=0, weights=window[:, 0])
    power = np.square(np.abs(np.fft.rfft(window * values, axis=0))).sum(axis=1)
    power[1 : (len(time) + 1) // 2] *= 2.0  # what stands for two frequencies, of either sign
    total = float(power.sum())
    if total < 1e-12 * len(time):
        return None
    return float(power[np.fft.rfftfreq(len(time), interval) > above].sum()) / total
