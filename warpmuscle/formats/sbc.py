"""`.sbc` files of the Simbicon Controller Editor Framework: gains, states and their trajectories."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from warpmuscle.core.plain_text import number_of
from warpmuscle.formats.lines import Line, Lines, Notes
from warpmuscle.scene import (
    PD,
    Balance,
    Character,
    Component,
    Controller,
    Curve,
    Feedback,
    MachineState,
    Side,
    Trajectory,
)
from warpmuscle.scene.number import Free

# In the order in which a line is compared with them. No other keyword may come before one that it begins with.
KEYWORDS = (
    "PDParams", "/PDParams", "stanceHipDamping", "stanceHipMaxVelocity", "rootPredictiveTorqueScale", "ConState",
    "/ConState", "startAtState", "startingStance", "loadCharacterState", "description", "nextState", "transitionOn",
    "stateStance", "time", "dTrajX", "/dTrajX", "dTrajZ", "/dTrajZ", "vTrajX", "/vTrajX", "vTrajZ", "/vTrajZ",
    "trajectory", "/trajectory", "characterFrameRelative", "strengthTrajectory", "/strengthTrajectory", "component",
    "/component", "rotationAxis", "reverseTargetAngleOnStance", "feedbackProjectionAxis", "feedback", "/feedback",
    "cd", "cv", "dMin", "dMax", "vMin", "vMax", "baseTrajectory", "/baseTrajectory",
)  # fmt: skip
SET_POINTS = {"dTrajX": "distance_x", "dTrajZ": "distance_z", "vTrajX": "velocity_x", "vTrajZ": "velocity_z"}
BLOCKS = ("PDParams", "ConState", "trajectory", "component", "feedback", "baseTrajectory", "strengthTrajectory")
FOREIGN = ("swing_foot", "velD")  # trajectories by which a later program steers foot and speed
TORQUE_LIMIT = 10000.0  # N m, of a row with a stiffness only
UNKNOWN = "unknown keyword"
MISPLACED = "has no meaning here"
REPLACED = "replaced by a later line"


@dataclass
class Contents:
    """What a file holds."""

    controller: Controller
    initial_state: Line | None = None  # the line that names a .rs file; its `rest` is the path


def read(path: str | Path, character: Character, notes: Notes) -> Contents:
    """Read a controller.

    Args:
        path: the file.
        character: whose joints it moves; its inertias give the torque scales of rows `joint kp`.
        notes: gets the lines that were ignored, and the place of every key.

    Raises:
        SceneError: with file and line.
    """
    lines = Lines(Path(path), KEYWORDS, notes)
    contents = Contents(Controller(states=[]))
    controller = contents.controller
    singles: dict[str, Line] = {}
    rows: dict[str, Line] = {}
    for line in lines:
        if line.keyword in ("stanceHipDamping", "stanceHipMaxVelocity", "rootPredictiveTorqueScale"):
            _replace(singles, line, notes)
        match line.keyword:
            case "PDParams":
                _read_gains(line, lines, controller.pd, rows, character)
            case "stanceHipDamping":
                controller.stance_hip_damping = line.quantity("N m s^2/rad^2", notes)
            case "stanceHipMaxVelocity":
                controller.stance_hip_max_velocity = line.quantity("rad/s", notes)
                line.mark(notes, "controller.stance_hip_max_velocity")
            case "rootPredictiveTorqueScale":
                controller.root_predictive_torque_scale = line.quantity("a factor", notes)
            case "ConState":
                _read_state(line, lines, controller)
            case "startAtState":
                _start(line, controller)
            case "startingStance":
                controller.start_stance = _side(line)
            case "loadCharacterState":
                line.word("the path of a .rs file")
                _replace(singles, line, notes)
                contents.initial_state = line
            case _:
                line.ignore(notes, MISPLACED if line.keyword else UNKNOWN)
    _leave_out_foreign(controller, character, notes)
    if not controller.states:
        notes.places.setdefault("controller", (Path(path), 0))
    return contents


def _leave_out_foreign(controller: Controller, character: Character, notes: Notes) -> None:
    """Drop trajectories by which a later program steers what is no joint, and list them as ignored."""
    for index, state in enumerate(controller.states):
        for name in FOREIGN:
            if name in state.trajectories and name not in character.joints:
                del state.trajectories[name]
                path, line = notes.places[f"controller.states.{index}.trajectories.{name}"]
                reason = "no joint: a later program steers by it; here nothing does, so the gait may be another one"
                notes.ignore(path, line, name, reason)


def _replace(previous: dict[str, Line], line: Line, notes: Notes, key: str = "") -> None:
    """Remember a line by its keyword, and list an earlier one that it overrides as ignored."""
    if earlier := previous.get(key or line.keyword):
        earlier.ignore(notes, REPLACED)
    previous[key or line.keyword] = line


def _start(line: Line, controller: Controller) -> None:
    """`startAtState i` is a full transition: the state's own rule changes the stance, too."""
    index = line.index("the number of a state")
    if not 0 <= index < len(controller.states):
        raise line.error(f"no state {index} above this line", key="controller.start_state")
    rule, stance = controller.states[index].stance, controller.start_stance
    if rule == "reverse":
        controller.start_stance = "right" if stance == "left" else "left"
    elif rule != "same":
        controller.start_stance = rule
    controller.start_state = index


def _read_gains(opening: Line, lines: Lines, pd: dict[str, PD], rows: dict[str, Line], character: Character) -> None:
    """Rows `joint kp kd limit scale_x scale_y scale_z` or `joint kp`; later rows overwrite earlier ones."""
    notes = lines.notes
    for line in lines.block(opening, "/PDParams"):
        name, *words = line.text.partition("#")[0].split()
        if name == "ConState":
            raise line.error(f"`{line.keyword}` within PDParams; is `/PDParams` missing?")
        if len(words) != 1 and len(words) < 6:
            wanted = "kp alone, or kp, kd, torque limit and three scales"
            raise line.error(f"gains of {name!r}: needs {wanted}; got {number_of(len(words), 'number')}")
        if len(words) > 6:
            line.ignore(notes, "only its first 7 values are used")
        kp, *rest = (line.number_in(word, notes) for word in words[:6])
        _replace(rows, line, notes, name)
        line.mark(notes, f"controller.pd.{name}")
        if rest:
            kd, limit, x, y, z = rest
            pd[name] = PD(kp, kd, limit, (x, y, z))
        else:
            pd[name] = PD(kp, 0.1 * kp, TORQUE_LIMIT, _inertia_scale(line, name, character))


def _inertia_scale(line: Line, name: str, character: Character) -> tuple[float, float, float]:
    """Moments of inertia of a joint's child, relative to the greatest one."""
    joint = character.joints.get(name)
    body = character.bodies.get(character.root if name == "root" else joint.child if joint else "")
    if body is None:
        raise line.error(f"no joint is called {name!r}", key=f"controller.pd.{name}")
    moments = [moment for moment in body.inertia if not isinstance(moment, Free)]
    if len(moments) < 3 or not max(moments) > 0.0:
        raise line.error(f"the child of {name!r} has no inertia", key=f"controller.pd.{name}")
    x, y, z = (moment / max(moments) for moment in moments)
    return x, y, z


def _read_state(opening: Line, lines: Lines, controller: Controller) -> None:
    """Read a state up to `/ConState` and append it."""
    notes, number = lines.notes, len(controller.states)
    if opening.index("its number") != number:
        raise opening.error(f"states are numbered in order: this one must be {number}")
    key = f"controller.states.{number}"
    opening.mark(notes, key)
    state = MachineState(time=0.0)
    singles: dict[str, Line] = {}
    for line in lines.block(opening, "/ConState"):
        if line.keyword in SET_POINTS:
            _replace(singles, line, notes)
            _read_set_point(line, lines, state, key)
        elif line.keyword == "trajectory":
            _read_trajectory(line, lines, state, key)
        elif line.keyword in ("description", "nextState", "transitionOn", "stateStance", "time"):
            _replace(singles, line, notes)
            _read_state_line(line, state, notes, key)
        else:
            _stray(line, "/ConState", notes)
    for keyword in ("nextState", "stateStance", "time"):
        if keyword not in singles:
            raise opening.error(f"this state has no `{keyword}`", key=key)
    controller.states.append(state)


def _read_state_line(line: Line, state: MachineState, notes: Notes, key: str) -> None:
    """One of the single-line attributes of a state."""
    if line.keyword == "description":
        state.description = line.rest
    elif line.keyword == "nextState":
        state.next = line.index("the number of a state")
        line.mark(notes, f"{key}.next")
    elif line.keyword == "transitionOn":
        state.transition = "foot_down" if line.choice("footDown", "timeUp") == "footDown" else "time_up"
    elif line.keyword == "stateStance":
        state.stance = line.choice("left", "right", "reverse", "same")  # type: ignore[assignment]
    else:
        state.time = line.quantity("s", notes)
        line.mark(notes, f"{key}.time")


def _read_set_point(line: Line, lines: Lines, state: MachineState, key: str) -> None:
    """A set point of the balance feedback; without knots it is zero, which is the same as none."""
    knots = _read_knots(line, lines)
    state.balance = state.balance or Balance()
    if knots:
        setattr(state.balance, SET_POINTS[line.keyword], _curve(knots))
    line.mark(lines.notes, f"{key}.balance.{SET_POINTS[line.keyword]}")


def _read_trajectory(opening: Line, lines: Lines, state: MachineState, key: str) -> None:
    """Read a trajectory up to `/trajectory`; it takes the place of an earlier one of the same name."""
    notes, name = lines.notes, opening.word("the name of a joint")
    path = f"{key}.trajectories.{name}"
    trajectory = Trajectory()
    strength: list[tuple[float, float]] | None = None
    for line in lines.block(opening, "/trajectory"):
        if line.keyword == "characterFrameRelative":
            trajectory.frame = "character"
        elif line.keyword == "strengthTrajectory":
            if strength is not None:
                line.ignore(notes, "replaces the strength above")
            strength = _read_knots(line, lines)
        elif line.keyword == "component":
            trajectory.components.append(
                _read_component(line, lines, f"{path}.components.{len(trajectory.components)}")
            )
        else:
            _stray(line, "/trajectory", notes)
    if strength is not None:
        trajectory.strength = _curve(strength or [(0.0, 0.0)])  # a curve without knots is zero everywhere
    if state.trajectories.pop(name, None) is not None:
        opening.ignore(notes, f"replaces the trajectory {name!r} of line {notes.places[path][1]}")
    state.trajectories[name] = trajectory
    opening.mark(notes, path)


def _read_component(opening: Line, lines: Lines, key: str) -> Component:
    """Read a rotation up to `/component`."""
    notes, knots = lines.notes, list[tuple[float, float]]()
    axis: tuple[float, float, float] | None = None
    component = Component(axis=(0.0, 0.0, 0.0))
    opening.mark(notes, key)
    singles: dict[str, Line] = {}
    for line in lines.block(opening, "/component"):
        if line.keyword in ("rotationAxis", "reverseTargetAngleOnStance", "feedback"):
            _replace(singles, line, notes)
        match line.keyword:
            case "rotationAxis":
                axis = line.triple("an axis", notes)
                line.mark(notes, f"{key}.axis")
            case "reverseTargetAngleOnStance":
                component.reverse_on = _side(line)
            case "feedback":
                component.feedback = _read_feedback(line, lines, f"{key}.feedback")
            case "baseTrajectory":
                line.mark(notes, f"{key}.phase")
                if line.rest.partition("#")[0].strip() and "baseTrajectory" in singles:
                    line.ignore(notes, "one curve is used, not several by speed: the first one")
                    _read_knots(line, lines)
                    continue
                singles["baseTrajectory"] = line
                knots = _sorted(knots + _read_knots(line, lines), line, notes)
            case _:
                _stray(line, "/component", notes)
    if axis is None:
        raise opening.error("this component has no `rotationAxis`", key=f"{key}.axis")
    component.axis = axis
    component.phase = [phase for phase, _ in knots]
    component.angle = [angle for _, angle in knots]
    return component


def _read_feedback(opening: Line, lines: Lines, key: str) -> Feedback:
    """Read a linear feedback up to `/feedback`."""
    opening.choice("linear")
    opening.mark(lines.notes, key)
    axis: tuple[float, float, float] | None = None
    numbers = {"cd": 0.0, "cv": 0.0, "dMin": -1000.0, "dMax": 1000.0, "vMin": -1000.0, "vMax": 1000.0}
    singles: dict[str, Line] = {}
    for line in lines.block(opening, "/feedback"):
        if line.keyword in (*numbers, "feedbackProjectionAxis"):
            _replace(singles, line, lines.notes)
        if line.keyword == "feedbackProjectionAxis":
            axis = line.triple("an axis", lines.notes)
            line.mark(lines.notes, f"{key}.axis")
        elif line.keyword in numbers:
            numbers[line.keyword] = line.quantity("a number", lines.notes)
        else:
            _stray(line, "/feedback", lines.notes)
    if axis is None:
        raise opening.error("this feedback has no `feedbackProjectionAxis`", key=f"{key}.axis")
    d_limits, v_limits = (numbers["dMin"], numbers["dMax"]), (numbers["vMin"], numbers["vMax"])
    return Feedback(axis=axis, cd=numbers["cd"], cv=numbers["cv"], d_limits=d_limits, v_limits=v_limits)


def _read_knots(opening: Line, lines: Lines) -> list[tuple[float, float]]:
    """Rows `phase value` up to the end of a block, sorted by phase."""
    knots = []
    for line in lines.block(opening, f"/{opening.keyword}"):
        if line.keyword:
            raise line.error(f"`{line.keyword}` within a {opening.keyword}; is `/{opening.keyword}` missing?")
        phase, value = line.numbers(2, "phase and value", lines.notes)
        knots.append((phase, value))
    return _sorted(knots, opening, lines.notes)


def _sorted(knots: list[tuple[float, float]], opening: Line, notes: Notes) -> list[tuple[float, float]]:
    """Knots in order of phase; of several at one phase the last one in the file stays."""
    by_phase: dict[float, float] = {}
    for phase, value in knots:
        if phase in by_phase:
            opening.ignore(notes, f"its knot at phase {phase:g} of value {by_phase[phase]:g}: a later one replaces it")
        by_phase[phase] = value
    return sorted(by_phase.items())


def _curve(knots: list[tuple[float, float]]) -> Curve:
    return Curve(phase=[phase for phase, _ in knots], value=[value for _, value in knots])


def _side(line: Line) -> Side:
    return "left" if line.choice("left", "right") == "left" else "right"


def _stray(line: Line, end: str, notes: Notes) -> None:
    """A line that a block does not expect: ignored, unless it shows that the block was not closed."""
    if line.keyword in BLOCKS or line.keyword.startswith("/"):
        raise line.error(f"unexpected `{line.keyword}`; is `{end}` missing?")
    line.ignore(notes, MISPLACED if line.keyword else UNKNOWN)
