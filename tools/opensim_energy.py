"""Metabolic power of the muscles of a motion: ours beside OpenSim's probes of Bhargava 2004 and Umberger 2010.

    python tools/opensim_energy.py gait2392_millard2012muscle.osim --scene gait2392_walk

The scene must be made of that model, with elastic tendons. It moves here; its coordinates, activations, excitations and
fibre lengths are put into OpenSim's model frame by frame, whose own forces, fibre speeds and probes say what each
muscle takes. Probes have our muscle masses and fibre types, and count net work. Their definitions differ from ours:

- Bhargava: the heat of shortening is a quarter of the power of the fibre's whole force; ours is of its active part.
- Umberger: a lengthening fibre has 4 times the heat coefficient of a slow one, as in his paper of 2003; ours has 0.3
  times, as in that of 2010.
- Further rules, which are off but for the last column: no muscle's power is negative, its heat is at least 1 W/kg (so
  it is in ours for Umberger), and Umberger's fibres are recruited as Bhargava's.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, NamedTuple

import msgspec
import numpy as np
import typer
import warp as wp
from numpy.typing import NDArray
from opensim_oracle import with_process
from opensim_posed import Posed

import warpmuscle as wm
from warpmuscle.cli.ending import run_script
from warpmuscle.gait.muscle_effort import muscle_power
from warpmuscle.results.degrees_of_freedom import degrees_of_freedom
from warpmuscle.results.recording import Recording
from warpmuscle.scene import Scene
from warpmuscle.scene.masses import muscle_mass, specific_tension
from warpmuscle.scene.parameters import at_start

Floats = NDArray[np.float64]
RATE = 100.0  # frames/s
SETTLED = 1.0  # s, left out
AEROBIC, SLOW_HEAT, SLOW_SPEED = 1.5, 100.0, 0.4  # Umberger 2003: scaling; W/kg of slow fibres at their greatest speed
LENGTHENING, OPENSIM_LENGTHENING = 0.3, 4.0  # times the slow fibres' coefficient
SHORTENING = 0.25  # Bhargava 2004
PROBES = ("bhargava", "umberger")
RULES = ("equal", "default")


class States(NamedTuple):
    """States of M muscles in F frames, as OpenSim takes them."""

    coordinates: list[str]
    q: Floats  # (F, K) rad or m
    muscles: list[str]
    activation: Floats  # (F, M)
    excitation: Floats  # (F, M)
    fibre: Floats  # (F, M) m
    mass: list[float]  # (M,) kg
    slow: list[float]  # (M,) fraction of slow-twitch fibres


class Powers(NamedTuple):
    """What OpenSim has of these states, (F, M) each."""

    power: dict[str, Floats]  # by probe and rules, W
    definition: dict[str, Floats]  # by probe: what its definition of one heat adds to ours, W


def states(motion: Recording, scene: Scene) -> States:
    """The motion of a scene without free parameters."""
    degrees = degrees_of_freedom(motion, scene)
    muscles = list(motion.muscle_names)
    parts = [scene.character.muscles[name] for name in muscles]
    mass = [float(muscle_mass(muscle, specific_tension(muscle, scene.muscle_model))) for muscle in parts]
    return States(
        [one.name for one in degrees], np.stack([one.values for one in degrees], axis=1).astype(float), muscles,
        *(motion[f"muscle_{name}"].astype(float) for name in ("activation", "excitation", "fibre_length")),
        mass, [float(muscle.slow_fibres) for muscle in parts],
    )  # fmt: skip


def in_opensim(file: Path, motion: States) -> Powers:
    """Probes of OpenSim's model in these states; to be called in a process of its own."""
    return Probed(file, motion).powers()


class Probed(Posed):
    """A model with probes, whose muscles are put into states."""

    def __init__(self, file: Path, motion: States) -> None:
        super().__init__(file)
        self.motion = motion
        self.probes = {f"{name} {rules}": self._probe(name, rules) for name in PROBES for rules in RULES}
        self.state = self.model.initSystem()
        named = {muscle.getName(): muscle for muscle in self.muscles}
        self.moved = [named[name] for name in motion.muscles]

    def _probe(self, name: str, rules: str) -> Any:
        bhargava = name == "bhargava"
        if bhargava:  # all heats and work, no basal rate
            probe = self.opensim.Bhargava2004MuscleMetabolicsProbe(True, True, True, False, True)
        else:
            probe = self.opensim.Umberger2010MuscleMetabolicsProbe(True, True, False, True)
        probe.setName(f"{name}_{rules}")
        probe.setOperation("value")
        probe.set_report_total_metabolics_only(False)
        equal = rules == "equal"
        probe.set_forbid_negative_total_power(not equal)
        probe.set_enforce_minimum_heat_rate_per_muscle(not (equal and bhargava))
        if not bhargava:
            probe.set_use_Bhargava_recruitment_model(not equal)
        self.model.addProbe(probe)
        heats = (40.0, 133.0, 74.0, 111.0) if bhargava else ()
        for muscle, slow, mass in zip(self.motion.muscles, self.motion.slow, self.motion.mass, strict=True):
            probe.addMuscle(muscle, slow, *heats, mass)
        return probe

    def powers(self) -> Powers:
        """Frame by frame."""
        motion = self.motion
        order = [self.names.index(name) for name in motion.coordinates]
        found: dict[str, list[Any]] = {name: [] for name in self.probes}
        fibres: list[list[list[float]]] = []
        controls = self.opensim.Vector(self.model.getNumControls(), 0.0)
        for frame in range(len(motion.q)):
            q = self.start.copy()
            q[order] = motion.q[frame]
            self.put(self.state, self.coordinates, self.coupled(q))
            self.state.setU(self.opensim.Vector(self.state.getNU(), 0.0))
            for k, muscle in enumerate(self.moved):
                muscle.setActivation(self.state, float(motion.activation[frame, k]))
                muscle.setStateVariableValue(self.state, "fiber_length", float(motion.fibre[frame, k]))
                muscle.setControls(self.opensim.Vector(1, float(motion.excitation[frame, k])), controls)
            self.model.realizeVelocity(self.state)
            self.model.setControls(self.state, controls)
            self.model.realizeDynamics(self.state)
            fibres.append([self._fibre(muscle) for muscle in self.moved])
            for name, probe in self.probes.items():
                found[name].append(probe.computeProbeInputs(self.state).to_numpy()[-len(self.moved) :])
        return Powers({name: np.array(values) for name, values in found.items()}, self._definition(np.array(fibres)))

    def _fibre(self, muscle: Any) -> list[float]:
        """Speed, m/s; passive force with damping, N; active force-length multiplier."""
        return [
            muscle.getFiberVelocity(self.state), muscle.getPassiveFiberForce(self.state),
            muscle.getActiveForceLengthMultiplier(self.state),
        ]  # fmt: skip

    def _definition(self, fibres: Floats) -> dict[str, Floats]:
        """What the probes' definitions add, of fibres (F, M, 3)."""
        motion, (speed, passive, iso) = self.motion, np.moveaxis(fibres, 2, 0)
        l_opt, v_max = (
            np.array([getattr(muscle, name)() for muscle in self.moved])
            for name in ("getOptimalFiberLength", "getMaxContractionVelocity")
        )
        u, a = motion.excitation, motion.activation
        level = np.where(u > a, u, 0.5 * (u + a))
        rate = AEROBIC * (OPENSIM_LENGTHENING - LENGTHENING) * SLOW_HEAT / (SLOW_SPEED * v_max)
        longer = rate * level * np.maximum(speed / l_opt, 0.0) * np.where(motion.fibre > l_opt, iso, 1.0)
        heat = -SHORTENING * passive * np.minimum(speed, 0.0)
        return {"bhargava": heat, "umberger": longer * np.array(motion.mass)}


def ours(motion: Recording, scene: Scene) -> dict[str, Floats]:
    """Our powers (F, M), W, of a motion by each formula, with net work."""
    objectives = {
        name: msgspec.structs.replace(scene.objective, metabolic_model=name, metabolic_work="net") for name in PROBES
    }
    return {
        name: muscle_power(motion, msgspec.structs.replace(scene, objective=one)) for name, one in objectives.items()
    }


def moved(scene: Scene, duration: float) -> Recording:
    """The motion of a scene without free parameters, without its first second."""
    batch = wm.Rollout(msgspec.structs.replace(scene, duration=duration), 1, "cpu", record=[0], record_rate=RATE)
    batch.run()
    return batch.recording().window(min(SETTLED, 0.5 * duration))


class Row(NamedTuple):
    """Mean powers of all muscles together, W."""

    formula: str
    ours: float
    opensim: float
    definition: float  # what OpenSim's definition adds
    default: float  # OpenSim's with all its rules
    muscle: float  # greatest difference of a muscle's mean power but for the definition

    @property
    def off(self) -> float:
        """Ours over OpenSim's by our definition, less 1."""
        return self.ours / (self.opensim - self.definition) - 1.0


def compare(file: Path, scene: Scene, duration: float) -> list[Row]:
    """A row a formula."""
    plain = at_start(scene)
    motion = moved(plain, duration)
    theirs = with_process(in_opensim, file, states(motion, plain))
    rows = []
    for name, power in ours(motion, plain).items():
        equal, default = (theirs.power[f"{name} {rules}"] for rules in RULES)
        extra = theirs.definition[name]
        totals = (float(values.sum(axis=1).mean()) for values in (power, equal, extra, default))
        rows.append(Row(name, *totals, float(np.abs((power - equal + extra).mean(axis=0)).max())))
    return rows


def main(
    model: Annotated[Path, typer.Argument(help="File of the model.")],
    scene: Annotated[str, typer.Option(help="Made of that model.")] = "gait2392_walk",
    duration: Annotated[float, typer.Option(help="Seconds of motion, of which the first is left out.")] = 4.0,
) -> None:
    """Compare."""
    wp.config.log_level = wp.LOG_WARNING
    heads = (
        "formula",
        "ours, W",
        "OpenSim, W",
        "its definition",
        "but for that",
        "worst muscle, W",
        "with all its rules, W",
    )
    print(f"| {' | '.join(heads)} |\n|{'---|' * len(heads)}")
    for row in compare(model, wm.load(scene), duration):
        powers = f"{row.ours:.1f} | {row.opensim:.1f} | {row.definition:+.1f} | {100.0 * row.off:+.2f} %"
        print(f"| {row.formula} | {powers} | {row.muscle:.2f} | {row.default:.1f} |")


if __name__ == "__main__":
    run_script(main)
