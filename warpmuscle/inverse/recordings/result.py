"""The part of a result file that other commands read: the scene, and all trials as its motions."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from warpmuscle.formats import toml
from warpmuscle.inverse.body_model import BodyModel
from warpmuscle.inverse.recordings.motion import scene_with_feet
from warpmuscle.results.recording import Recording
from warpmuscle.results.records import ParameterTable, Result
from warpmuscle.scene import Scene


def motions_result(body: BodyModel, scene: Scene, motions: Mapping[str, Recording], command: str = "") -> Result:
    """A result of a scene without a search, whose motions have names."""
    none = np.zeros(0)
    return Result(
        toml.dumps(scene_with_feet(scene)), str(body.device), command, 0,
        ParameterTable((), (), none, none, none, none, ()), replays=tuple(motions.values()),
        replay_names=tuple(motions) if len(motions) > 1 else (),
    )  # fmt: skip
