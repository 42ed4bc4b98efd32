"""How far tendons are stretched by known forces, for a second pass with elastic tendons."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import warp as wp

from warpmuscle.core.array_types import Floats
from warpmuscle.core.arrays import to_device
from warpmuscle.inverse.body_model import BodyModel
from warpmuscle.inverse.smoothing import spline
from warpmuscle.kernels.inverse.muscle_moments import tendon_lengths_of
from warpmuscle.model.muscles import muscle_kind, muscles_struct


def tendon_motion(body: BodyModel, force: Floats, times: Sequence[Floats]) -> Floats:
    """Lengths, m, and lengthening speeds, m/s, of tendons (2, n, M) that bear forces (n, M), N, over trials.

    Speeds are rates of splines through the lengths of each trial; of a trial of one frame they are zero.

    Args:
        times: (F,) s of each trial.
    """
    kind = muscle_kind(body.scene.muscle_model, [body.muscle(name) for name in body.muscles])
    muscles = muscles_struct(body.scene, body.muscles, body.device)
    length = wp.zeros(force.shape, dtype=float, device=body.device)
    wp.launch(
        tendon_lengths_of(kind.curves, kind.special_curves), force.shape,
        [muscles, to_device(force, float, body.device)], [length], device=body.device,
    )  # fmt: skip
    found = length.numpy().astype(np.float64)
    ends = np.cumsum([len(one) for one in times])[:-1]
    speeds = [spline(at, own, at, degree=3, orders=2)[1] for at, own in zip(times, np.split(found, ends), strict=True)]
    return np.stack([found, np.concatenate(speeds)])
