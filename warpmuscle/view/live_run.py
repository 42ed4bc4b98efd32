"""A simulation that goes on in real time while its numbers change and it is pushed; numbers only."""

from __future__ import annotations

from collections.abc import Sequence

import msgspec
import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import Error
from warpmuscle.core.pose import about, rotate, twist_angle
from warpmuscle.core.status import Status
from warpmuscle.results.recording import Recording
from warpmuscle.scene import Balance, Controller, Curve, MachineState, Scene
from warpmuscle.scene.number import Free
from warpmuscle.scene.parameters import free_parameters, leaves, start_values, substitute
from warpmuscle.scene.validation.scene import check_scene
from warpmuscle.simulation.commands import place_of_root, turned_below
from warpmuscle.simulation.rollout import Rollout
from warpmuscle.view.track import UP, Track, doll_of, track_of

EPISODE = 300.0  # s, after which the simulation starts again
RATE = 50.0  # frames a second
PUSH_DURATION = 0.1  # s
LONGEST = 0.1  # s of wall time that are made up for, so that a slow machine slows the motion down
FASTEST, FARTHEST = 0.5, float(np.pi)  # m/s and rad that steering adds at most
# Shipped walks survive a turn by 60 degrees at this rate (bigbird_walk: one way only); walk56 falls at 30 degrees/s.
SPEED_RATE, TURN_RATE = 0.1, float(np.radians(8.0))  # m/s^2 and rad/s of simulated time
COMMAND_RATE = 0.1  # of a command's range in a second of simulated time
STEERING_INTERVAL = 0.1  # s of simulated time between two steps of a ramp


class LiveRun:
    """One instance of a scene, recorded as it goes.

    Attributes:
        values: (P,) of the free parameters; `apply` makes changes count, within the parameters' bounds.
        faster: m/s to be added to the set point of the controller's forward velocity; `turned`: rad, to its heading.
            Both are reached as ramps while the motion goes on, at `SPEED_RATE` and `TURN_RATE`.
        asked: what the scene's commands are to be, by name; they get there as ramps, too.
    """

    def __init__(self, scene: Scene, device: str | None = "cpu") -> None:
        """Prepare a scene; its duration does not count.

        Raises:
            SceneError, RolloutError: as `Rollout` does.
            Error: the scene fails in its first step, so that there is nothing to see.
        """
        self._given, self._duration = scene, longest_run(scene)
        self.scene = self._lasting(scene)
        self.rollout = Rollout(self.scene, 1, device, record=[0], record_rate=RATE)
        self.parameters = self.rollout.parameters
        self.values: Floats = start_values(self.scene)
        self._applied: Floats = self.values.copy()
        self.faster = self.turned = 0.0
        self.asked = {name: one.asked for name, one in scene.commands.items()}
        self._commanded = dict(self.asked)  # on the way there
        self._following = parts_that_follow(scene)
        self._chosen = self.numeric = substitute(self.scene, self.values)  # without and with steering
        self._steering = self._unsteered()
        self._doll = doll_of(self.numeric, self.rollout.recording().muscle_names)
        self._every = max(round(1.0 / (RATE * scene.time_step)), 1)
        self._seen: Recording | None = None  # what was seen last
        self.restart()
        self.window(0.0)

    @property
    def given(self) -> Scene | None:
        """The scene with its own duration, whose numbers `use` may change; None where they are not to be changed."""
        return self._given

    def _lasting(self, scene: Scene) -> Scene:
        """A scene that goes on for as long as it is shown."""
        return msgspec.structs.replace(scene, duration=self._duration)

    def use(self, scene: Scene, parts: Sequence[str] | None = None) -> None:
        """Go on from here with another version of the scene: other numbers, other knots of curves.

        What concerns the start counts after the next `restart`. Values of free parameters that were changed here stay,
        unless this scene has others.

        Args:
            parts: of the model, that the change is in; by default all of it.

        Raises:
            SceneError: the scene is not sound; then everything stays as it was.
        """
        scene = self._lasting(scene)
        check_scene(scene)
        set_here = {(p.name, p.value): now for p, now in zip(self.parameters, self.values, strict=True)}
        parameters = free_parameters(scene)
        values = np.array([set_here.get((p.name, p.value), p.value) for p in parameters], dtype=np.float64)
        was = self.scene, self.parameters, self.values, self._applied, self._following
        self.scene, self.parameters, self.values = scene, parameters, values
        self._following = parts_that_follow(scene)
        try:
            self.apply(parts)
        except Error:
            self.scene, self.parameters, self.values, self._applied, self._following = was
            self.apply()
            raise

    def restart(self) -> None:
        """Back to the start, with the parameters as they are now; steering begins again, too."""
        self.rollout.state.push_steps.zero_()
        if self.scene.commands:
            self._commanded = self._asked()
            self._chosen = self.numeric = substitute(self.scene, self._applied, self._commanded)
            self.rollout.change(self.numeric)
        self.rollout.reset()
        self._clock = self._steered_at = 0.0  # s, that the motion has come to
        self._steer_to(self._unsteered())
        self.rollout.advance(1)  # the first frame

    @property
    def time(self) -> float:
        """Simulated time, s."""
        return self.rollout.time

    @property
    def status(self) -> Status:
        """How it goes; `COMPLETED` once the time is up."""
        status = Status(self.rollout.status()[0])
        return Status.COMPLETED if status == Status.RUNNING and self.time >= self._duration - 0.1 else status

    def advance(self, passed: float) -> None:
        """Go on by a time, s, in whole frames."""
        self._clock = min(self._clock + min(passed, LONGEST), self._duration)
        frames = int(self._clock / (self._every * self.scene.time_step))
        self._steer()
        self.rollout.advance(min(frames * self._every + 1, self.rollout.steps))

    def step(self) -> None:
        """Go on by one frame."""
        frame = self._every * self.scene.time_step
        self._clock = (int(self._clock / frame) + 0.01) * frame  # parts of a frame that are due are not two of them
        self.advance(frame)

    def apply(self, parts: Sequence[str] | None = None) -> None:
        """Go on with the values as they are now; what concerns the start counts after the next `restart`.

        Values beyond a parameter's bounds become those bounds, and what is no number the value that it had.

        Args:
            parts: of the model, that the change is in; by default all of it.
        """
        low, high = (np.array([getattr(p, bound) for p in self.parameters]) for bound in ("min", "max"))
        had = self._applied if self._applied.shape == self.values.shape else start_values(self.scene)
        self.values = np.clip(np.where(np.isnan(self.values), had, self.values), low, high)
        self._applied = self.values.copy()
        self._change(parts)
        self._doll = doll_of(self.numeric, self._doll.muscles.names)

    def _change(self, parts: Sequence[str] | None = None) -> None:
        """Go on with the values and commands as they are now; the ground stays where it is below the root.

        Args:
            parts: of the model, that the change is in; by default all of it.
        """
        chosen = substitute(self.scene, self._applied, self._commanded)
        place = place_of_root(self.rollout.coordinate_names, self.rollout.state.coordinates.numpy())
        ground = turned_below(self._chosen.ground, chosen.ground, place) if self.scene.commands else chosen.ground
        self._chosen = msgspec.structs.replace(chosen, ground=ground)
        self.numeric = self._steered()
        if parts is None:
            self.rollout.change(self.numeric)
        else:
            self.rollout.change_parts(self.numeric, parts)

    def _asked(self) -> dict[str, float]:
        """What is asked for, within the ranges of the commands; what is no number counts as the last command."""
        asked = {name: self._commanded[name] if np.isnan(value) else value for name, value in self.asked.items()}
        return {name: float(np.clip(asked[name], one.min, one.max)) for name, one in self.scene.commands.items()}

    def _command(self, passed: float) -> None:
        """Bring commands nearer to what is asked for, by as much as is due after a time, s."""
        before, asked = self._commanded, self._asked()
        self._commanded = {
            name: now + _within(asked[name] - now, COMMAND_RATE * (one.max - one.min) * passed)
            for (name, one), now in zip(self.scene.commands.items(), before.values(), strict=True)
        }
        if self._commanded != before:
            self._change(self._following)

    def _unsteered(self) -> tuple[float, float]:
        """What is added to the forward velocity, m/s, and the heading, rad, where nobody steers."""
        controller = self._chosen.simbicon
        return 0.0, 0.0 if controller is None else float(np.asarray(controller.desired_heading))

    def _steered(self) -> Scene:
        controller = self._chosen.simbicon
        if controller is None:
            return self._chosen
        return msgspec.structs.replace(self._chosen, controller=steered(controller, *self._steering))

    def _steer(self) -> None:
        """Bring velocity and heading nearer to what is asked for, by as much as is due."""
        passed = min(self.time - self._steered_at, 2.0 * STEERING_INTERVAL)
        if passed < STEERING_INTERVAL - 1e-9:
            return
        self._steered_at = self.time
        if self.asked:
            self._command(passed)
        faster, heading = self._steering
        wanted = self._unsteered()[1] + _within(self.turned, FARTHEST)
        self._steer_to((
            faster + _within(_within(self.faster, FASTEST) - faster, SPEED_RATE * passed),
            heading + _within(wanted - heading, TURN_RATE * passed),
        ))  # fmt: skip

    def _steer_to(self, steering: tuple[float, float]) -> None:
        if steering != self._steering:
            self._steering = steering
            self.numeric = self._steered()
            self.rollout.change_controller(self.numeric)

    def push(self, impulse: float, angle: float) -> Floats:
        """Push the root from now on for 0.1 s; returns the impulse (3,), N s, world.

        Args:
            impulse: N s, none if it is not a finite number.
            angle: rad, about the vertical from straight ahead, to the left.
        """
        impulse = impulse if np.isfinite(impulse) else 0.0
        facing = about(UP, twist_angle(self.window(0.0).root_orientation[-1], UP) + angle)
        vector = rotate(facing, np.array([0.0, 0.0, impulse]))
        self.push_by(vector)
        return vector

    def push_by(self, impulse: Floats) -> None:
        """Push the root from now on for 0.1 s by an impulse (3,), N s, world."""
        state, steps = self.rollout.state, max(round(PUSH_DURATION / self.scene.time_step), 1)
        state.push.assign((impulse[None] / (steps * self.scene.time_step)).astype(np.float32))
        first = self._step_now()
        state.push_steps.assign(np.array([[first, first + steps]], dtype=np.int32))

    def _step_now(self) -> int:
        """Steps of the simulation so far."""
        return self.rollout.steps_done

    def window(self, length: float) -> Recording:
        """The last so many seconds of the motion, or its last frame; what was seen before if it has none.

        Raises:
            Error: nothing was ever seen.
        """
        motion = self.rollout.recording(0, start=max(self.time - length, 0.0))
        if motion.frames:
            self._seen = motion
        if self._seen is None:
            raise Error(f"{self.scene.name} cannot be shown: in its first step it {self.status.meaning}")
        return self._seen

    def track(self, length: float = 0.0) -> Track:
        """What is shown of the last so many seconds."""
        return track_of(self.window(length), self.numeric, self.scene.name, doll=self._doll)


def longest_run(scene: Scene) -> float:
    """How long a scene can be shown, s: its prescribed motions may end."""
    ends = [motion.time[-1] for motion in scene.motion.values() if len(motion.time) > 1]
    return min([EPISODE, *ends]) if ends else EPISODE


def parts_that_follow(scene: Scene) -> tuple[str, ...] | None:
    """Parts of the model that commands change, see `model.build.PARTS`; None if there may be others than these."""
    of = {
        "controller": ("controller",),
        "ground": ("bodies", "slope"),
        "objective": ("objective",),
        "initial_state": (),
    }
    found: dict[str, None] = {}
    sources = {path for path, leaf in leaves(scene) if isinstance(leaf, Free) and leaf.per}
    for path, leaf in leaves(scene):
        if isinstance(leaf, Free) and (leaf.per or leaf.same_as in sources):
            table = "ground" if path.startswith("character.bodies.") else path.partition(".")[0]
            if table not in of:
                return None
            found |= dict.fromkeys(of[table])
    return tuple(found)


def can_change_speed(controller: Controller | None) -> bool:
    """Whether a controller has balance feedback of the forward velocity, whose set point can be moved."""
    if controller is None:
        return False
    trajectories = (trajectory for state in controller.states for trajectory in state.trajectories.values())
    feedbacks = (component.feedback for trajectory in trajectories for component in trajectory.components)
    return any(feedback is not None and feedback.axis[2] != 0.0 and feedback.cv != 0.0 for feedback in feedbacks)


def steered(controller: Controller, faster: float, heading: float) -> Controller:
    """A controller without free parameters with greater set points of the velocity, m/s, and another heading, rad."""
    states = [_with_velocity(state, faster) for state in controller.states] if faster else controller.states
    return msgspec.structs.replace(controller, states=states, desired_heading=heading)


def _within(value: float, most: float) -> float:
    """The nearest number that is not greater than the other one, in either direction; 0 for what is no number."""
    return 0.0 if np.isnan(value) else float(np.clip(value, -most, most))


def _with_velocity(state: MachineState, faster: float) -> MachineState:
    balance = state.balance if state.balance is not None else Balance()
    curve = balance.velocity_z if balance.velocity_z is not None else Curve([0.0], [0.0])
    value = [float(np.asarray(number)) + faster for number in curve.value]
    balance = msgspec.structs.replace(balance, velocity_z=msgspec.structs.replace(curve, value=value))
    return msgspec.structs.replace(state, balance=balance)
