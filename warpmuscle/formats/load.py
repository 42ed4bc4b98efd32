"""Scenes from whatever describes them: shipped scenes by name, TOML files, or the original program's files."""

from __future__ import annotations

import difflib
import warnings
from collections.abc import Iterable, Mapping, Sequence
from os import PathLike
from pathlib import Path, PurePosixPath
from typing import Any

import msgspec

from warpmuscle.core.arguments import answering, as_kind, as_number, as_path, as_truth, in_words
from warpmuscle.core.errors import SceneError
from warpmuscle.core.plain_text import readable
from warpmuscle.core.shipped import is_scene, moved_scene, shipped_file, shipped_scenes
from warpmuscle.formats import rbs, rs, sbc, toml
from warpmuscle.formats.lines import Ignored, Line, Notes
from warpmuscle.formats.overrides import with_values
from warpmuscle.scene import Actuation, Scene
from warpmuscle.scene.joints import joint_type
from warpmuscle.scene.trusted_code import trust as allow
from warpmuscle.scene.trusted_code import trusts_everything
from warpmuscle.scene.validation.muscles import SceneWarning
from warpmuscle.scene.validation.scene import check_scene
from warpmuscle.scene.validation.start import doubts_of

SUFFIXES = (".toml", ".rbs", ".sbc", ".rs")
MODELS = (".osim", ".xml", ".urdf")  # each a scene by itself
SCONE = (".scone", ".hfd")
READ = (*SUFFIXES, *MODELS, *SCONE)
NOT_SCENES = {
    **dict.fromkeys((".h5", ".hdf5"), "; wm.read opens a result"),
    **dict.fromkeys((".mot", ".sto", ".csv"), "; wm.inverse_dynamics(model, 'walk.mot') takes a motion"),
    **dict.fromkeys((".trc", ".c3d"), "; wm.inverse_kinematics(model, 'walk.trc') takes markers"),
}  # what is said of files that are often taken for scenes
SceneLike = Scene | str | PathLike[str]  # a scene, its name, or its file


@answering(
    {
        **dict.fromkeys(("values", "overrides", "changes", "parameters", "params"), "set={'gravity': 9.81} has them"),
        **dict.fromkeys(("geometry", "mesh_dir", "geometry_path"), "wm.show(scene, meshes=FOLDER) draws with them"),
    },
    "set={'objective.target_speed': 1.25, ...} changes numbers of the scene, by their paths",
)
def load(
    *sources: SceneLike,
    set: Mapping[str, Any] | None = None,
    duration: float | None = None,
    ignored: list[Ignored] | None = None,
    keyword_rule: bool = False,
    trust: bool = False,
    ball_joints: bool = False,
    hard_points: bool = False,
    merge_welds: bool = False,
    limit_stiffness: float = 0.0,
) -> Scene:
    """A checked scene.

    Args:
        sources: the name of a shipped scene; or a scene, of which another one with other numbers is made; or a TOML
            file; or files of the Simbicon Controller Editor Framework in any order: a `.rbs` with the character, others
            with the ground, a `.sbc`, a `.rs`. Without a `.rs`, the one that the `.sbc` names is looked for from its
            folder upward. Or a model of OpenSim, `.osim`. Or one of MuJoCo, `.xml`, or a skeleton, `.urdf`, for which
            the package `mujoco` must be installed.
        set: other values in the scene, by their paths, as `--set` of the command takes them, such as
            `{"objective.target_speed": 1.25, "character.muscles.?SOL.f_max": {"factor": 0.5}}`; see `overrides`.
        duration: s, that is simulated, in place of the scene's; the same as `set={"duration": 2.0}`.
        ignored: gets what was not used; without it, that is summed up in a warning.
        keyword_rule: muscles drive only the joints that a `.rbs` marks `actuationType muscle`, where it marks any;
            otherwise all that they cross.
        trust: let code run that the scene names as `module:function`, once it is simulated.
        ball_joints: three hinges of a `.osim` through one point become a ball joint. A motion is the same, but has no
            gimbal lock, and a step fewer bodies; balance control of the original program's kind asks for such hips.
        hard_points: paths of a `.osim` jump as OpenSim's, at conditional points and off surfaces, and have all of its
            moment arms (`Character.moving_points`). Else points come in over a degree or two, and
            `Character.wrapping` is `smooth`.
        merge_welds: bodies of a `.osim` that are welded to others, or whose joints are locked, become part of these. A
            motion is the same, and a step has fewer bodies; recordings do not name them.
        limit_stiffness: N m/rad, or N/m of coordinates that are lengths: with which ranges of a `.osim` push, at the
            ends of which no CoordinateLimitForce acts. As in OpenSim, they push with no force without it.

    Warns:
        SceneWarning: one for each thing that is probably a mistake, with file, line and key (see `doubts_of`).

    Raises:
        SceneError: with file, line and key as far as they are known.
    """
    if not sources:
        raise SceneError(f"no scene given; {_available()}")
    if duration is not None:
        set = {
            **as_kind(dict, {} if set is None else set, "set"),
            "duration": as_number(duration, "duration", above=0.0),
        }
    if len(sources) == 1 and isinstance(sources[0], Scene):
        return scene_of(with_values(sources[0], set), trust=trust)
    paths = [as_path(_source(source), "source", error=SceneError) for source in sources]
    if ignored is not None:
        as_kind(list, ignored, "ignored")
    as_truth(keyword_rule, "keyword_rule")
    as_truth(trust, "trust")
    as_truth(ball_joints, "ball_joints")
    as_truth(hard_points, "hard_points")
    as_truth(merge_welds, "merge_welds")
    limit_stiffness = as_number(limit_stiffness, "limit_stiffness", least=0.0)
    suffixes = [path.suffix.lower() for path in paths]
    if len(paths) == 1 and suffixes[0] not in READ:
        paths, suffixes = [_shipped(str(sources[0]))], [".toml"]
    if suffixes == [".toml"]:
        if moved := moved_scene(paths[0]):
            raise SceneError(f"there is no such file: {moved}", file=paths[0])
        doubts: list[SceneError] = []
        scene = with_values(toml.read(paths[0], doubts), set)
        _warn(doubts if set is None else doubts_of(scene))
        if trust or trusts_everything():
            allow(scene, paths[0].absolute().parent)
        return scene
    if suffixes and suffixes[0] in SCONE and suffixes[1:] in ([], [".par"]):
        return _changed(_scenario(paths, notes := Notes()), notes, set, ignored)
    for path, suffix in zip(paths, suffixes, strict=True):
        if suffix not in SUFFIXES[1:] and not (len(suffixes) == 1 and suffix in MODELS):
            raise SceneError(f"{str(path)!r} cannot be combined with other files; only .rbs, .sbc and .rs can")
    notes = Notes()
    if suffixes == [".osim"]:
        scene = _model(paths[0], notes, ball_joints, hard_points, merge_welds, limit_stiffness)
    elif suffixes in ([".xml"], [".urdf"]):
        scene = _mujoco_model(paths[0], notes)
    else:
        scene = _combine(paths, suffixes, keyword_rule, notes)
    return _changed(scene, notes, set, ignored)


def _source(given: object) -> Any:
    """What is given as a source, unless it is known to be none."""
    if isinstance(given, Scene):
        raise SceneError("a scene that is loaded already is given alone: load(scene, set={...})")
    if isinstance(given, Mapping):
        raise SceneError("source is a name or a file; other numbers go by name: load('walk56', set={'duration': 2.0})")
    return given


def _changed(scene: Scene, notes: Notes, set: Mapping[str, Any] | None, ignored: list[Ignored] | None) -> Scene:
    """A scene with other values, whose doubts and notes are told where `load` was called."""
    scene = with_values(scene, set)
    _warn([notes.placed(doubt) for doubt in doubts_of(scene)], stacklevel=5)
    if ignored is not None:
        ignored.extend(notes.ignored)
    elif notes.ignored:
        warnings.warn(summary(notes.ignored), stacklevel=4)
    return scene


def scene_of(given: SceneLike, name: str = "scene", trust: bool = False) -> Scene:
    """The scene that a function is given: as it is, or by the name of a shipped one, or by its file.

    Args:
        name: of the function's argument. trust: let code run that the scene names.

    Raises:
        SceneError: it is none of these, or see `load`.
    """
    as_truth(trust, "trust")
    if isinstance(given, Scene):
        if trust:
            allow(given)
        return given
    if isinstance(given, str | PathLike) and given:
        return load(given, trust=trust)
    hint = "; wm.best_scene(result)[0] is that of a result" if hasattr(given, "replays") else ""
    if hasattr(given, "result"):
        hint = "; its scene is run.scene"
    elif isinstance(given, list | tuple):
        hint = "; call it once for each"
        if given and isinstance(given[0], Scene):
            hint = "; the scene is the first of these: best_scene(result)[0]"
    raise SceneError(f"{name} must be a scene, its name or its file, not {in_words(given)}{hint}")


def scene_names() -> list[str]:
    """Names of the shipped scenes; characters that scenes share are not among them."""
    return sorted(shipped_scenes())


def summary(ignored: Iterable[Ignored], heading: str = "notes on what was read:") -> str:
    """What was ignored, or taken otherwise, a line for each file and reason, below a heading."""
    groups: dict[tuple[Path, str], list[Ignored]] = {}
    for one in ignored:
        groups.setdefault((one.file, one.reason), []).append(one)
    lines = [heading]
    for (file, reason), members in groups.items():
        places = ",".join(str(one.line) for one in members if one.line)
        words = list(dict.fromkeys(one.text.split()[0] for one in members))
        which = ", ".join(words[:4]) + (", ..." if len(words) > 4 else "")
        lines.append(f"  {file}{':' + places if places else ''}: {reason} ({which})")
    return "\n".join(lines)


def _warn(doubts: Iterable[SceneError], stacklevel: int = 4) -> None:
    """A warning for each, at the place where `load` was called."""
    for doubt in doubts:
        warnings.warn(str(doubt), SceneWarning, stacklevel=stacklevel)


def _shipped(name: str) -> Path:
    """Path of a shipped scene."""
    if "/" in name or Path(name).exists():
        hint = NOT_SCENES.get(Path(name).suffix.lower(), "")
        raise SceneError(f"a scene is read from {', '.join(READ)}{hint}", file=name)
    path = shipped_file(f"{name}.toml")
    if path is not None and is_scene(path):
        return path
    suffix = Path(name).suffix.lower()
    if suffix in NOT_SCENES or (suffix[1:].isalnum() and 3 <= len(suffix) <= 5 and suffix[1].isalpha()):
        hint = NOT_SCENES.get(suffix, "")
        raise SceneError(f"there is no such file, and a scene is read from {', '.join(READ)}{hint}", file=name)
    names = scene_names()  # of which each is read, so only where one has to be said
    near = difflib.get_close_matches(name.lower(), names, n=1)
    if near:
        more = "`warpmuscle scenes` or wm.scenes() lists all"
        raise SceneError(f"there is no scene called {name!r}; did you mean {near[0]!r}? {more}")
    raise SceneError(f"there is no scene called {name!r}; {_available()}, or give a file ({', '.join(READ)})")


def _available() -> str:
    return f"shipped scenes: {', '.join(scene_names())}"


def _model(
    path: Path, notes: Notes, ball_joints: bool, hard_points: bool, merge_welds: bool, limit_stiffness: float
) -> Scene:  # fmt: skip
    """The scene of an OpenSim model."""
    from warpmuscle.formats.osim.build import load_model  # with what no other scene waits for

    return load_model(path, notes, ball_joints, hard_points, merge_welds, limit_stiffness)


def _scenario(paths: Sequence[Path], notes: Notes) -> Scene:
    """The scene of a scenario of SCONE, or of a model of Hyfydy."""
    from warpmuscle.formats.scone.scenario import load_scenario  # with what no other scene waits for

    return load_scenario(paths[0], notes, *paths[1:])


def _mujoco_model(path: Path, notes: Notes) -> Scene:
    """The scene of a model of MuJoCo."""
    from warpmuscle.formats.mujoco.build import load_mujoco

    return load_mujoco(path, notes)


def _combine(paths: Sequence[Path], suffixes: Sequence[str], keyword_rule: bool, notes: Notes) -> Scene:
    """One scene from the files of the original program."""
    by_suffix = {suffix: [p for p, s in zip(paths, suffixes, strict=True) if s == suffix] for suffix in SUFFIXES[1:]}
    for suffix in (".sbc", ".rs"):
        if len(by_suffix[suffix]) > 1:
            raise SceneError(f"more than one {suffix} file: {', '.join(map(str, by_suffix[suffix]))}")
    scene, character_file = _bodies(by_suffix[".rbs"], keyword_rule, notes)
    scene.name = readable((by_suffix[".sbc"] or [character_file])[0].stem)
    state_line: Line | None = None
    if by_suffix[".sbc"]:
        contents = sbc.read(by_suffix[".sbc"][0], scene.character, notes)
        scene.controller, state_line = contents.controller, contents.initial_state
    try:
        check_scene(scene)  # before the state, which is read in the order of the joints
        if by_suffix[".rs"]:
            if state_line is not None and _as_named(state_line) != by_suffix[".rs"][0].absolute():
                state_line.ignore(notes, f"{by_suffix['.rs'][0]} was given instead")
            scene.initial_state = rs.read(by_suffix[".rs"][0], scene.character, notes)
        elif state_line is not None:
            scene.initial_state = rs.read(_find(state_line, notes), scene.character, notes)
        check_scene(scene)
    except SceneError as error:
        raise notes.placed(error) from None
    return scene


def _bodies(paths: Sequence[Path], keyword_rule: bool, notes: Notes) -> tuple[Scene, Path]:
    """A scene with character, ground and the root's state of `.rbs` files; and the character's file."""
    scene: Scene | None = None
    character_file, ground = Path(), None
    for path in paths:
        contents = rbs.read(path, notes)
        if contents.character is not None:
            if scene is not None:
                raise SceneError(f"a scene has one character, but {character_file} has one, too", file=path)
            scene = Scene(name=readable(path.stem), character=contents.character, initial_state=contents.initial)
            # What gaits of these files are searched for in Bergmann 2017.
            scene.objective = msgspec.structs.replace(scene.objective, torque=1.0)
            character_file = path
            if keyword_rule and contents.driven:
                scene.actuation = {
                    name: Actuation("torque")
                    for name, joint in contents.character.joints.items()
                    if name not in contents.driven and joint_type(joint).moves
                }
            else:
                for line in contents.driven.values():
                    line.ignore(notes, rbs.CROSSED)
        if contents.ground is not None:
            if ground is not None:
                notes.ignore(path, 0, "ground", "there is a ground already")
            ground = ground or contents.ground
    if scene is None:
        given = f"; there is none in {', '.join(map(str, paths))}" if paths else ""
        raise SceneError(f"a .rbs file with an ArticulatedFigure is needed{given}")
    scene.ground = ground or scene.ground
    return scene, character_file


def _as_named(line: Line) -> Path:
    """The path that a controller names, taken from the controller's own folder."""
    return line.file.parent.absolute() / line.rest.replace("\\", "/")


def _find(line: Line, notes: Notes) -> Path:
    """The file that a controller names: as given, or its path's tail from the controller's folder upward."""
    named = PurePosixPath(line.rest.replace("\\", "/"))
    folder = line.file.parent
    try:
        if _as_named(line).is_file():
            return _as_named(line)
        tail = [part for part in named.parts if part not in ("..", ".", "/")]
        for above in (folder.resolve(), *folder.resolve().parents):
            for start in range(len(tail)):
                candidate = above.joinpath(*tail[start:])
                if candidate.is_file():
                    line.ignore(notes, f"not there; took {candidate}")
                    return candidate
    except (OSError, ValueError):
        pass  # a name that no file can have
    raise line.error(f"cannot find {line.rest!r}, neither as given nor by its tail from this folder upward")
