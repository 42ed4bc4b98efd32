"""A model of OpenSim that is posed again and again: what `opensim_oracle.py` asks it for."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from opensim_drift import put_right

Floats = NDArray[np.float64]
STEP = np.radians(0.1)  # of the small moves, rad of all rotations together
SMALL = 1e-5  # rad or m, of differences
LINE = 500  # small moves in a row
UNBOUNDED = {True: np.pi, False: 1.0}  # rad, m: range of a coordinate whose range says nothing


class Posed:
    """A model of OpenSim with one state that is posed again and again, and the same model without forces."""

    def __init__(self, file: Path) -> None:
        import opensim

        opensim.Logger.setLevelString("off")
        self.opensim, self.model, self.bare = opensim, opensim.Model(str(file)), opensim.Model(str(file))
        self.bare.updForceSet().clearAndDestroy()
        self.bare.updControllerSet().clearAndDestroy()
        self.state, self.bare_state = self.model.initSystem(), self.bare.initSystem()
        self.coordinates = members(self.model.getCoordinateSet())
        self.bare_coordinates = members(self.bare.getCoordinateSet())
        self.names = coordinate_names(self.coordinates)
        self.muscles = [muscle for muscle in members(self.model.getMuscles()) if muscle.appliesForce(self.state)]
        self.rotational = np.array([coordinate.getMotionType() != 2 for coordinate in self.coordinates])
        self.couplers = self._couplers()
        self.held = [c.getLocked(self.state) or c.isPrescribed(self.state) for c in self.coordinates]
        coupled = {dependent for dependent, *_ in self.couplers}
        known = [k for k, held in enumerate(self.held) if not held and k not in coupled]
        self.independent = np.array(known, dtype=np.int64)
        self.start = np.array([c.getDefaultValue() for c in self.coordinates])
        self.place = self._places()

    def _couplers(self) -> list[tuple[int, list[int], Any, float]]:
        """Dependent and independent coordinates, function and its factor, of the couplers that are enforced."""
        found = []
        for constraint in members(self.model.getConstraintSet()):
            coupler = self.opensim.CoordinateCouplerConstraint.safeDownCast(constraint)
            if coupler is None or not coupler.isEnforced(self.state):
                continue
            independent = coupler.getIndependentCoordinateNames()
            dependent = self.names.index(coupler.getDependentCoordinateName())
            masters = [self.names.index(independent.get(k)) for k in range(independent.getSize())]
            scale = self.opensim.PropertyHelper.getValueDouble(coupler.getPropertyByName("scale_factor"))
            found.append((dependent, masters, coupler.getFunction(), scale))
        return found

    def _places(self) -> list[int]:
        """Where each coordinate stands in the vector of all coordinates of the state."""
        before, found = self.bare_state.getQ().to_numpy().copy(), []
        for coordinate in self.bare_coordinates:
            value = coordinate.getValue(self.bare_state)
            coordinate.setLocked(self.bare_state, False)
            coordinate.setValue(self.bare_state, value + 0.25, False)
            found.append(int(np.argmax(np.abs(self.bare_state.getQ().to_numpy() - before))))
            coordinate.setValue(self.bare_state, value, False)
        return found

    def range(self, k: int) -> tuple[float, float]:
        """Of an independent coordinate."""
        low, high = self.coordinates[k].getRangeMin(), self.coordinates[k].getRangeMax()
        widest = UNBOUNDED[bool(self.rotational[k])]
        return (-widest, widest) if high - low > 50.0 or not low < high else (low, high)

    def random_poses(self, generator: np.random.Generator, count: int, beyond: float = 0.0) -> Floats:
        """Poses (count, K) with couplers satisfied; beyond the ranges by up to a part of them."""
        q = np.repeat(self.start[None], count, axis=0)
        for k in self.independent:
            low, high = self.range(k)
            more = beyond * (high - low)
            q[:, k] = generator.uniform(low - more, high + more, count)
        return np.array([self.coupled(pose) for pose in q]).reshape(q.shape)

    def coupled(self, q: Floats) -> Floats:
        """A pose with the dependent coordinates of couplers as they say."""
        q = q.copy()
        for dependent, masters, function, factor in self.couplers:
            q[dependent] = factor * function.calcValue(self.opensim.Vector.createFromMat(q[masters]))
        return q

    def consistent(self, q: Floats, rate: Floats, acceleration: Floats) -> tuple[Floats, Floats]:
        """Rates and accelerations with those of dependent coordinates as the couplers say."""
        rate, acceleration = rate.copy(), acceleration.copy()
        for dependent, masters, function, factor in self.couplers:
            v = rate[masters]

            def slopes(at: Floats, of: Any = function, times: float = factor) -> Floats:
                x = self.opensim.Vector.createFromMat(at)
                return times * np.array([of.calcDerivative((k,), x) for k in range(len(at))])

            slope = slopes(q[masters])
            if len(masters) == 1:
                twice = (0, 0)
                x = self.opensim.Vector.createFromMat(q[masters])
                bend = np.array([[factor * function.calcDerivative(twice, x)]])
            else:  # OpenSim 4.6 gives a first derivative of a polynomial of several for its second one
                steps = SMALL * np.eye(len(masters))
                bend = np.array([(slopes(q[masters] + e) - slopes(q[masters] - e)) / (2.0 * SMALL) for e in steps])
            rate[dependent] = slope @ v
            acceleration[dependent] = slope @ acceleration[masters] + v @ bend @ v
        return rate, acceleration

    def pose(self, q: Floats, rate: Floats) -> None:
        """Put the state there; muscles at their default states."""
        self.put(self.state, self.coordinates, q)
        self.put_speeds(self.model, self.state, rate)
        self.model.realizeVelocity(self.state)

    def put(self, state: Any, coordinates: list[Any], q: Floats) -> None:
        values = state.getQ().to_numpy().copy()
        values[self.place] = q
        state.setQ(self.opensim.Vector.createFromMat(values))

    def put_speeds(self, model: Any, state: Any, rate: Floats) -> None:
        model.realizePosition(state)
        state.setU(self.speeds(model, state, rate))

    def speeds(self, model: Any, state: Any, rate: Floats) -> Any:
        """The state's speeds, which are not the rates of a ball joint's angles."""
        rates = np.zeros(state.getNQ())
        rates[self.place] = rate
        speeds = self.opensim.Vector(state.getNU(), 0.0)
        model.getMatterSubsystem().multiplyByNInv(state, False, self.opensim.Vector.createFromMat(rates), speeds)
        return speeds

    def lengths(self) -> list[float]:
        """Of all muscles, m."""
        return [muscle.getLength(self.state) for muscle in self.muscles]

    def lengths_at(self, q: Floats) -> list[float]:
        self.put(self.state, self.coordinates, q)
        self.model.realizePosition(self.state)
        return self.lengths()

    def crossed(self, poses: Floats) -> list[tuple[int, int]]:
        """Muscles and the coordinates that their lengths feel in some poses."""
        found = np.zeros((len(self.muscles), len(self.names)), dtype=bool)
        for pose in poses:
            here = np.array(self.lengths_at(pose))
            for k in self.independent:
                moved = pose.copy()
                moved[k] += 1e-3
                found[:, k] |= np.abs(np.array(self.lengths_at(self.coupled(moved))) - here) > 1e-9
        return [(int(m), int(k)) for m, k in np.argwhere(found)]

    def moment_arms(self, crossed: list[tuple[int, int]]) -> Floats:
        """(M, K), as posed."""
        arms = np.zeros((len(self.muscles), len(self.names)))
        for m, k in crossed:
            arms[m, k] = self.muscles[m].computeMomentArm(self.state, self.coordinates[k])
        return arms

    def slopes(self, q: Floats) -> Floats:
        """(M, K) by central differences of lengths."""
        found = np.zeros((len(self.muscles), len(self.names)))
        for k in self.independent:
            before, after = (self.lengths_at(self.coupled(q + way * np.eye(len(q))[k])) for way in (-SMALL, SMALL))
            found[:, k] = -(np.array(after) - before) / (2.0 * SMALL)
        return found

    def equilibrium(self, q: Floats, activation: Floats) -> dict[str, list[float]]:
        """Force of the tendon and length of the fibre of every muscle, at rest."""
        self.pose(q, np.zeros_like(q))
        forces, fibres = [], []
        for muscle, level in zip(self.muscles, activation, strict=True):
            force = fibre = float("nan")
            try:
                muscle.setActivation(self.state, float(level))
                muscle.computeEquilibrium(self.state)
                self.model.realizeDynamics(self.state)
                force, fibre = muscle.getTendonForce(self.state), muscle.getFiberLength(self.state)
            except RuntimeError:
                pass  # OpenSim finds no equilibrium
            forces.append(force)
            fibres.append(fibre)
        return {"force": forces, "fibre": fibres}

    def dynamics(self, q: Floats, rate: Floats, acceleration: Floats) -> dict[str, Floats]:
        """Mass matrix, inverse dynamics and gravity for the independent coordinates."""
        along = self._along(q)
        needed = along.T @ self._inverse(q, rate, acceleration)
        missing, off = put_right(self, q, rate, acceleration)
        gravity = along.T @ self._inverse(q, 0.0 * q, 0.0 * q)
        matrix = self.opensim.Matrix()
        self.bare.getMatterSubsystem().calcM(self.bare_state, matrix)
        return {
            "mass": along.T @ matrix.to_numpy() @ along, "inverse_dynamics": needed, "gravity": gravity,
            "dynamics_by_slope": needed + along.T @ missing, "acceleration_off": np.array(off),
        }  # fmt: skip

    def _along(self, q: Floats) -> Floats:
        """The state's speeds for a unit rate of each independent coordinate, (S, I)."""
        self.put(self.bare_state, self.bare_coordinates, q)
        self.bare.realizePosition(self.bare_state)
        still, columns = np.zeros_like(q), []
        for k in self.independent:
            rate, _ = self.consistent(q, np.eye(len(q))[k], still)
            columns.append(self.speeds(self.bare, self.bare_state, rate).to_numpy().copy())
        return np.array(columns).T

    def _inverse(self, q: Floats, rate: Floats, acceleration: Floats) -> Floats:
        """Generalised forces of all speeds, constraints ignored."""
        state, matter = self.bare_state, self.bare.getMatterSubsystem()
        self.put(state, self.bare_coordinates, q)
        self.put_speeds(self.bare, state, rate)
        self.bare.realizeVelocity(state)
        drift = self.opensim.Vector(state.getNQ(), 0.0)
        matter.multiplyByNDot(state, False, state.getU(), drift)
        left = acceleration - drift.to_numpy()[self.place]
        rates = self.speeds(self.bare, state, left)
        return np.array(self.opensim.InverseDynamicsSolver(self.bare).solve(state, rates).to_numpy())

    def lines(self, generator: np.random.Generator, moves: int) -> Floats:
        """Poses along lines of small moves, reflected at the ends of the ranges: (lines * (LINE + 1), K)."""
        turning = np.array([k for k in self.independent if self.rotational[k]], dtype=np.int64)
        low, high = np.array([self.range(k) for k in turning]).reshape(-1, 2).T
        found = []
        for start in self.random_poses(generator, -(-moves // LINE)):
            way = generator.normal(size=len(turning))
            way *= STEP / np.linalg.norm(way)
            along = start[turning] + way * np.arange(LINE + 1)[:, None]
            phase = (along - low) % (2.0 * (high - low))
            poses = np.repeat(start[None], LINE + 1, axis=0)
            poses[:, turning] = low + np.minimum(phase, 2.0 * (high - low) - phase)
            found.append(np.array([self.coupled(pose) for pose in poses]))
        return np.concatenate(found) if found else np.zeros((0, len(self.names)))


def coordinate_names(coordinates: list[Any]) -> list[str]:
    """Names of all coordinates; one that comes again is called after the body that its joint carries."""
    found: list[str] = []
    for coordinate in coordinates:
        name = coordinate.getName()
        body = coordinate.getJoint().getChildFrame().findBaseFrame().getName()
        found.append(name if name not in found else f"{body}_{name}")
    return found


def excite(model: Any, function_of: Callable[[str], Any]) -> None:
    """Let a controller excite muscles of an OpenSim model by functions of time; None: not this muscle."""
    import opensim

    brain = opensim.PrescribedController()
    brain.setName("excitations")
    for muscle in members(model.getMuscles()):
        function = function_of(muscle.getName())
        if function is not None:
            brain.addActuator(muscle)
            brain.prescribeControlForActuator(muscle.getName(), function)
    model.addController(brain)


def members(of: Any) -> list[Any]:
    """All that an OpenSim set has."""
    return [of.get(k) for k in range(of.getSize())]
