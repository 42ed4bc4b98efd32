"""A GPU computes the same bits wherever the numbers of a working set lie."""

import os
from pathlib import Path

import numpy as np
import pytest
import warp as wp
from agreement import moved
from kinds import scene_of

from warpmuscle.kernels.memory.scratch import ALL, ENTRIES, LEAN, LEANER, LEANEST, NEAR
from warpmuscle.simulation import launcher

GPU = os.environ.get("WARPMUSCLE_GPU_TESTS_ON", "cuda:0")
COUNT = 48


@pytest.mark.gpu
@pytest.mark.parametrize("kind", ["followed from afar", "looped"])
def test_motion_is_the_same_with_any_part_of_a_working_set_in_main_memory(kind, tmp_path: Path, monkeypatch):
    if GPU != "cpu" and not wp.get_cuda_devices():
        pytest.skip("there is no GPU here")
    scene = scene_of(kind, tmp_path)

    def with_so_much(main: int) -> np.ndarray:
        def only(config):
            yield config.compiling(skeleton=config.kind.skeleton._replace(main=main)), False

        monkeypatch.setattr(launcher, "ways_of_memory", only)
        return moved(scene, GPU, COUNT, trust=True)

    near = with_so_much(NEAR)
    assert np.isfinite(near).all()
    for main in (ENTRIES, LEAN, LEANER, LEANEST, ALL):
        np.testing.assert_array_equal(with_so_much(main), near)
