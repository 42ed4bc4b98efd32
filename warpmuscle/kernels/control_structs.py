"""Device structures of SIMBICON: gains, states, trajectories, curves as knots, what changes, and what is recorded."""

import warp as wp


@wp.struct
class Gains:
    """Of the PD controller of a joint."""

    kp: float  # N m/rad
    kd: float  # N m s/rad
    torque_limit: float  # N m
    scale: wp.vec3  # along child axes


@wp.struct
class ControlState:
    """A state of the controller's machine."""

    next_state: int
    on_foot_down: int  # 1: foot down, 0: time up
    stance_rule: int  # LEFT, RIGHT, REVERSE or SAME, on entering
    first_trajectory: int
    end_trajectory: int  # the one after its last


@wp.struct
class Trajectory:
    """Where a joint is to go in a state."""

    left_body: int  # body in left stance; -1 if a later trajectory drives its joint
    right_body: int  # in right stance
    character_frame: int
    first_knot: int  # of the strength
    end_knot: int
    first_component: int
    end_component: int


@wp.struct
class ComponentPlan:
    """What stays the same of a component: one rotation of a trajectory."""

    reverse: int  # stance that reverses the base angle, or -1
    first_knot: int
    end_knot: int
    has_feedback: int


@wp.struct
class ComponentRow:
    """Its numbers."""

    axis: wp.vec3
    feedback_axis: wp.vec3
    feedback_gain: wp.vec2  # cd, cv
    feedback_limits: wp.vec4  # d low, d high, v low, v high


@wp.struct
class Knot:
    """Of a curve."""

    phase: float
    value: float


@wp.struct
class HipControl:
    """How the stance hip moves the root."""

    damping: float  # N m s^2/rad^2
    max_velocity: float  # rad/s
    predictive_scale: float  # kg
    desired_heading: float  # rad


@wp.struct
class Simbicon:
    """The controller: gains by body (0: the root), states, trajectories, their components, and curves as knots."""

    every: int  # steps after which targets are renewed; only kernels that hold them read it
    left_hip: int
    right_hip: int
    heading_control: int
    gains: wp.array2d[Gains]  # (rows, bodies)
    hip: wp.array2d[HipControl]  # (rows, 1)
    states: wp.array[ControlState]  # (states,)
    state_time: wp.array2d[wp.vec2]  # (rows, states) nominal duration, s, and phase up to which a state may last
    balance_knots: wp.array2d[int]  # (states, 8) first and end of the curves of distance x, z and velocity x, z
    trajectories: wp.array[Trajectory]  # (trajectories,)
    components: wp.array[ComponentPlan]  # (components,)
    component_rows: wp.array2d[ComponentRow]  # (rows, components)
    knots: wp.array2d[Knot]  # (rows, knots)


@wp.struct
class SimbiconState:
    """What changes of the controller; no instances where a scene has another one, or none."""

    phase: wp.array[float]  # (instances,) of the state, 0 to 1 or more
    stance: wp.array[int]  # (instances,) LEFT or RIGHT
    machine_state: wp.array[int]  # (instances,)
    target: wp.array2d[wp.quat]  # (instances, bodies) where it holds them; else no instances
    target_plan: wp.array2d[wp.vec2]  # (instances, bodies) their strength and frame, see `Scratch`


@wp.struct
class SimbiconRecord:
    """Frames of it, (recorded, frames)."""

    phase: wp.array2d[float]
    stance: wp.array2d[int]
    machine_state: wp.array2d[int]
