"""Functions that Warp parses when a kernel first needs them."""

import ast
import subprocess
import sys
import threading
from pathlib import Path

import numpy as np
import pytest
import warp as wp
from probes import evaluate

import warpmuscle.kernels
from warpmuscle.kernels.functions import COUNTERS, LateFunction, build_options, func, gradient_of, known_gradient
from warpmuscle.kernels.step import module_options

KERNELS = Path(warpmuscle.kernels.__file__).parent
MODULES = sorted(path for path in KERNELS.rglob("*.py") if path.name != "functions.py")


@func
def cubed(x: float) -> float:
    return x * x * x


@func
def root(x: float) -> float:
    """The square root by halving, through which a reverse sweep finds no derivative."""
    low = wp.float32(0.0)
    high = wp.float32(4.0)
    for _ in range(24):
        middle = 0.5 * (low + high)
        if middle * middle < x:
            low = middle
        else:
            high = middle
    return low


@gradient_of(root)
def root_gradient(x: float, adj_ret: float):
    wp.adjoint[x] += adj_ret / (2.0 * root(x))


@wp.kernel(enable_backward=True)
def roots(x: wp.array[float], y: wp.array[float]):
    y[0] = root(x[0])


def parsed(function: LateFunction) -> bool:
    return "adj" in vars(function)


def added(number: float, to: LateFunction) -> LateFunction:
    """One of several functions that all have the same name."""

    @func
    def sum_of(x: float) -> float:
        return to(x) + wp.static(number)

    return sum_of


def test_a_function_is_parsed_with_what_it_calls_when_its_value_is_first_asked_for():
    # Within the test, since pytest asks all that its module holds for marks.
    @func(inline=True)
    def doubled(x: float) -> float:
        return 2.0 * x

    @func
    def doubled_cube(x: float) -> float:
        return doubled(x * x * x)

    assert isinstance(doubled_cube, wp.Function)
    assert (doubled_cube.__name__, doubled_cube.func(2.0)) == ("doubled_cube", 16.0)
    assert not parsed(doubled_cube)
    np.testing.assert_allclose(evaluate(doubled_cube, np.array([2.0, -3.0])), [16.0, -54.0])
    assert parsed(doubled)
    assert doubled.inline_hint == "forceinline"


def test_functions_of_one_name_that_call_each_other_stay_apart():
    chain = added(1.0, added(10.0, added(100.0, cubed)))
    np.testing.assert_allclose(evaluate(chain, np.array([2.0])), [119.0])


def test_a_function_has_the_gradient_that_it_was_given_before_it_was_parsed():
    x, y = (wp.array([number], dtype=float, requires_grad=True, device="cpu") for number in (2.25, 0.0))
    with wp.Tape() as tape:
        wp.launch(roots, 1, [x, y], device="cpu")
    tape.backward(grads={y: wp.ones_like(y)})
    np.testing.assert_allclose(x.grad.numpy(), [1.0 / 3.0], rtol=1e-5)


def test_the_gradient_that_a_function_was_given_is_known_before_it_is_parsed_and_after():
    @func
    def fourth(x: float) -> float:
        return cubed(x) * x

    @gradient_of(fourth)
    def slope(x: float, adj_ret: float):
        wp.adjoint[x] += 4.0 * adj_ret * cubed(x)

    assert known_gradient(fourth) is slope
    assert not parsed(fourth)
    assert known_gradient(added(1.0, fourth)) is None
    assert fourth(2.0) == 16.0
    assert parsed(fourth)
    assert known_gradient(fourth) is slope
    assert known_gradient(cubed) is None


def test_what_no_function_has_is_not_an_attribute():
    with pytest.raises(AttributeError, match="cubed has no attribute 'colour'"):
        cubed.colour  # noqa: B018


def test_several_threads_parse_a_function_once():
    own = added(5.0, cubed)
    found: list[object] = []
    threads = [threading.Thread(target=lambda: found.append(own.adj)) for _ in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(found) == len(threads)
    assert len(set(map(id, found))) == 1


@pytest.mark.parametrize("path", MODULES, ids=lambda path: str(path.relative_to(KERNELS)))
def test_a_module_parses_its_functions_late_unless_it_has_kernels(path: Path):
    """Warp hashes the kernels of a module anew for each function of the module that it learns of."""
    decorated = [node for node in ast.parse(path.read_text()).body if isinstance(node, ast.FunctionDef)]
    first = [ast.unparse(node.decorator_list[0]).partition("(")[0] for node in decorated if node.decorator_list]
    assert not {"wp.kernel", "func"} <= set(first)
    assert "wp.kernel" in first or "wp.func" not in first
    if "func" in first:
        names = [node.name for node in decorated]
        assert len(names) == len(set(names))


COUNT = """
import gc
import warpmuscle as wm
from warpmuscle.kernels.functions import LateFunction
rollout = wm.Rollout("fwalk", device="cpu")
functions = [one for one in gc.get_objects() if isinstance(one, LateFunction)]
print(len(functions), sum("adj" in vars(one) for one in functions))
"""


def test_a_rollout_that_has_not_stepped_has_parsed_no_function():
    run = subprocess.run([sys.executable, "-c", COUNT], capture_output=True, text=True, check=True)
    count, parsed_ones = map(int, run.stdout.split())
    assert count > 300
    assert parsed_ones == 0


def test_with_a_warp_that_nobody_has_tested_functions_are_parsed_as_warp_does_it():
    code = """
import warp as wp
known, wp.config.version = wp.config.version, "99.0.0"
from warpmuscle.kernels.functions import LATE
wp.config.version = known
assert not LATE
from warpmuscle.kernels.algebra.angles import sine_cosine
assert type(sine_cosine) is wp.Function, type(sine_cosine)
import warpmuscle as wm
assert wm.Rollout("fwalk", 1, "cpu").running
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


LOOPS = [
    (0, 0, 1), (0, 5, 1), (3, 5, 1), (5, 3, 1), (-4, 3, 2), (1, 8, 3), (1, 7, 3), (4, -1, -1), (7, 0, -3), (0, 7, -3),
    (2, 2, -1), (0, 5, 0), (5, 0, 0),
]  # fmt: skip


@wp.kernel(
    module="unique",
    enable_backward=False,
    module_options={"enable_backward": False, "max_unroll": 1, "optimization_level": 0, **build_options()},
)
def visit(loops: wp.array2d[int], visited: wp.array2d[int], whole: wp.array2d[int], counts: wp.array[int]):
    row = wp.tid()
    place = wp.int32(0)
    for k in range(loops[row, 0], loops[row, 1], loops[row, 2]):
        visited[row, place] = k
        place += 1
    for k in range(loops[row, 0], loops[row, 1]):
        if k == 1:
            continue
        for other in range(loops[row, 1]):
            if other > k:
                break
            whole[row, k] = whole[row, k] + 1
    counts[row] = place


def test_loops_on_a_cpu_visit_what_those_of_python_do():
    loops, shape = np.array(LOOPS, np.int32), (len(LOOPS), 10)
    visited, whole = (wp.zeros(shape, dtype=int, device="cpu") for _ in range(2))
    counts = wp.zeros(len(LOOPS), dtype=int, device="cpu")
    wp.launch(visit, len(LOOPS), [wp.array(loops, device="cpu"), visited, whole, counts], device="cpu")
    for row, (start, end, step) in enumerate(LOOPS):
        expected = list(range(start, end, step)) if step else []
        assert visited.numpy()[row, : counts.numpy()[row]].tolist() == expected
        times = np.zeros(10, int)
        for k in range(start, end):
            if k != 1:
                times[k] += sum(other <= k for other in range(end))
        assert whole.numpy()[row].tolist() == times.tolist()


def test_steps_count_their_loops_in_registers():
    assert module_options(1)["extra_build_options"].extra_cpu_preamble == COUNTERS
