"""The published procedure on the throwing arm."""

import numpy as np

from warpmuscle.results.result import read
from warpmuscle.throw.job import Job
from warpmuscle.throw.published import as_published
from warpmuscle.throw.report import write


def hinge_angle(quaternion: np.ndarray) -> np.ndarray:
    """Angles (F, 3) of quaternions xyzw, rad: shoulder and elbow turn about -x, the wrist about x."""
    return np.array([-2.0, -2.0, 2.0]) * np.arctan2(quaternion[..., 0], quaternion[..., 3])


def test_the_published_procedure_meets_the_angles_before_its_filter(job: Job, tmp_path):
    result = as_published(job.arm, job.motions, job.follower.synergies, job.start, evaluations=3)
    names = [stage.name for stage in result.stages]
    assert names[-2:] == ["signals step by step", "signals filtered"]
    assert np.isfinite(result.stages[-1].r2).all()
    assert result.stages[-2].r2.mean() > result.stages[0].r2.mean()
    write(tmp_path / "published.h5", job.follower, None, result, [0], {})
    kept = read(tmp_path / "published.h5")
    assert kept.fit.stages[-1] == "signals filtered"
    np.testing.assert_allclose(hinge_angle(kept.replays[0].joint_orientation), result.replay.angle[0, :-1], atol=1e-4)
