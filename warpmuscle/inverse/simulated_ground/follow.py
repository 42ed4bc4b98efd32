"""Excitations of muscles that run a motion forward on the ground.

As computed muscle control, window by window. What muscles have to make are the efforts of the plan and the feedback to
what the run is beside it; accelerations are not prescribed, as they follow from the ground's forces, too.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.inverse.body_model import BodyLoads, BodyModel, Dynamics
from warpmuscle.inverse.coordinates import States
from warpmuscle.inverse.dynamics import Prepared
from warpmuscle.inverse.simulated_ground.floor_fit import Floor, Recorded, fit_floors, recorded
from warpmuscle.inverse.simulated_ground.foot_contact import feet_of, has_contact, scene_on_ground
from warpmuscle.inverse.simulated_ground.ground_run import GroundRun
from warpmuscle.inverse.simulated_ground.plan import Plan, Planner
from warpmuscle.inverse.simulated_ground.windows import Windows
from warpmuscle.inverse.tracking.state_difference import difference, moved_by
from warpmuscle.inverse.tracking.tracked import Tracked
from warpmuscle.inverse.tracking.tracker import Tracker, TrackingOptions, first_activations
from warpmuscle.scene.joints import root_type


class _Ground(NamedTuple):
    """What trials are followed by, beside the recordings."""

    plans: list[Plan]
    floors: list[Floor]
    recorded: list[Recorded]
    activation: Floats  # (n, M) at the starts


def ground_tracker(
    body: BodyModel, trials: Prepared, options: TrackingOptions, recorded_too: bool = False
) -> GroundTracker:
    """Put trials on the ground and plan their motions; raises ArgumentError for models without feet and loads."""
    feet, dynamics = feet_of(body), body.dynamics(trials.states, trials.loads)
    parts = [slice(first, last) for first, last in zip(trials.starts[:-1], trials.starts[1:], strict=True)]
    seen = [
        recorded(body, feet, times, _rows(dynamics, part), _rows_of(trials.loads, part))
        for times, part in zip(trials.times, parts, strict=True)
    ]
    floors = fit_floors(seen)
    sole = None if has_contact(body, feet) else floors[0].sole
    scene = scene_on_ground(body, feet, sole, floors[0].firmness)
    states = _on_floor(body, trials, floors, parts)
    windows = Windows(scene, str(body.device), options.window)
    planner, root = Planner(windows), body.topology.speed_start[1]
    plans = [
        planner.plan(states.coordinates[part], states.speeds[part], dynamics.effort[part, root:]) for part in parts
    ]
    ground = BodyModel(scene, str(body.device))
    nothing = BodyLoads([], *(np.zeros((len(states.coordinates), 0, 3)) for _ in range(3)))
    shifted = Prepared(trials.times, states, nothing, ground.map.values(states.coordinates))
    more = _Ground(plans, floors, seen, first_activations(body, trials))
    return GroundTracker(ground, shifted, replace(options, residuals=False), more, recorded_too)


def _rows(dynamics: Dynamics, part: slice) -> Dynamics:
    return Dynamics(*(array[part] for array in dynamics))


def _rows_of(loads: BodyLoads, part: slice) -> BodyLoads:
    return BodyLoads(loads.body, loads.force[part], loads.point[part], loads.moment[part])


def _on_floor(body: BodyModel, trials: Prepared, floors: list[Floor], parts: list[slice]) -> States:
    """The recorded states, lifted to the ground, and walking ahead in place of the belt."""
    q, v = trials.states.coordinates.copy(), trials.states.speeds.copy()
    for times, floor, part in zip(trials.times, floors, parts, strict=True):
        lift = np.interp(times, floor.times, floor.lift)
        for k, axis in enumerate(root_type(body.scene.character).moving):
            q[part, k] += lift if axis == 1 else -floor.belt[axis] * (times - times[0])
            v[part, k] += np.gradient(lift, times) if axis == 1 else -floor.belt[axis]
    return replace(trials.states, coordinates=q, speeds=v)


class GroundTracker(Tracker):
    """Follows plans of prepared trials on the ground, all at once."""

    def __init__(
        self, body: BodyModel, trials: Prepared, options: TrackingOptions, ground: _Ground, recorded: bool
    ) -> None:
        """Args: body: on the ground. trials: lifted to it, without loads."""
        self._ground, self._plans = ground, ground.plans
        super().__init__(body, trials, options, recorded)
        self._root = body.topology.speed_start[1]
        self._applied = np.stack([plan.effort[0] for plan in self._plans])  # (n, m) at the start of a window
        self._foot_force = np.zeros((self.windows, self.count, 2, 3))

    def _initial_activation(self) -> Floats:
        return self._ground.activation

    def _start(self) -> None:
        q, v = (np.stack([getattr(plan, name)[0] for plan in self._plans]) for name in ("coordinates", "speeds"))
        nothing = np.zeros((self.count, 0, 0))
        self.driven.start(States(q, v, np.zeros_like(v), nothing), self._initial)
        self._state[0], self._activation[0] = self.driven.state()[0], self._initial

    def _of_plans(self, name: str, w: int) -> Floats:
        """Something of all plans at a window or between two; what is over stays as it was at last."""
        every = [getattr(plan, name) for plan in self._plans]
        return np.stack([array[min(w, len(array) - 1)] for array in every])

    def _follow(self, w: int) -> None:
        alive, bare = self._alive[w][:, None], self.sharing.bare[self._root :]
        q0, v0 = self._of_plans("coordinates", w), self._of_plans("speeds", w)
        q, v = self.driven.state()
        q, v = np.where(alive, q, q0), np.where(alive, v, v0)
        here = States(q, v, np.zeros_like(v), np.zeros((self.count, 0, 0)))
        acting = self._applied
        if w > 0:
            made = self._muscle_moments(here) + self._effort[w - 1]
            acting = np.where(bare, self._applied, np.where(alive, made[:, self._root :], self._applied))
        beside = np.concatenate([difference(self.body, q0, q), v - v0, acting - self._of_plans("effort", w)], axis=1)
        answer = np.einsum("nmx,nx->nm", self._of_plans("gain", w), beside)
        effort = self._of_plans("effort", w + 1) + answer
        speeds = self.body.topology.speeds
        more = 0.5 * (beside[:, 2 * speeds :] + answer)
        after = np.einsum("nxy,ny->nx", self._of_plans("by_state", w), beside[:, : 2 * speeds])
        after += np.einsum("nxm,nm->nx", self._of_plans("by_effort", w), more)
        expected = States(
            moved_by(self.body, self._of_plans("coordinates", w + 1), after[:, :speeds]),
            self._of_plans("speeds", w + 1) + after[:, speeds:], np.zeros_like(v), here.by_root,
        )  # fmt: skip
        over = np.where(bare, 0.5 * (acting + effort), effort)  # what no muscle makes acts over all of the window
        self._applied = effort
        self._excite(w, here, expected, np.concatenate([np.zeros((self.count, self._root)), over], axis=1))
        self._run(w)

    def _muscle_moments(self, states: States) -> Floats:
        """Generalised forces (n, S) of muscles as they pull now."""
        found, force = np.zeros((self.count, self.body.topology.speeds)), self.driven.force()
        for part in self.body.chunks(self.count):
            arms = self.body.muscle_frames(states, part).moment_arm.numpy()[:, : len(self.body.lever_muscle)]
            np.add.at(found[part].T, self.body.lever_speed, (force[part][:, self.body.lever_muscle] * arms).T)
        return found

    def _tell(self, w: int, effort: Floats) -> None:
        self.driven.tell(effort)

    def _run(self, w: int) -> None:
        super()._run(w)
        force = self.driven.rollout.state.foot_force.numpy().astype(np.float64)
        self._foot_force[w] = np.where(self._alive[w + 1][:, None, None], force, 0.0)

    def _result(self, k: int) -> Tracked:
        found, plan = super()._result(k), self._plans[k]
        floor, seen, windows = self._ground.floors[k], self._ground.recorded[k], len(found.excitation)
        lift = np.interp(found.times, floor.times, floor.lift)
        own = self._foot_force[:windows, k]
        run = GroundRun(self.body.scene, lift, floor.belt, own, seen.force[1 : windows + 1], plan.gap)
        return replace(found, ground=run, start=(plan.coordinates[0], plan.speeds[0]))
