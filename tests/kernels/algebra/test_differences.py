"""Which product of a difference a GPU fuses, read from what Warp compiles for one (sm_90); that needs none."""

import re
from pathlib import Path

import pytest
import warp as wp

from warpmuscle.kernels.algebra.spatial import rotation_matrix
from warpmuscle.kernels.functions import build_options

PLAIN = {"enable_backward": False, "fast_math": True}
INSTRUCTION = re.compile(r"\s*(mul|add|sub)(?:\.ftz)?\.f(?:32|64)\s+(%f?d?\d+), (\S+), (\S+);")


def work(x: wp.array[float], v: wp.array[wp.vec3], q: wp.array[wp.quat], d: wp.array[wp.float64]):
    i = wp.tid()
    x[i + 1] = x[i] * x[i + 2] - x[i + 3] * x[i + 4]
    d[i + 1] = d[i] * d[i + 2] - d[i + 3] * d[i + 4]
    v[i + 1] = v[i] * x[i + 5] - v[i + 2] * x[i + 6]
    v[i + 3] = wp.cross(v[i + 4], v[i + 5])
    v[i + 6] = wp.skew(v[i + 7]) * v[i + 8] + wp.dot(-v[i + 9], v[i + 10]) * v[i + 11]
    q[i + 1] = q[i] * wp.quat_inverse(q[i + 2])
    v[i + 12] = wp.quat_rotate(q[i + 3], v[i + 13])
    v[i + 14] = wp.quat_rotate_inv(q[i + 4], v[i + 15])
    v[i + 16] = rotation_matrix(q[i + 5]) * v[i + 17]
    x[i + 7] = 2.0 * x[i + 8] - x[i + 9] * x[i + 9]


open_differences = wp.kernel(work, module="unique", module_options=PLAIN)
decided_differences = wp.kernel(work, module="unique", module_options={**PLAIN, **build_options()})


def undecided(kernel: wp.Kernel, folder: Path) -> int:
    """How many differences of two products the last compiler may fuse with either of them."""
    try:
        wp.compile_aot_module(kernel.module, arch=90, module_dir=folder, use_ptx=True)
    except Exception as error:
        pytest.skip(f"this Warp compiles for no GPU: {error}")
    (ptx,) = folder.glob("*.ptx")
    products, count = set(), 0
    for line in ptx.read_text(errors="replace").splitlines():
        if found := INSTRUCTION.match(line):
            operation, result, left, right = found.groups()
            if operation == "mul":
                products.add(result)
            elif left != right and left in products and right in products:
                count += 1
    return count


def test_a_gpu_has_no_choice_which_product_of_a_difference_it_fuses(tmp_path: Path):
    assert undecided(decided_differences, tmp_path) == 0


def test_without_that_it_has(tmp_path: Path):
    assert undecided(open_differences, tmp_path) > 10
