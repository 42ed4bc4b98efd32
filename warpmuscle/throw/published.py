"""The two fits of Cruz Ruiz et al. 2015 as published: parameters joint by joint, then signals time step by time step.

NLopt stands in place of fmincon, with gradients by batched central differences; many motions are fitted side by side,
each with parameters of its own, so that their candidates share a batch.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, replace

import msgspec
import numpy as np
from numpy.typing import NDArray

from warpmuscle.core.array_types import Floats
from warpmuscle.scene import Scene
from warpmuscle.search.batched import ask_all, tell_all
from warpmuscle.search.nlopt import NloptSearch
from warpmuscle.synergy.activation_filter import ActivationFilter
from warpmuscle.throw.arm import Arm
from warpmuscle.throw.follow import ROUGH_STEP, Replay
from warpmuscle.throw.least_squares import Prior, Unknowns, fit
from warpmuscle.throw.metrics import determination
from warpmuscle.throw.motion import RATE, ArmMotions
from warpmuscle.throw.signals import Synergies
from warpmuscle.throw.simulator import Simulator, Stepper

ALGORITHM = "LD_SLSQP"
TOLERANCE = 1e-4  # of a parameter's interval: NLopt's steps below it end its search
STARTS = 4  # the first one from the literature
SCATTER = 0.25  # of the others, in parts of a parameter's interval
FLOOR = 1e-3  # of 1 - r2, below which gains count less and less
GRADIENT_STEP = 2e-3  # of a parameter's interval
INSTANT = 1e-6  # s
WORST = 1e3  # mean squared error, over the variance of the angle, of what diverged
GREEDY_STEPS = 4  # of Gauss and Newton at each time step
GREEDY_DAMPING = 1e-9


@dataclass(frozen=True)
class PublishedStage:
    """r2 (n, J) of the angles after a stage."""

    name: str
    r2: Floats
    seconds: float
    simulations: int
    replay: Replay | None = None  # None where only one joint at a time was simulated


@dataclass(frozen=True)
class Published:
    """What the published procedure came to, for n motions."""

    unknowns: Floats  # (n, P), see `Arm.unknowns`
    signals: Floats  # (n, T, N) after the filter
    replay: Replay
    stages: list[PublishedStage]


def as_published(
    arm: Arm,
    motions: ArmMotions,
    synergies: Synergies,
    start: Floats,
    *,
    evaluations: int = 40,
    device: str | None = None,
    threads: int | None = None,
    progress: Callable[[str], None] = lambda stage: None,
) -> Published:
    """Fit every motion by itself, as published.

    Args:
        start: (P,) parameters from the literature, see `Arm.unknowns`.
        evaluations: gradients that NLopt may ask for, for each joint.
    """
    plain = replace(arm, scene=without_dynamics(arm))
    whole = Simulator(plain, motions, device=device, threads=threads)
    fitting = _Published(plain, motions, synergies, whole, device, threads)
    begin = time.perf_counter()
    stages: list[PublishedStage] = []
    unknowns = np.tile(start, (len(motions), 1))

    def note(name: str, replay: Replay) -> None:
        r2 = fitting.r2(replay)
        stages.append(PublishedStage(name, r2, time.perf_counter() - begin, fitting.simulations, replay))

    progress("synergies as extracted")
    note("synergies as extracted", fitting.open_loop(unknowns, synergies.signals))
    alone = np.zeros((len(motions), len(arm.free)))
    for column, joint in enumerate(arm.driven):
        progress(f"parameters of {joint}")
        unknowns, alone[:, column] = fitting.joint(joint, unknowns, evaluations)
    stages.append(PublishedStage("parameters, others driven", alone, time.perf_counter() - begin, fitting.simulations))
    note("parameters, all joints free", fitting.open_loop(unknowns, synergies.signals))
    progress("signals step by step")
    signals, replay = fitting.greedy(unknowns)
    note("signals step by step", replay)
    model = arm.scene.muscle_model
    smoothing = ActivationFilter.of(1.0 / RATE, float(model.rise_time))  # type: ignore[arg-type]
    filtered = smoothing.apply(signals.transpose(0, 2, 1), settled=True).transpose(0, 2, 1)
    replay = fitting.open_loop(unknowns, filtered)
    note("signals filtered", replay)
    return Published(unknowns, filtered, replay, stages)


def without_dynamics(arm: Arm) -> Scene:
    """The scene with activations that follow excitations at once, as the paper's fits have it."""
    model = msgspec.structs.replace(arm.scene.muscle_model, rise_time=INSTANT, fall_time=INSTANT, neural_time=INSTANT)
    return msgspec.structs.replace(arm.scene, muscle_model=model)


class _Published:
    """The published procedure for n motions side by side."""

    def __init__(
        self,
        arm: Arm,
        motions: ArmMotions,
        synergies: Synergies,
        whole: Simulator,
        device: str | None,
        threads: int | None,
    ) -> None:
        self._arm, self._motions, self._synergies, self._whole = arm, motions, synergies, whole
        self._device, self._threads = device, threads
        self._others = 0

    @property
    def simulations(self) -> int:
        return self._whole.simulations + self._others

    def r2(self, replay: Replay) -> Floats:
        """Of the angles of the driven joints, (n, J)."""
        free, motions = self._arm.free, self._motions
        return determination(replay.angle[:, :, free], motions.angles[0][:, :, free], motions.valid)

    def open_loop(self, unknowns: Floats, signals: Floats) -> Replay:
        """Motions under signals (n, T, N) given at every sample."""
        excitation = self._synergies.excitation(signals).transpose(0, 2, 1)
        which = np.arange(len(self._motions))
        return Replay(*self._whole.run(which, self._motions.time, excitation, self._arm.values(unknowns)))

    def joint(self, name: str, unknowns: Floats, evaluations: int) -> tuple[Floats, Floats]:
        """Parameters (n, P) of the muscles of a joint fitted while all other joints are driven; its r2 (n,)."""
        arm = self._arm
        alone = replace(arm, prescribed=tuple(other for other in arm.joints if other != name))
        rough, exact = (
            Simulator(alone, self._motions, device=self._device, threads=self._threads, time_step=time_step)
            for time_step in (max(ROUGH_STEP, arm.scene.time_step), None)
        )
        individual = self._parameters_of_joint(name)
        excitation = self._synergies.excitation(self._synergies.signals).transpose(0, 2, 1)
        place = arm.joints.index(name)

        def r2(simulator: Simulator, which: NDArray[np.intp], cube: Floats) -> Floats:
            values = unknowns[which].copy()
            values[:, individual] = cube
            angle, _ = simulator.run(which, self._motions.time, excitation[which], arm.values(values))
            recorded, valid = self._motions.angles[0][which], self._motions.valid[which]
            return determination(angle[:, :, [place]], recorded[:, :, [place]], valid)[:, 0]

        def cost(which: NDArray[np.intp], cube: Floats) -> Floats:
            missed: Floats = np.minimum(1.0 - r2(rough, which, cube), WORST)
            return missed

        result = unknowns.copy()
        result[:, individual] = _minimize(cost, np.clip(unknowns[:, individual], 0.0, 1.0), evaluations)
        reached = r2(exact, np.arange(len(result)), result[:, individual])
        self._others += rough.simulations + exact.simulations
        return result, reached

    def _parameters_of_joint(self, joint: str) -> list[int]:
        """Places of the parameters of the muscles that pull on a joint."""
        starts = tuple(f"character.muscles.{name}." for name, joints in self._arm.crossed.items() if joint in joints)
        return [i for i, parameter in enumerate(self._arm.parameters) if parameter.name.startswith(starts)]

    def greedy(self, unknowns: Floats) -> tuple[Floats, Replay]:
        """Signals (n, T, N) chosen at each time step so that the next angles are met (eq. 13); the motion of it.

        The sum of squares takes the place of eq. 13's sum of absolute errors: where the muscles can, both come to 0.
        """
        stepper = Stepper(self._whole, self._arm.values(unknowns), self._synergies.count + 1)
        size = self._synergies.count
        signals = self._synergies.signals.copy()
        angles, speeds = [stepper.angle[:, 0]], [stepper.speed[:, 0]]
        nothing = Unknowns(np.zeros(1), np.zeros(1), np.ones(1), 1.0, free=False)
        for k in range(len(self._motions.time) - 1):
            target = self._motions.angles[0][:, k + 1, self._arm.free]

            def residuals(which: NDArray[np.intp], individual: Floats, _: Floats, target: Floats = target) -> Floats:
                return self._tried(stepper, which, individual) - target[which]

            individual = Unknowns(
                np.clip(signals[:, k], 0.0, 1.0), np.zeros(size), np.ones(size), 1e-2, None,
                [Prior(1e-9 * np.eye(size), signals[:, k])],
            )  # fmt: skip
            found = fit(residuals, individual, nothing, iterations=GREEDY_STEPS, damping=GREEDY_DAMPING, tolerance=1e-3)
            signals[:, k] = found.individual
            stepper.commit(self._synergies.excitation(found.individual))
            angles.append(stepper.angle[:, 0])
            speeds.append(stepper.speed[:, 0])
        signals[:, -1] = signals[:, -2]
        self._others += stepper.tried // max(len(self._motions.time) - 1, 1)
        return signals, Replay(np.stack(angles, axis=1), np.stack(speeds, axis=1))

    def _tried(self, stepper: Stepper, which: NDArray[np.intp], individual: Floats) -> Floats:
        """Next angles (B, J) of candidates (B, N), which belong to motions `which`, sorted."""
        excitation = np.zeros((len(self._motions), stepper.copies, len(self._arm.muscles)))
        place = np.arange(len(which)) - np.searchsorted(which, which)
        excitation[which, place] = self._synergies.excitation(individual)
        angle, _ = stepper.attempt(excitation)
        return np.asarray(angle[which, place][:, self._arm.free])


def _minimize(cost: Callable[[NDArray[np.intp], Floats], Floats], start: Floats, evaluations: int) -> Floats:
    """The best points (n, P) of n problems in the unit cube by NLopt, side by side, from several starts each.

    What is minimised is the logarithm of the cost: the minimum is the same, and far from it slopes are not so steep.
    """
    count, rng = len(start), np.random.default_rng(0)
    others = np.clip(
        np.tile(start, (STARTS - 1, 1)) + rng.normal(0.0, SCATTER, (len(start) * (STARTS - 1), start.shape[1])),
        0.0,
        1.0,
    )
    points = np.concatenate([start, others])
    searches = [NloptSearch(ALGORITHM, row, 0, gradient_step=GRADIENT_STEP, tolerance=TOLERANCE) for row in points]
    for _ in range(evaluations):
        if all(search.finished() for search in searches):
            break
        batch = ask_all(searches)
        tell_all(searches, batch, np.log(cost(batch.owner % count, np.asarray(batch.candidates)) + FLOOR))
    reached = np.array([float(search.state()["best_cost"]) for search in searches]).reshape(STARTS, count)
    best = np.stack([search.state()["best"] for search in searches]).reshape(STARTS, count, -1)
    return np.asarray(best[reached.argmin(axis=0), np.arange(count)])
