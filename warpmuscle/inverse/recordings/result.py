"""The part of a result file that other commands read: the scene, and all trials as its motions."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from warpmuscle.formats import toml
from warpmuscle.inverse.body_model import BodyModel
from warpmuscle.inverse.recordings.motion import scene_with_feet
from warpmuscle.results.recording import Recording
from warpmuscle.results.records import ParameterTable, Result


def motions_result(body: BodyModel, names: Sequence[str], motions: Sequence[Recording], command: str = "") -> Result:
    """A result without a search, whose motions have the names of the trials."""
    none = np.zeros(0)
    return Result(
        toml.dumps(scene_with_feet(body.scene)), str(body.device), command, 0,
        ParameterTable((), (), none, none, none, none, ()), replays=tuple(motions),
        replay_names=tuple(names) if len(names) > 1 else (),
    )  # fmt: skip
