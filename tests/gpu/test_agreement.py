"""A GPU computes what the CPU does, and the same bits however the work is shared out, for every kind of kernel.

    python -m pytest -m gpu --dist load tests/gpu        on a machine with a GPU; the rest of the suite needs none

A CPU tries a few kinds besides, so that the tests themselves are known to work; with `WARPMUSCLE_GPU_TESTS_ON=cpu` all.
"""

import os
from pathlib import Path

import numpy as np
import pytest
import warp as wp
from agreement import LAST_BITS, NOISE, apart, candidates, moved, same_bits
from kinds import COMPARED_AFTER, DURATION, KINDS, SMALL, scene_of

GPU = os.environ.get("WARPMUSCLE_GPU_TESTS_ON", "cuda:0")
COUNT = 48
ROUNDING = 1.0e-4  # rad or m that rounding may come to in so short a time, besides what a changed start makes of it


def cases() -> list[object]:
    """All kinds on the GPU, and small ones on the CPU."""
    on_cpu = [
        pytest.param(("cpu", kind), id=f"cpu-{kind}", marks=pytest.mark.long if number else ())
        for number, kind in enumerate(SMALL)
    ]
    return [pytest.param((GPU, kind), id=f"gpu-{kind}", marks=pytest.mark.gpu) for kind in KINDS] + on_cpu


@pytest.fixture(params=cases())
def case(request: pytest.FixtureRequest, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """A device, and a kind of scene to run there, with a scene of it."""
    device, kind = request.param
    if device != "cpu" and not wp.get_cuda_devices():
        pytest.skip("there is no GPU here")
    monkeypatch.syspath_prepend(str(tmp_path))
    return device, kind, scene_of(kind, tmp_path)


def test_motion_is_that_of_the_cpu_but_for_rounding(case):
    device, kind, scene = case
    until = COMPARED_AFTER.get(kind)
    cpu, changed = (moved(scene, "cpu", COUNT, noise, until, trust=True) for noise in (NOISE, NOISE * LAST_BITS))
    there = moved(scene, device, COUNT, until=until, trust=True)
    assert np.isfinite(there).all()
    assert np.median(apart(there, cpu)) <= 30.0 * np.median(apart(changed, cpu)) + ROUNDING


def test_bits_do_not_depend_on_lanes_batches_places_chunks_or_recording(case):
    device, _, scene = case
    values = candidates(scene, COUNT, 1.0, trust=True)
    same = same_bits(scene, device, values, DURATION / 3.0, trust=True)
    assert len(same) >= 5
    assert all(same.values()), same
