"""The throwing arm fitted to the mean throw of its own scene, and to recorded throws."""

from pathlib import Path

import numpy as np
import pytest

from warpmuscle.formats import load
from warpmuscle.throw.job import Job, JobOptions


def test_the_fit_meets_all_bars_from_literature_parameters(job: Job):
    agreement = job.fitted.agreement
    assert agreement.good().all(), agreement
    assert job.fitted.stages[0].agreement.r2.min() < 0.0


@pytest.mark.long
def test_a_throw_whose_signals_miss_narrowly_is_fitted_nearer_to_the_extracted_ones(
    reference_data: Path, tmp_path: Path
):
    """T0012 with the trunk and the place of the shoulder: five times the price would take the hand too far away."""
    with np.load(reference_data / "spl_freethrow" / "throws22.npz") as data:
        row, point = (list(data[name]).index(one) for name, one in (("trial", "T0012"), ("keypoints", "R_SHOULDER")))
        names = ("shoulder_flexion", "elbow_flexion", "wrist_flexion", "shoulder_flexion_gravity")
        columns = {"time": data["time"]} | {f"{name}_deg": data[name][row] for name in names}
        place = data["keypoint_pos_m"][row, :, point]
    columns |= {"shoulder_forward_m": place[:, 0], "shoulder_up_m": place[:, 2]}
    path = tmp_path / "throw.csv"
    np.savetxt(path, np.column_stack(list(columns.values())), "%.6g", ",", header=",".join(columns), comments="")
    agreement = Job(load("throw"), [path], JobOptions(threads=1)).fit().agreement
    assert agreement.good().all(), agreement


@pytest.mark.long
def test_recorded_throws_meet_all_bars(reference_data: Path):
    """All 22 free throws, every other one held out of the fit of the parameters."""
    job = Job(load("throw"), sorted((reference_data / "spl_freethrow").glob("throw_T*.csv")), JobOptions(seed=1))
    assert len(job.motions) == 22
    assert job.fit().agreement.good().all(), job.fitted.agreement


def test_parameters_stay_within_the_intervals_of_the_scene(job: Job):
    for parameter, value in zip(job.arm.parameters, job.arm.values(job.fitted.unknowns), strict=True):
        assert parameter.min * (1 - 1e-9) <= value <= parameter.max * (1 + 1e-9) or parameter.min < 0.0
    values = np.array([p.value for p in job.arm.parameters])
    np.testing.assert_allclose(job.arm.values(job.arm.unknowns(values)), values, rtol=1e-12)
