"""Scenes into TOML files, OpenSim's models, or the three files of the original program."""

from __future__ import annotations

import math
import warnings
from pathlib import Path
from tempfile import TemporaryDirectory

import msgspec

from warpmuscle.core.arguments import as_kind, as_path
from warpmuscle.core.errors import SceneError
from warpmuscle.core.files import replace_files, unwritable
from warpmuscle.formats import simbicon, toml
from warpmuscle.formats.lines import Ignored
from warpmuscle.formats.load import SUFFIXES, SceneLike, load, scene_of, summary
from warpmuscle.scene import Actuation, JointState, Scene
from warpmuscle.scene.number import Free
from warpmuscle.scene.parameters import at_start, leaves, start_values, substitute
from warpmuscle.scene.validation.muscles import SceneWarning
from warpmuscle.scene.validation.paths import usual_drive
from warpmuscle.scene.validation.scene import check_scene

FIXED = "free parameters are written as their start values"
ON_LINE = "a point on a line is written where it is"
LOST = "these files cannot hold it"
ABSENT = object()
WRITTEN = (*SUFFIXES, ".osim", ".par")


def save(scene: SceneLike, path: str | Path, ignored: list[Ignored] | None = None) -> None:
    """Write a scene: as TOML, as a model of OpenSim, or as `.rbs`, `.sbc` and `.rs` files next to each other.

    As .par, SCONE's file of parameters, its free numbers are written that have a name there.

    Args:
        scene: what to write, a scene or the name or file of one; it is checked first.
        path: its suffix decides; any of .rbs, .sbc and .rs stands for all three, .osim for a model of OpenSim.
        ignored: gets what these files cannot hold; without it, that is summed up in a warning.

    Raises:
        SceneError: the scene is not sound or cannot be written.
    """
    scene, path = scene_of(scene), as_path(path, "path")
    if ignored is not None:
        as_kind(list, ignored, "ignored")
    suffix = path.suffix.lower()
    if suffix not in WRITTEN:
        raise SceneError(f"{path.name!r}: a scene is written as {', '.join(WRITTEN)}; by wm.convert as .xml, too")
    if suffix == ".toml":
        toml.write(scene, path)
        return
    check_scene(scene)
    if suffix == ".par":
        lost = _write_parameters(scene, path)
    else:
        lost = _write_model(scene, path) if suffix == ".osim" else _write_three(scene, path)
    if ignored is not None:
        ignored.extend(lost)
    elif lost:
        warnings.warn(summary(lost, "not all was written:"), stacklevel=2)


def _write_model(scene: Scene, path: Path) -> list[Ignored]:
    """Write an OpenSim model; what it cannot hold."""
    from warpmuscle.formats.osim.write import write

    plain = at_start(scene)
    free = [Ignored(path, 0, key, FIXED) for key, number in leaves(scene) if isinstance(number, Free)]
    return free + write(plain, path)


def _write_parameters(scene: Scene, path: Path) -> list[Ignored]:
    """Write a file of parameters of SCONE; those that it has no names for."""
    from warpmuscle.formats.scone.write import write_scene_parameters

    return write_scene_parameters(scene, path)


def _write_three(scene: Scene, path: Path) -> list[Ignored]:
    """Write the files; the keys that they cannot hold."""
    plain = substitute(scene, start_values(scene))
    lines = [Ignored(path, 0, key, ON_LINE) for key in _settle_on_lines(plain)]
    character, controller, state = (path.with_suffix(suffix) for suffix in (".rbs", ".sbc", ".rs"))
    texts = {character: simbicon.rbs_text(plain), state: simbicon.rs_text(plain.initial_state, plain.character)}
    if plain.simbicon is not None:
        texts[controller] = simbicon.sbc_text(plain.simbicon, state.name)
    again = _read_again(texts)
    replace_files(texts)
    free = [Ignored(path, 0, key, FIXED) for key, number in leaves(scene) if isinstance(number, Free)]
    return free + lines + [Ignored(path, 0, key, LOST) for key in _differences(plain, again)]


def _read_again(texts: dict[Path, str]) -> Scene:
    """The scene of some files before they are written.

    Raises:
        SceneError: they could not be read again, since these files cannot hold what makes the scene one.
    """
    with TemporaryDirectory() as folder, warnings.catch_warnings():
        warnings.simplefilter("ignore", SceneWarning)  # about a scene that the caller has at hand already
        files = [Path(folder) / path.name for path in texts]
        for file, (path, text) in zip(files, texts.items(), strict=True):
            try:
                file.write_bytes(text.encode())
            except (OSError, ValueError) as error:
                raise SceneError(unwritable(error), file=path) from None
        try:
            return load(*files, ignored=[], keyword_rule=True)
        except SceneError as error:
            kinds = ", ".join(path.suffix for path in texts)
            raise SceneError(f"{kinds} cannot hold it: {error.message}", key=error.key) from None


def _settle_on_lines(plain: Scene) -> list[str]:
    """Give points on lines their positions, in a scene without free parameters; the keys of these points."""
    keys = []
    for name, muscle in plain.character.muscles.items():
        for index, point in enumerate(muscle.path):
            if point.position is None:
                point.position, point.start, point.end, point.at = point.place(), None, None, None
                keys.append(f"character.muscles.{name}.path.{index}")
    return keys


def _differences(written: Scene, read: Scene) -> list[str]:
    """Keys whose values differ between what was written and what was read, or that only one of them has."""
    before, after = dict(leaves(_without_usual_drives(written))), dict(leaves(_without_usual_drives(read)))
    keys = [
        key for key in dict.fromkeys([*before, *after]) if not _same(before.get(key, ABSENT), after.get(key, ABSENT))
    ]
    # A joint without a state starts like one in the state written for it, and a root without a heading keeps its own.
    initial = written.initial_state
    implied = {
        f"initial_state.joints.{name}.{field}" for name in written.character.joints if name not in initial.joints
        for field in JointState.__struct_fields__
    }  # fmt: skip
    if initial.heading is None:
        implied.add("initial_state.heading")
    return [key for key in keys if key not in implied and key.rpartition(".")[0] not in implied]


def _without_usual_drives(scene: Scene) -> Scene:
    """The scene without actuations that say what goes without saying."""
    character = scene.character
    said = {joint: own for joint, own in scene.actuation.items() if own != Actuation(usual_drive(joint, character))}
    return msgspec.structs.replace(scene, actuation=said)


def _same(first: object, second: object) -> bool:
    """Whether two plain values are equal, numbers up to rounding."""
    if isinstance(first, int | float) and isinstance(second, int | float):
        return math.isclose(first, second, rel_tol=1e-12, abs_tol=1e-15)
    return first == second
