"""The controller by quadratic programmes in a batch: it decides between launches of the step, for all at once.

On a CPU threads share the instances, as they do in the step: each goes through all kernels of a decision with its own.
"""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor, wait
from functools import cached_property
from typing import Any

import numpy as np
import warp as wp

from warpmuscle.core.array_types import Integers
from warpmuscle.core.arrays import structs_to_device, to_device
from warpmuscle.kernels import structs
from warpmuscle.kernels.inverse import inverse_dynamics as dynamics
from warpmuscle.kernels.inverse import muscle_moments
from warpmuscle.kernels.memory.scratch import capacity_of, work_floats
from warpmuscle.kernels.muscle.muscle_kind import MuscleKind
from warpmuscle.kernels.program import gather
from warpmuscle.kernels.program.frames import look_at_bodies
from warpmuscle.kernels.program.muscles import chosen_forces_of, chosen_moments_of
from warpmuscle.kernels.program.structs import Frames, Layout
from warpmuscle.model.controllers.program import decision_steps, places_of
from warpmuscle.model.path_table import Lever
from warpmuscle.model.polynomials import monomial_room
from warpmuscle.model.structure import Structure
from warpmuscle.scene import Scene
from warpmuscle.simulation.program.program_batch import ProgramBatch

MARGIN = 0.005  # m, above the ground where a point of a foot counts as touching it
EDGES = 4  # of a friction cone
LEAST = 2  # instances that are worth the launches of a thread of their own


class StepProgram:
    """Decisions of a batch of instances.

    Attributes:
        every: steps between two of an instance. batch: the programmes of the last ones.
    """

    def __init__(
        self, scene: Scene, structure: Structure, model: structs.Model, instances: int, muscles: MuscleKind | None,
        device: Any, threads: int,
    ) -> None:  # fmt: skip
        """Make room.

        Args:
            model: of the batch, for the places of contact points. muscles: as the step has them compiled in.
            threads: of a CPU.
        """
        self._threads = threads if device.is_cpu else 1
        self._compiled = False
        self._shared: tuple[Integers | None, list[wp.array]] = (None, [])
        self.every = decision_steps(scene, structure.controller.custom)
        self._structure, self._instances, self._device, self._muscles = structure, instances, device, muscles
        names = structure.names
        levers = structure.actuation.table.levers(names.speed_start)
        lever_rows, order = rows_of_levers(levers, len(structure.actuation.muscles))
        self._levers = wp.zeros(0, dtype=muscle_moments.Lever, device=device)
        if levers:
            columns = {name: [getattr(one, name) for one in levers] for name in ("crossing", "body", "axis")}
            self._levers = structs_to_device(muscle_moments.Lever, columns, device)
        parents = model.skeleton.plan.numpy()["parent"].tolist()
        torques = [
            (speed, body)
            for joint in names.joints
            for body in [names.body_of_joint(joint)]
            for axis, speed in enumerate(range(names.speed_start[body], names.speed_start[body + 1]))
            if structure.actuation.drives[joint][axis] in ("torque", "assisted")
        ]
        points = foot_points(model)
        chains = [sorted(_chain(body, parents, names.speed_start)) for _, body in points]
        supports = supports_of(structure)
        chains += [sorted(_chain(body, parents, names.speed_start)) for _, _, body in supports]
        rows = [*lever_rows, *([speed] for speed, _ in torques), *(chain for chain in chains for _ in range(EDGES))]
        n = names.speeds
        self.batch = ProgramBatch(instances, n, rows, device, bounds=instances, apart=False)
        self._layout = layout = Layout()
        places = places_of(scene)
        layout.every, layout.margin = self.every, MARGIN
        layout.coordinates, layout.bodies, layout.center, layout.steps = (
            places.coordinates,
            places.bodies,
            places.center,
            places.steps,
        )
        layout.lever = to_device(order, int, device)
        layout.torque = to_device(np.array(torques, dtype=np.int64).reshape(-1, 2), int, device)
        layout.point = to_device(np.array(points, dtype=np.int64).reshape(-1, 2), int, device)
        layout.support = to_device(np.array(supports, dtype=np.int64).reshape(-1, 3), int, device)
        monomials = monomial_room(scene.character.muscles.values())
        floats = work_floats(capacity_of(len(names.bodies)), True, monomials)
        self._workspace = self._room(floats)
        self._frames = self._frames_of(len(names.bodies), n)
        self._no_rate, self._needed, self._followed = (self._room(n) for _ in range(3))
        self._pull, self._row = self._room(n), self._room(2, n)
        self._bound = self._room(max(len(chains), 1))
        self._wrench = [self._room(len(names.bodies), dtype=wp.vec3) for _ in range(3)]
        self._turned = self._room(len(names.bodies), dtype=wp.quat)
        count = max(len(structure.actuation.muscles), 1)
        crossings = max(len(structure.actuation.table.crossings), 1)
        self._arm = self._room(crossings, dtype=wp.vec3)
        self._moment_arm = self._room(max(len(order), 1))
        self._length, self._speed, self._active, self._passive = (self._room(count) for _ in range(4))
        self._fibre = wp.zeros((2, instances, count), dtype=float, device=device)
        self._no_tendon = wp.zeros((0, 0, 0), dtype=float, device=device)
        self._no_loads = dynamics.BodyLoads()
        self._no_loads.body = wp.zeros(0, dtype=int, device=device)
        for name in ("force", "point", "moment"):
            setattr(self._no_loads, name, wp.zeros((0, 0), dtype=wp.vec3, device=device))

    def _room(self, *shape: int, dtype: Any = float) -> wp.array:
        return wp.zeros((self._instances, *shape), dtype=dtype, device=self._device)

    def _frames_of(self, bodies: int, speeds: int) -> Frames:
        frames = Frames()
        for name in ("position", "velocity", "angular_velocity", "drift", "turning_drift", "com"):
            setattr(frames, name, self._room(bodies, dtype=wp.vec3))
        frames.orientation, frames.mass = self._room(bodies, dtype=wp.quat), self._room(bodies)
        frames.angular, frames.linear = self._room(speeds, dtype=wp.vec3), self._room(speeds, dtype=wp.vec3)
        frames.center = self._room(2, dtype=wp.vec3)
        return frames

    def until(self, step: int, begun: Integers) -> int:
        """The step up to which no running instance decides again, from this one.

        Args:
            begun: the steps at which they started.
        """
        return int((step + self.every - (step - begun) % self.every).min())

    def decide(
        self, model: structs.Model, state: structs.State, extension: Any, objects: Any, running: Integers,
        since: Integers,
    ) -> None:  # fmt: skip
        """Let those instances decide that are due, of those that run.

        Args:
            extension: parameters and memory of the controller, see `kernels.force.extensions`.
            objects: those beside the bodies. running: their numbers. since: how many steps ago each of them started.
        """
        due = since % self.every == 0
        chosen = running if due.all() else running[due]
        if not len(chosen):
            return
        parts = self._parts_of(chosen)
        if len(parts) == 1 or not self._compiled:  # threads must not meet in the compiler
            for part in parts:
                self._decide(part, model, state, extension, objects)
            self._compiled = True
            return
        launched = [self._pool.submit(self._decide, part, model, state, extension, objects) for part in parts]
        wait(launched)  # also for those behind one that fails, so that the state is at rest then
        for one in launched:
            one.result()

    def _parts_of(self, chosen: Integers) -> list[wp.array]:
        """The instances that decide, on the device, shared out; kept for the next decision of the same ones."""
        if self._shared[0] is not chosen:
            count = max(min(self._threads, len(chosen) // LEAST), 1)
            parts = [wp.array(part, dtype=int, device=self._device) for part in np.array_split(chosen, count)]
            self._shared = chosen, parts
        return self._shared[1]

    @cached_property
    def _pool(self) -> ThreadPoolExecutor:
        return ThreadPoolExecutor(self._threads)

    def _decide(
        self, chosen: wp.array, model: structs.Model, state: structs.State, extension: Any, objects: Any
    ) -> None:
        """Let these instances decide."""
        batch, frames, layout = self.batch, self._frames, self._layout
        mass = batch.numbers.mass.reshape((self._instances, batch.coordinates, batch.coordinates))
        outputs = [frames, mass, self._needed, self._followed, *self._wrench, self._turned]
        inputs = [chosen, model, state, self._workspace, self._no_rate, self._no_loads]
        self._launch(look_at_bodies, len(chosen), inputs, outputs)
        self._look_at_muscles(chosen, model, state)
        given = extension.parameters, extension.by_joint, extension.by_body
        inputs = [chosen, model, state, frames, layout, *given, objects, extension.memory, batch.numbers, batch.work]
        self._launch(gather.gather_tasks, len(chosen), [*inputs, self._pull, self._row], [self._bound])
        inputs = [chosen, model, state, frames, layout, *given[:2], objects, batch.columns, self._moment_arm]
        inputs += [self._active, self._passive, self._needed, self._bound, self._row]
        self._launch(gather.gather_forces, len(chosen), inputs, [batch.numbers])
        batch.solve(chosen)
        found = batch.control, batch.acceleration, batch.iterations
        inputs = [chosen, model, state, layout, batch.numbers, *found]
        self._launch(gather.tell_muscles, len(chosen), inputs, [extension.memory])

    def _look_at_muscles(self, chosen: wp.array, model: structs.Model, state: structs.State) -> None:
        """Moment arms and forces of all muscles, with rigid tendons."""
        if self._muscles is None:
            return
        outputs = [self._arm, self._length, self._speed, self._moment_arm]
        moments = chosen_moments_of(self._muscles.paths)
        self._launch(moments, len(chosen), [chosen, model, state, self._workspace, self._levers], outputs)
        forces = chosen_forces_of(self._muscles.curves, self._muscles.special_curves)
        shape = len(chosen), len(self._structure.actuation.muscles)
        inputs = [chosen, model, self._no_tendon, self._length, self._speed]
        self._launch(forces, shape, inputs, [self._fibre, self._active, self._passive])

    def _launch(self, kernel: Any, shape: Any, inputs: list[Any], outputs: list[Any]) -> None:
        wp.launch(kernel, shape, inputs, outputs, device=self._device)


def foot_points(model: structs.Model) -> list[tuple[int, int]]:
    """Points of contact in the lower half of each foot, without its toes: their numbers, and their bodies.

    Toes are light: what the ground does to them is no more than a disturbance of the foot.
    """
    plan, place = model.skeleton.plan.numpy(), model.contacts.point.numpy()["place"][0]
    found = []
    for body in sorted({model.feet.left, model.feet.right} - {0}):
        own = range(int(plan[body]["first_point"]), int(plan[body]["end_point"]))
        middle = np.mean([place[k][1] for k in own]) + 1e-6 if own else 0.0
        found += [(k, body) for k in own if place[k][1] <= middle]
    return found


def supports_of(structure: Structure) -> list[tuple[int, int, int]]:
    """Shapes of bodies that may lean on a fixed object: number among all that touch objects, object, and body."""
    places = next((entries.objects for entries in structure.forces if entries.objects is not None), None)
    if places is None:
        return []
    pairs = [(number, body) for number, bodies in enumerate(places.bodies) for body in bodies]
    return [(pair, number, body) for pair, (number, body) in enumerate(pairs) if places.fixed[number]]


def rows_of_levers(levers: Sequence[Lever], muscles: int) -> tuple[list[list[int]], list[int]]:
    """The speeds of each muscle's levers, in order, and the numbers of the levers in that order."""
    order = sorted(range(len(levers)), key=lambda k: (levers[k].muscle, levers[k].speed))
    rows: list[list[int]] = [[] for _ in range(muscles)]
    for k in order:
        rows[levers[k].muscle].append(levers[k].speed)
    return rows, order


def _chain(body: int, parents: list[int], starts: tuple[int, ...]) -> list[int]:
    """Speeds that move a body."""
    found: list[int] = []
    while body >= 0:
        found += range(starts[body], starts[body + 1])
        body = parents[body]
    return found
