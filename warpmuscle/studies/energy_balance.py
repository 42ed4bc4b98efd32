"""Where the energy of a motion comes from and where it goes: the mean powers of all that acts on a body.

They follow from a recording, in float64. What joints, muscles and gravity do is recorded or follows from the pose; the
ground's share is computed again from its contacts where every step was recorded, and then the sum of all powers tells
how well the books balance. Else the ground, and forces on bodies that have no power of their own in the recording, are
what is left.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import Error
from warpmuscle.core.number_rows import first_number
from warpmuscle.core.pose import conjugate, multiply, rotate
from warpmuscle.gait.cycles import steady_strides
from warpmuscle.gait.device_work import device_powers
from warpmuscle.gait.joint_stops import stop_torques
from warpmuscle.gait.muscle_effort import FibrePowers, fibre_powers
from warpmuscle.gait.quality import Measures
from warpmuscle.results.motion_of_scene import check_motion_of
from warpmuscle.results.recording import Recording
from warpmuscle.scene import Scene
from warpmuscle.scene.masses import body_mass
from warpmuscle.scene.parameters import at_start
from warpmuscle.studies.ground_loads import ground_loads, step_accelerations

LEAST_FRAMES = 3
UNIT = "W/kg"


class FibreShares(NamedTuple):
    """What becomes of the power of muscles, W, positive where it goes to the body; they add up to that power."""

    shortening: float  # of the contractile element, while it shortens
    lengthening: float  # while it lengthens, negative
    passive: float  # of the passive fibre, which gives back what it takes
    damping: float  # of the fibre, negative
    tendons: float  # which give back what they take


@dataclass(frozen=True)
class EnergyBalance:
    """Mean powers over a motion, W, positive where energy is given to the body; those but `sliding` add up to `left`.

    Devices that act on joints count with the torques.
    """

    gravity: float
    inertia: float  # what slower motion gives at the end, or faster motion has taken
    muscles: float  # on joints
    torques: float  # of controllers, springs and motors on joints
    stops: float  # of joints
    devices: float  # on bodies, whose power is recorded
    ground: float
    sliding: float | None  # of the ground's, along it; None where its contacts are not known
    left: float | None  # that is not accounted for; None where it counts as the ground's
    fibres: FibreShares | None  # None without muscles, or where their laws have no such parts

    @property
    def turnover(self) -> float:
        """The powers that give energy to the body, W, with what the fibres give in place of what the joints get."""
        given = [self.gravity, self.inertia, self.torques, self.stops, self.devices, self.ground]
        given += [self.muscles] if self.fibres is None else list(self.fibres)
        return float(sum(max(power, 0.0) for power in given))


MEASURES: dict[str, Callable[[EnergyBalance], float | None]] = {  # what of a balance is a measure of a walk
    "power of gravity": lambda balance: balance.gravity,
    "power of muscles": lambda balance: balance.muscles,
    "power of joint torques": lambda balance: balance.torques,
    "power of joint stops": lambda balance: balance.stops,
    "power of the ground": lambda balance: balance.ground,
    "power of shortening fibres": lambda balance: balance.fibres and balance.fibres.shortening,
    "power of lengthening fibres": lambda balance: balance.fibres and balance.fibres.lengthening,
    "power of fibre damping": lambda balance: balance.fibres and balance.fibres.damping,
}


class _Moving(NamedTuple):
    """Positions of the bodies and how they move, (F, B, 3) each, world axes."""

    place: Floats  # m
    velocity: Floats  # m/s, of the centre of mass
    turning: Floats  # rad/s


def energy_balance(motion: Recording, scene: Scene, *, contacts: bool = True) -> EnergyBalance:
    """Mean powers of all that acts on the body in a motion.

    Args:
        scene: that made it. contacts: whether the ground's share is computed from its contacts, where every step was
            recorded.

    Raises:
        Error: a motion of another character, of fewer than three frames, or one without poses and torques.
    """
    scene = at_start(scene)
    _check(motion, scene)
    moving = _moving(motion)
    gravity, inertia = _gravity(motion, scene), _inertia(motion, scene, moving)
    at_joints, stops = _joints(motion, scene)
    muscles = _muscles(motion)
    torques, devices = at_joints - muscles, _devices(motion, scene)
    others = gravity + inertia + muscles + torques + stops + devices
    ground, sliding, left = -others, None, None
    if contacts and step_accelerations(motion, float(scene.time_step)) is not None:
        ground, sliding = _ground(motion, scene, moving)
        left = others + ground
    fibres = fibre_powers(motion, scene)
    shares = None if fibres is None else _shares(fibres, muscles)
    return EnergyBalance(gravity, inertia, muscles, torques, stops, devices, ground, sliding, left, shares)


def balance_measures(motion: Recording, scene: Scene) -> Measures:
    """Parts of the energy balance over whole gait cycles, W/kg of the body with its loads, by the names of `MEASURES`.

    The ground's is what is left, so that motions that were not recorded at every step have it, too.

    Args:
        scene: without free parameters, that made the motion.

    Raises:
        Error: no legs, or no whole gait cycle; see `energy_balance`.
    """
    cycles = next(iter(steady_strides(motion, scene).values()))
    steady = motion.window(cycles[0][0], cycles[-1][1])
    balance, mass = energy_balance(steady, scene, contacts=False), body_mass(scene.character)
    found = {name: part(balance) for name, part in MEASURES.items()}
    return {name: power / mass for name, power in found.items() if power is not None}


def _check(motion: Recording, scene: Scene) -> None:
    if motion.frames < LEAST_FRAMES:
        raise Error(f"an energy balance takes {LEAST_FRAMES} frames or more, not {motion.frames}")
    check_motion_of(motion, scene)
    needed = ("body_position", "body_orientation", "joint_torque", "joint_angular_velocity", "com")
    missing = [name for name in needed if name in motion.missing]
    if missing:
        raise Error(f"an energy balance needs {missing[0]}, which this motion was recorded without")


def _mean_rate(motion: Recording, values: Floats) -> float:
    """Mean rate of change of values (F,) over the motion."""
    return float((values[-1] - values[0]) / (motion.time[-1] - motion.time[0]))


def _mean(motion: Recording, powers: Floats) -> float:
    """Mean of powers (F,) over the motion, by the trapezoidal rule."""
    return float(np.trapezoid(powers, motion.time) / (motion.time[-1] - motion.time[0]))


def _moving(motion: Recording) -> _Moving:
    place = motion.body_position.astype(float)
    turned = motion.body_orientation.astype(float)
    change = np.gradient(turned, motion.time, axis=0)
    return _Moving(
        place, np.gradient(place, motion.time, axis=0), 2.0 * multiply(change, conjugate(turned))[..., :3]
    )  # fmt: skip


def _gravity(motion: Recording, scene: Scene) -> float:
    weight = body_mass(scene.character) * first_number(scene.gravity)
    return -weight * _mean_rate(motion, motion.com[:, 1].astype(float))


def _inertia(motion: Recording, scene: Scene, moving: _Moving) -> float:
    """Less the mean rate of the kinetic energy."""
    energy = np.zeros(motion.frames)
    for number, name in enumerate(motion.body_names):
        body = scene.character.bodies[name]
        axes = motion.body_orientation[:, number].astype(float)
        turned = np.array([first_number(part) for part in body.inertia_axes])
        axes = multiply(axes, np.broadcast_to(turned, axes.shape))
        own = rotate(conjugate(axes), moving.turning[:, number])
        inertia = np.array([first_number(moment) for moment in body.inertia])
        energy += 0.5 * first_number(body.mass) * np.sum(moving.velocity[:, number] ** 2, axis=1)
        energy += 0.5 * np.sum(own**2 * inertia, axis=1)
    return -_mean_rate(motion, energy)


def _joints(motion: Recording, scene: Scene) -> tuple[float, float]:
    """Powers of what drives the joints, and of their stops; torques act on the parent."""
    driven, stopped = np.zeros(motion.frames), np.zeros(motion.frames)
    for number, name in enumerate(motion.joint_names):
        parent = motion.body_names.index(scene.character.joints[name].parent)
        rate = motion.joint_angular_velocity[:, number].astype(float)
        axes = conjugate(motion.body_orientation[:, parent].astype(float))
        torque = rotate(axes, motion.joint_torque[:, number].astype(float))
        driven -= np.sum(torque * rate, axis=1)
        stopped -= np.sum(stop_torques(motion, scene, name) * rate, axis=1)
    return _mean(motion, driven), _mean(motion, stopped)


def _muscles(motion: Recording) -> float:
    if not motion.muscle_names:
        return 0.0
    rate = np.gradient(motion.muscle_path_length.astype(float), motion.time, axis=0)
    return -_mean(motion, np.sum(motion.muscle_force.astype(float) * rate, axis=1))


def _devices(motion: Recording, scene: Scene) -> float:
    """Of devices that act on bodies."""
    on_bodies = [name for name, force in scene.forces.items() if not force.joint]
    return sum(_mean(motion, power.astype(float)) for power in device_powers(motion, on_bodies).values())


def _ground(motion: Recording, scene: Scene, moving: _Moving) -> tuple[float, float]:
    """Power of the ground in all, and of that the part along it."""
    total, along = np.zeros(motion.frames), np.zeros(motion.frames)
    normal = np.array([first_number(part) for part in scene.ground.normal])
    normal /= np.linalg.norm(normal)
    for load in ground_loads(motion, scene):
        number = motion.body_names.index(load.body)
        turning = moving.turning[:, number]
        point = moving.velocity[:, number] + np.cross(turning, load.point - moving.place[:, number])
        pressing = np.sum(load.force * normal, axis=1)
        total += np.sum(load.force * point, axis=1) + np.sum(load.torque * turning, axis=1)
        along += np.sum((load.force - pressing[:, None] * normal) * point, axis=1)
    return _mean(motion, total), _mean(motion, along)


def _shares(fibres: FibrePowers, muscles: float) -> FibreShares:
    active = fibres.active
    shortening, lengthening = (float(part.sum(axis=1).mean()) for part in (active.clip(min=0.0), active.clip(max=0.0)))
    passive, damping = (float(part.sum(axis=1).mean()) for part in (fibres.passive, fibres.damping))
    return FibreShares(
        shortening, lengthening, passive, damping, muscles - shortening - lengthening - passive - damping
    )
