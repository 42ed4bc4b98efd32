"""The gait of a scene's own controller as a policy's file keeps it, so that who plays the policy need not make it."""

from __future__ import annotations

import hashlib
from typing import Any

import msgspec
import numpy as np

from warpmuscle.core.errors import RolloutError
from warpmuscle.core.plain_text import number_of
from warpmuscle.learning.imitation.gait import BINS, Gait, quaternions
from warpmuscle.results.learned import KeptGait
from warpmuscle.scene import Scene
from warpmuscle.scene.learning import Imitation
from warpmuscle.scene.objective import Objective
from warpmuscle.scene.parameters import at_start
from warpmuscle.scene.trusted_code import named_code
from warpmuscle.simulation.rollout import Rollout

UNIT = 1e-6  # by which the length of a quaternion may be off


def kept(gait: Gait, scene: Scene, imitation: Imitation) -> KeptGait | None:
    """A gait as its controller makes it, before a task changes anything of it; None of a scene that cannot be told by.

    Args:
        scene: whose controller made it.
    """
    digest = digest_of(scene, imitation)
    if digest is None:
        return None
    return KeptGait(digest, gait.coordinate, gait.up, gait.landings, gait.right, gait.cycle_time)


def gait_kept(found: KeptGait | None, rollout: Rollout, imitation: Imitation | None) -> Gait | None:
    """The gait that a policy's file keeps, as `kept` was given it; None if there is none, or it is of another scene.

    Raises:
        RolloutError: it says that it is of this scene, which has other coordinates.
    """
    if found is None or imitation is None or found.scene != digest_of(rollout.scene, imitation):
        return None
    shape = (BINS, len(rollout.coordinate_names))
    if found.coordinate.shape != shape:
        frames, columns = found.coordinate.shape
        raise RolloutError(
            f"damaged policy: its gait has {number_of(columns, 'coordinate')} in {number_of(frames, 'frame')}, "
            f"and should have {shape[1]} in {shape[0]}; leave out the group gait of its file to make it anew"
        )
    for span in quaternions(rollout.numeric, rollout.names):
        if np.abs(np.linalg.norm(found.coordinate[:, span], axis=1) - 1.0).max() > UNIT:
            name = rollout.coordinate_names[span.start]
            raise RolloutError(f"damaged policy: gait/coordinate holds quaternions at {name} whose length is not 1")
    return Gait(found.coordinate, found.up, found.cycle_time, found.landings, found.right)


def digest_of(scene: Scene, imitation: Imitation) -> str | None:
    """A digest of all that the gait of a scene's controller depends on; None where files or code outside count too.

    Neither what is valued or learned, nor how long a run lasts, nor what the scene's commands are now changes the
    gait, nor do conditions of failure: what is kept was recorded to its end. Names in the OpenSim model that a body
    came from are for files and pictures.
    """
    level = {name: msgspec.structs.replace(one, value=None, over=[]) for name, one in scene.commands.items()}
    numbers = at_start(msgspec.structs.replace(scene, commands=level))
    bare = msgspec.structs.replace(
        numbers, name="", description="", learning=None, recorded=[], duration=1.0, stages=[], tracking=None,
        norms=None, objective=Objective(), failure=type(scene.failure)(), robustness=type(scene.robustness)(),
        opensim=None,
    )  # fmt: skip
    if named_code(bare):
        return None
    plain = msgspec.to_builtins(bare, enc_hook=_plain)
    if _names_files(plain):
        return None
    return hashlib.sha256(repr((plain, imitation.settle)).encode()).hexdigest()


def _plain(value: Any) -> Any:
    """A number or an array of NumPy in plain values."""
    return value.tolist() if hasattr(value, "tolist") else repr(value)


def _names_files(part: Any) -> bool:
    """Whether a part in plain values names a file that is read as it runs."""
    if isinstance(part, dict):
        named = (value for key, value in part.items() if str(key).split("_")[-1] == "file")
        return any(named) or any(map(_names_files, part.values()))
    return isinstance(part, (list, tuple)) and any(map(_names_files, part))
