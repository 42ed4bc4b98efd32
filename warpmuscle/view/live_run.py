"""A simulation that goes on in real time while its numbers change and it is pushed; numbers only."""

from __future__ import annotations

import msgspec
import numpy as np

from warpmuscle.arrays import Floats
from warpmuscle.parameters import start_values, substitute
from warpmuscle.pose import about, rotate, twist_angle
from warpmuscle.recording import Recording
from warpmuscle.rollout import Rollout
from warpmuscle.scene import Balance, Controller, Curve, Scene, State
from warpmuscle.status import Status
from warpmuscle.view.track import UP, Track, doll_of, track_of

EPISODE = 300.0  # s, after which the simulation starts again
RATE = 50.0  # frames a second
PUSH_DURATION = 0.1  # s
LONGEST = 0.1  # s of wall time that are made up for, so that a slow machine slows the motion down


class LiveRun:
    """One instance of a scene, recorded as it goes.

    Attributes:
        values: (P,) of the free parameters; `apply` makes changes count.
        faster: m/s, added to the set point of the controller's forward velocity; `turned`: rad, to its heading.
    """

    def __init__(self, scene: Scene, device: str | None = "cpu") -> None:
        """Prepare a scene; its duration does not count. Raises SceneError and RolloutError as `Rollout` does."""
        self.scene = msgspec.structs.replace(scene, duration=EPISODE)
        self.rollout = Rollout(self.scene, 1, device, record=[0], record_rate=RATE)
        self.parameters = self.rollout.parameters
        self.values: Floats = start_values(self.scene)
        self.faster = self.turned = 0.0
        self.numeric = substitute(self.scene, self.values)
        self._doll = doll_of(self.numeric, self.rollout.recording().muscle_names)
        self._every = max(round(1.0 / (RATE * scene.time_step)), 1)
        self.restart()

    def restart(self) -> None:
        """Back to the start, with the parameters as they are now."""
        self.rollout.state.push_steps.zero_()
        self.rollout.reset()
        self._clock = 0.0  # s, that the motion has come to
        self.rollout.advance(1)  # the first frame

    @property
    def time(self) -> float:
        """Simulated time, s."""
        return self.rollout.time

    @property
    def status(self) -> Status:
        """How it goes; `COMPLETED` once the time is up."""
        status = Status(self.rollout.status()[0])
        return Status.COMPLETED if status == Status.RUNNING and self.time >= EPISODE - 0.1 else status

    def advance(self, passed: float) -> None:
        """Go on by a time, s, in whole frames."""
        self._clock = min(self._clock + min(passed, LONGEST), EPISODE)
        frames = int(self._clock / (self._every * self.scene.time_step))
        self.rollout.advance(min(frames * self._every + 1, self.rollout.steps))

    def step(self) -> None:
        """Go on by one frame."""
        self.advance(self._every * self.scene.time_step * 1.0001)

    def apply(self) -> None:
        """Go on with the values as they are now; what concerns the start counts after the next `restart`."""
        numeric = substitute(self.scene, self.values)
        if numeric.controller is not None:
            controller = steered(numeric.controller, self.faster, self.turned)
            numeric = msgspec.structs.replace(numeric, controller=controller)
        self.rollout.change(numeric)
        self.numeric = numeric
        self._doll = doll_of(numeric, self._doll.muscles.names)

    def push(self, impulse: float, angle: float) -> Floats:
        """Push the root from now on for 0.1 s; returns the impulse (3,), N s, world.

        Args:
            impulse: N s. angle: rad, about the vertical from straight ahead, to the left.
        """
        facing = about(UP, twist_angle(self.window(0.0).root_orientation[-1], UP) + angle)
        vector = rotate(facing, np.array([0.0, 0.0, impulse]))
        state, steps = self.rollout.state, max(round(PUSH_DURATION / self.scene.time_step), 1)
        state.push.assign((vector[None] / (steps * self.scene.time_step)).astype(np.float32))
        first = self.rollout.steps_done
        state.push_steps.assign(np.array([[first, first + steps]], dtype=np.int32))
        return vector

    def window(self, length: float) -> Recording:
        """The last so many seconds of the motion, or its last frame."""
        return self.rollout.recording(0, start=max(self.time - length, 0.0))

    def track(self, length: float = 0.0) -> Track:
        """What is shown of the last so many seconds."""
        return track_of(self.window(length), self.numeric, self.scene.name, doll=self._doll)


def can_change_speed(controller: Controller | None) -> bool:
    """Whether a controller has balance feedback of the forward velocity, whose set point can be moved."""
    if controller is None:
        return False
    trajectories = (trajectory for state in controller.states for trajectory in state.trajectories.values())
    feedbacks = (component.feedback for trajectory in trajectories for component in trajectory.components)
    return any(feedback is not None and feedback.axis[2] != 0.0 and feedback.cv != 0.0 for feedback in feedbacks)


def steered(controller: Controller, faster: float, turned: float) -> Controller:
    """A controller without free parameters whose set points of velocity and heading are greater."""
    states = [_with_velocity(state, faster) for state in controller.states]
    heading = float(np.asarray(controller.desired_heading)) + turned
    return msgspec.structs.replace(controller, states=states, desired_heading=heading)


def _with_velocity(state: State, faster: float) -> State:
    balance = state.balance if state.balance is not None else Balance()
    curve = balance.velocity_z if balance.velocity_z is not None else Curve([0.0], [0.0])
    value = [float(np.asarray(number)) + faster for number in curve.value]
    balance = msgspec.structs.replace(balance, velocity_z=msgspec.structs.replace(curve, value=value))
    return msgspec.structs.replace(state, balance=balance)
