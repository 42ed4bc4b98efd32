"""The controller by quadratic programmes in a batch: it decides between launches of the step, for all at once."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import warp as wp

from warpmuscle.core.array_types import Integers
from warpmuscle.core.arrays import structs_to_device, to_device
from warpmuscle.kernels import stages, structs
from warpmuscle.kernels.inverse import inverse_dynamics as dynamics
from warpmuscle.kernels.inverse import muscle_moments
from warpmuscle.kernels.memory.scratch import capacity_of, work_floats
from warpmuscle.kernels.muscle.muscle_kind import MuscleKind
from warpmuscle.kernels.program import gather
from warpmuscle.kernels.program.frames import body_frames
from warpmuscle.kernels.program.structs import Frames, Layout
from warpmuscle.model.controllers.program import decision_steps, places_of
from warpmuscle.model.path_table import Lever
from warpmuscle.model.polynomials import monomial_room
from warpmuscle.model.structure import Structure
from warpmuscle.scene import Scene
from warpmuscle.simulation.program.program_batch import ProgramBatch

MARGIN = 0.005  # m, above the ground where a point of a foot counts as touching it
EDGES = 4  # of a friction cone


class StepProgram:
    """Decisions of a batch of instances.

    Attributes:
        every: steps between two of an instance. batch: the programmes of the last ones.
    """

    def __init__(
        self, scene: Scene, structure: Structure, model: structs.Model, instances: int, muscles: MuscleKind | None,
        device: Any,
    ) -> None:  # fmt: skip
        """Make room.

        Args:
            model: of the batch, for the places of contact points. muscles: as the step has them compiled in.
        """
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
        monomials = monomial_room(scene.character.muscles.values())
        floats = work_floats(capacity_of(len(names.bodies)), True, monomials)
        self._workspace = self._room(floats)
        self._frames = self._frames_of(len(names.bodies), n)
        self._no_rate, self._needed, self._followed = (self._room(n) for _ in range(3))
        self._pull, self._row = self._room(n), self._room(2, n)
        self._bound = self._room(max(len(points), 1))
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

    def is_due(self, step: int, begun: Integers) -> bool:
        """Whether a running instance decides in this step."""
        return bool(((step - begun) % self.every == 0).any())

    def decide(self, model: structs.Model, state: structs.State, extension: Any) -> None:
        """Let all running instances that are due decide.

        Args:
            extension: parameters and memory of the controller, see `kernels.force.extensions`.
        """
        batch, frames, layout = self.batch, self._frames, self._layout
        self._launch(gather.find_due, [state, layout], [batch.due])
        self._launch(body_frames, [model, state, self._workspace, self._no_rate], [frames])
        batch.numbers.mass.zero_()
        mass = batch.numbers.mass.reshape((self._instances, batch.coordinates, batch.coordinates))
        self._launch(stages.mass_matrix, [model, state, self._workspace], [mass])
        outputs = [self._needed, self._followed, *self._wrench, self._turned]
        self._launch(dynamics.inverse_dynamics, [model, state, self._workspace, self._no_rate, self._no_loads], outputs)
        self._look_at_muscles(model, state)
        given = extension.parameters, extension.by_joint, extension.by_body
        inputs = [model, state, frames, layout, batch.due, *given, extension.memory, batch.numbers, batch.work]
        self._launch(gather.gather_tasks, [*inputs, self._pull, self._row], [self._bound])
        inputs = [model, state, frames, layout, batch.due, *given[:2], batch.columns, self._moment_arm, self._active]
        self._launch(
            gather.gather_forces, [*inputs, self._passive, self._needed, self._bound, self._row], [batch.numbers]
        )
        batch.solve()
        found = batch.control, batch.acceleration, batch.iterations
        self._launch(gather.tell_muscles, [model, state, layout, batch.due, batch.numbers, *found], [extension.memory])

    def _look_at_muscles(self, model: structs.Model, state: structs.State) -> None:
        """Moment arms and forces of all muscles, with rigid tendons."""
        if self._muscles is None:
            return
        paths = muscle_moments.muscle_moments_of(self._muscles.paths)
        outputs = [self._arm, self._length, self._speed, self._moment_arm]
        self._launch(paths, [model, state, self._workspace, self._levers], outputs)
        forces = muscle_moments.fibre_forces_of(self._muscles.curves, self._muscles.special_curves)
        shape = self._instances, len(self._structure.actuation.muscles)
        inputs = [model, self._no_tendon, self._length, self._speed]
        wp.launch(forces, shape, inputs, [self._fibre, self._active, self._passive], device=self._device)

    def _launch(self, kernel: Any, inputs: list[Any], outputs: list[Any]) -> None:
        wp.launch(kernel, self._instances, inputs, outputs, device=self._device)


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
