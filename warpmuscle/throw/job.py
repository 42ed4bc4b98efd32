"""A whole job: read motions, find synergies, fit, report and keep."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from warpmuscle.core.errors import Error
from warpmuscle.formats import load
from warpmuscle.scene import Muscle, Scene
from warpmuscle.scene.parameters import start_values
from warpmuscle.synergy.factorization import factorize
from warpmuscle.throw.arm import Arm
from warpmuscle.throw.computed_synergies import ALONE, computed_excitation, computed_synergies, factorized
from warpmuscle.throw.fit import FIDELITY, Fitted, Settings, fit_motions, trade
from warpmuscle.throw.follow import Follower
from warpmuscle.throw.goals import LIMITS, Goal
from warpmuscle.throw.measured import Calibration, calibrate, measured_envelopes, measured_synergies
from warpmuscle.throw.metrics import Agreement
from warpmuscle.throw.missing_torque import Lack, lacking
from warpmuscle.throw.motion import ArmMotion, resample
from warpmuscle.throw.published import Published, as_published
from warpmuscle.throw.recordings.arm_motions import mean_motion, motion_of, notes, read_motions
from warpmuscle.throw.recordings.smoothing import suitable, usable
from warpmuscle.throw.report import write
from warpmuscle.throw.shared_synergies import SharedSynergies, share
from warpmuscle.throw.signals import Knots, Synergies
from warpmuscle.throw.strength import what_lacks
from warpmuscle.throw.synthesis import Throw, Thrower, check_release

USUAL, PLANAR = 5, 3  # synergies, for up to so many joints (Cruz Ruiz 2015)
GROUPS = "throw_groups"  # scene whose muscles, as strong as whole groups, compute activations of the same muscles
PRICES = (1e-3, 5e-3, 1e-2, 2e-2, 3e-2, 1e-1)


def usual_count(arm: Arm) -> int:
    """How many synergies are computed where nobody says: five, or of many muscles over many joints two a joint and one.

    Of 22 throws with 18 muscles over three joints, 5 synergies follow all with all bars met, 4 follow 19.
    """
    muscles, joints = len(arm.acting), len(arm.driven)
    return min(USUAL if joints <= PLANAR else 2 * joints + 1, muscles)


def _about(muscle: Muscle, other: Muscle) -> Muscle:
    """A muscle about those angles of its joints that another one moves."""
    pulleys = [msgspec.structs.replace(p, axis=q.axis) for p, q in zip(muscle.pulleys, other.pulleys, strict=True)]
    return msgspec.structs.replace(muscle, pulleys=pulleys)


@dataclass(frozen=True)
class JobOptions:
    """What a job is asked for."""

    count: int | None = None  # of computed synergies; by default `usual_count`
    prescribed: tuple[str, ...] = ()
    emg: Path | None = None
    channels: Mapping[str, str] = field(default_factory=dict)
    calibrated: bool = False  # whether the channels' gains and delays are, with the muscles
    fit_all: bool = False
    fidelity: float = FIDELITY
    low_pass: float | None = None  # Hz, of recorded motions; 0 is none, None one that suits them where they are noisy
    device: str | None = None
    threads: int | None = None
    seed: int = 0


class Job:
    """Motions, an arm and synergies, and what has been fitted to them.

    Attributes:
        count: of synergies, where they are computed.
        low_pass: Hz, of the filter that recorded motions have passed; None if none.
        lacks: motions that the muscles, with the strength of whole groups, are too weak for.
        training: motions that parameters are fitted to, and W where synergies bind muscles. held_out: the others.
        calibration: of channels and muscles, where it was asked for.
        shared: synergies that bind muscles, None where each joint has no more than two.
    """

    def __init__(self, scene: Scene, files: Sequence[str | Path], options: JobOptions) -> None:
        """Read and prepare; with no files, the motion is the one that the scene itself tells of its joints."""
        if not 0.0 <= options.fidelity < np.inf:
            raise Error(f"a price of leaving the extracted signals must be 0 or more, not {options.fidelity:g}")
        self.options, self.arm = options, Arm(scene, options.prescribed)
        self.count = usual_count(self.arm) if options.count is None else options.count
        read = read_motions(files, self.arm) if files else [motion_of(scene, self.arm)]
        self._chosen = options.low_pass is None
        self.low_pass = suitable(read) if options.low_pass is None else options.low_pass or None
        recorded = usable(read, self.arm.joints, self.low_pass, self._chosen)
        self.motions = resample(recorded)
        strong = self._strengthened(scene)
        if options.emg is None:
            synergies, self.lacks = computed_synergies(self.arm, self.motions, strong, self.count, options.seed)
        else:
            synergies = measured_synergies(self.arm, recorded, options.emg, options.channels)
            plain = strong.unknowns(start_values(strong.scene))
            self.lacks = lacking(strong, self.motions, computed_excitation(strong, self.motions)[-1], plain)
        self._read, self._recorded, self.strong = read, recorded, strong
        knots = Knots(self.motions.time)
        self.start = self.arm.unknowns(start_values(scene))
        count = len(self.motions)
        self.training = list(range(count)) if options.fit_all or count == 1 else list(range(0, count, 2))
        self.held_out = [k for k in range(count) if k not in self.training]
        self.calibration: Calibration | None = None
        if options.emg is not None and options.calibrated:
            synergies = self._calibrated(recorded, options.emg, synergies.count)
        self.shared: SharedSynergies | None = None
        if options.emg is None and len(self.arm.acting) > max(ALONE * len(self.arm.driven), self.count):
            self.shared = self._shared(knots)
            synergies = self.shared.synergies(knots, synergies.source)
        self.follower = Follower(
            self.arm, self.motions, synergies, knots, device=options.device, threads=options.threads
        )
        self.settings = Settings(fidelity=options.fidelity, adapt=options.fidelity == FIDELITY, seed=options.seed)
        self.fitted: Fitted | None = None
        self.published: Published | None = None
        self.throws: list[Throw] = []

    def _strengthened(self, scene: Scene) -> Arm:
        """The arm with the muscles that compute activations, if they are of the same names over the same joints."""
        groups, individual = load(GROUPS).character.muscles, scene.character.muscles
        same = individual.keys() == groups.keys() and all(
            [p.joint for p in individual[name].pulleys] == [p.joint for p in groups[name].pulleys]
            for name in individual
        )
        if not same:
            return self.arm
        muscles = {name: _about(groups[name], individual[name]) for name in individual}
        character = msgspec.structs.replace(scene.character, muscles=muscles)
        return Arm(msgspec.structs.replace(scene, character=character), self.options.prescribed)

    def _calibrated(self, recorded: Sequence[ArmMotion], emg: Path, count: int) -> Synergies:
        """Synergies of envelopes whose gains and delays are calibrated; fits start from the muscles found with them."""
        envelopes = measured_envelopes(self.arm, recorded, emg, self.options.channels)
        found = calibrate(self.arm, self.motions, envelopes, self.start, self.training)
        self.calibration, self.start = found, found.unknowns
        return factorized(
            self.arm, self.motions, found.excitation, found.start, min(count, len(self.arm.acting)),
            f"{emg}, calibrated", self.options.seed,
        )  # fmt: skip

    def _shared(self, knots: Knots) -> SharedSynergies:
        """Synergies that make the torques of the motions; W knows of those alone that parameters are fitted to."""
        activation = computed_excitation(self.strong, self.motions)[0]
        acting, inside = self.arm.acting, self.motions.valid[self.training] > 0.0
        known = activation[self.training][inside][:, acting]
        weights = np.zeros((len(self.arm.muscles), self.count))
        weights[acting] = factorize(known, self.count, seed=self.options.seed).weights
        return share(self.arm, self.motions, activation, weights, knots, self.start, self.training)

    def notes(self) -> list[str]:
        """What is worth knowing of the motions before they are fitted."""
        return notes(self._read, self._recorded, self.arm, self.low_pass, self._chosen)

    def check_release(self, release: float) -> None:
        """Error unless a time of release, s, is within the first motion."""
        check_release(release, self.motions)

    def fit(self, progress: Callable[[str], None] = lambda stage: None) -> Fitted:
        """The better fit; where Ctrl-C ends it, `fitted` is what the last whole stage that simulates came to."""
        self.follower.load()
        self.fitted = fit_motions(self.follower, self.start, self.training, self.settings, progress, self._keep)
        return self.fitted

    def _keep(self, fitted: Fitted) -> None:
        self.fitted = fitted

    def publish(self, progress: Callable[[str], None] = lambda stage: None) -> Published:
        """The published fit, of every motion by itself."""
        self.published = as_published(
            self.arm, self.motions, self.follower.synergies, self.start, device=self.options.device,
            threads=self.options.threads, progress=progress,
        )  # fmt: skip
        return self.published

    def publish_mean(self) -> Published:
        """The published fit of the mean of all motions."""
        mean = resample([mean_motion(self._recorded)])
        synergies, _ = computed_synergies(self.arm, mean, self.strong, self.count, self.options.seed)
        return as_published(
            self.arm, mean, synergies, self.start, device=self.options.device, threads=self.options.threads
        )

    def final_lacks(self) -> list[Lack]:
        """What the fitted muscles lack for the motions."""
        assert self.fitted is not None
        from warpmuscle.throw.signals import computed_activation

        unknowns = self.fitted.unknowns
        return lacking(self.arm, self.motions, computed_activation(self.arm, self.motions, unknowns)[1], unknowns)

    def curve(self) -> list[tuple[float, Agreement]]:
        """Accuracy against fidelity."""
        if self.fitted is None:
            raise Error("fit before the curve of accuracy against fidelity")
        return trade(self.follower, self.fitted, np.asarray(self.training), PRICES, self.settings)

    def throw(
        self,
        goals: Sequence[Goal],
        release: float | None = None,
        adapt: int | None = None,
        solutions: int = 1,
        explain: bool = True,
        progress: Callable[[str], None] = lambda what: None,
    ) -> list[Throw]:
        """New throws out of the first motion.

        Args:
            adapt: how many synergies' signals may change: those that vary most in the known throw; by default all.
            solutions: throws for each goal, unlike each other.
            explain: whether to look for what the muscles lack where more of a goal is missed than joints' limits.
        """
        if self.fitted is None:
            raise Error("fit a throw before making new ones")
        thrower = Thrower(
            self.follower, self.fitted.individual[0], self.fitted.unknowns, release, seed=self.options.seed
        )
        chosen = None if adapt is None else self._most_active(adapt)
        self.throws = []
        for goal in goals:
            for made in thrower.throws(goal, solutions, chosen, progress):
                if explain and made.missed.keys() - {LIMITS}:  # strength is no cure for stops
                    progress(f"looking for what lacks to throw {goal}")
                    made = dataclasses.replace(made, lack=what_lacks(thrower, made))
                self.throws.append(made)
        return self.throws

    def _most_active(self, count: int) -> tuple[int, ...]:
        """The synergies whose signals vary most in the first throw, each in parts of what it excites."""
        assert self.fitted is not None
        signals = self.follower.shaped(self.fitted.individual[:1])[0]
        spread = signals.std(axis=1) * np.linalg.norm(self.follower.synergies.weights, axis=0)
        return tuple(sorted(np.argsort(-spread)[:count].tolist()))

    def write(
        self,
        path: str | Path,
        attributes: Mapping[str, Any],
        quantities: Sequence[str] | None = None,
        single: bool = False,
    ) -> None:
        """Keep everything as HDF5, see `report.write`; of the motions some quantities, see `partial_motion.reduced`."""
        made = (self.follower, self.fitted, self.published, self.training, attributes, self.throws)
        write(path, *made, quantities, single)
