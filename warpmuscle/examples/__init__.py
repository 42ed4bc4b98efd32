"""Small data of our own, so that every command of the documentation can be typed as it stands.

May import: throw and all below.
To add: files into `files/`, or a function that makes them, and an `Example` in `EXAMPLES`.
"""

from __future__ import annotations

import difflib
from collections.abc import Callable, Iterable
from importlib import resources
from importlib.resources.abc import Traversable
from pathlib import Path
from typing import NamedTuple

from warpmuscle.core.errors import Error
from warpmuscle.core.files import replace_files, unwritable
from warpmuscle.examples.studies import LEVEL_WALK, STUDIES

Files = Iterable[tuple[str, str | bytes]]


def shipped(*names: str) -> Callable[[], Files]:
    """Files that are shipped as they are."""

    def make() -> Files:
        folder = resources.files("warpmuscle.examples") / "files"
        return [(name, _content(folder / name)) for name in names]

    return make


def _content(file: Traversable) -> str | bytes:
    """Text, or the bytes of what is no text."""
    return file.read_bytes() if file.name.endswith(".h5") else file.read_text("utf-8")


def _emg() -> Files:
    from warpmuscle.examples.emg import walking_emg

    return walking_emg()


def _gait() -> Files:
    from warpmuscle.examples.motions import tracked_gait

    return [("gait.npz", tracked_gait()), *shipped("track.toml")()]


def _lift() -> Files:
    from warpmuscle.examples.emg import lifting_emg
    from warpmuscle.examples.motions import LIFT, table

    return [("lift.csv", table(LIFT)), ("lift_emg.csv", lifting_emg())]


def _markers() -> Files:
    from warpmuscle.examples.markers import marker_files

    return marker_files()


def _model() -> Files:
    from warpmuscle.examples.motions import opensim_model

    return [*opensim_model(), *shipped("reach.toml")()]


def _simbicon() -> Files:
    from warpmuscle.examples.motions import simbicon_files

    return simbicon_files()


def _throws() -> Files:
    from warpmuscle.examples.motions import THROWS, table

    return [(f"throws/throw{number}.csv", table(throw)) for number, throw in enumerate(THROWS, 1)]


class Example(NamedTuple):
    """What a name stands for."""

    description: str
    make: Callable[[], Files]  # names and contents of the files


EXAMPLES = {
    "scene": Example(
        "a scene to start from: the walk at another speed, with a free stiffness of the knees", shipped("mine.toml")
    ),
    "muscles": Example("a walk whose knees are driven by four muscles", shipped("knees.toml", "my_muscles.toml")),
    "curve": Example("a muscle curve as a Warp function, and a walk that uses it", shipped("bell.py", "bell.toml")),
    "term": Example("a term of the objective as a Warp function", shipped("sway.py", "sway.toml")),
    "memory": Example(
        "a term with parameters and a memory, which sees accelerations", shipped("gentle.py", "gentle.toml")
    ),
    "controller": Example("a controller as Warp functions, which holds a pendulum", shipped("hold.py", "hold.toml")),
    "gains": Example(
        "a controller with gains of each joint, and a record of its own", shipped("steady.py", "steady.toml")
    ),
    "force": Example("an ankle exoskeleton, air drag, and a custom force", shipped("glider.py", "exo.toml")),
    "devices": Example("weak ankles with a brace, a motor and a harness", shipped("braced.toml")),
    "stages": Example("a search in stages, every candidate disturbed", shipped("stages.toml")),
    "mujoco": Example("a model of MuJoCo, and a scene that moves it", shipped("elbow.xml", "curl.toml")),
    "study": Example("a study of weak calves, over seeds", shipped("weak_calves.toml")),
    "studies": Example(
        "published studies, each of which `warpmuscle study NAME` runs",
        shipped(*(f"{name}.toml" for name in STUDIES), LEVEL_WALK),
    ),
    "patient": Example(
        "a made-up patient: a walk to record, and changes whose effect is predicted",
        shipped("recorded.toml", "patient.toml"),
    ),
    "sweep": Example("a sweep over seeds, speeds and weakness", shipped("speeds.toml")),
    "learning": Example("an arm that learns to reach by its six muscles", shipped("reaching.toml")),
    "task": Example(
        "a task of one's own: points to come to, rewards, what is observed, ends, starts and a curriculum",
        shipped("reaching.toml", "fetch.toml", "fetch.py"),
    ),
    "creatures": Example(
        "animals as short descriptions, of which `creature build` makes scenes, and what searches found",
        shipped(
            *(
                f"{space}{name}{end}.toml"
                for space in ("", "spatial_")
                for name in ("kangaroo", "ostrich", "pony", "walker")
                for end in ("", "_found")
            )
        ),
    ),
    "terrain": Example(
        "a curriculum of rougher and rougher ground, for a policy that learns to walk on it",
        shipped("climb.py", "climb.toml"),
    ),
    "course": Example(
        "policies on muscles that see the ground, for stairs of 17 cm, gaps and bumps, and their tasks",
        shipped("climb.py", *(f"walk56_{name}.{end}" for name in ("stairs", "course") for end in ("toml", "h5"))),
    ),
    "everyday": Example(
        "tasks to learn: to get up from a seat, and to carry a kettlebell, begun with a policy that walks",
        shipped(
            "sit_to_stand.toml", "sit_to_stand.py", "carry.toml", "carry.h5", "walk56_tasks.toml", "walk56_tasks.h5"
        ),
    ),
    "policies": Example(
        "policies that walk, by command, like people, at many tasks, and on OpenSim's gait2392, where one runs",
        shipped(
            "gait2392_by_policy.toml",
            "gait2392_by_policy.h5",
            "gait2392_arms_by_policy.toml",
            "gait2392_arms_by_policy.h5",
            "gait2392_arms_from_noise.toml",
            "gait2392_arms_feet.toml",
            "gait2392_arms_feet.h5",
            "gait2392_arms_like_people.toml",
            "gait2392_arms_like_people.h5",
            "gait2392_run_by_policy.toml",
            "gait2392_run_by_policy.h5",
            *(f"walk56_{name}.{end}" for name in ("by_command", "like_people", "tasks") for end in ("toml", "h5")),
        ),
    ),
    "gait": Example("a recorded walk over the gait cycle, and a scene that tracks it", _gait),
    "model": Example("an arm as an OpenSim model, and a scene that excites its muscles", _model),
    "simbicon": Example("the walk in the files of the original SIMBICON program", _simbicon),
    "throws": Example("four throws of an arm: times and joint angles", _throws),
    "markers": Example("throws as markers on an arm and a trunk, as motion capture has them", _markers),
    "lift": Example("an arm that lifts: joint angles, and raw EMG of shoulder and elbow", _lift),
    "emg": Example("raw EMG of seven muscles while walking, and the times of the strides", _emg),
}


def _holds(path: Path, content: str | bytes) -> bool:
    """Whether a file is what an example would write, as where two examples share it."""
    try:
        return path.read_bytes() == (content.encode() if isinstance(content, str) else content)
    except OSError:
        return False


def write(name: str, folder: str | Path = ".", replace: bool = False) -> list[Path]:
    """Write the files of an example, and return their paths.

    Raises:
        Error: there is no such example, another file exists and is not to be replaced, or one cannot be written.
    """
    if name not in EXAMPLES:
        near = difflib.get_close_matches(name, EXAMPLES, n=1)
        hint = f"; did you mean {near[0]!r}?" if near else f": {', '.join(EXAMPLES)}"
        raise Error(f"there is no example called {name!r}{hint}")
    made = {Path(folder) / file: content for file, content in EXAMPLES[name].make()}
    for path, content in made.items():
        if path.exists() and not replace and not _holds(path, content):
            raise Error(f"{path} exists already; --replace writes over it")
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise Error(f"{path.parent}: {unwritable(error)}") from None
    replace_files(made)
    return list(made)
