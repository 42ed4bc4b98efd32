"""What tests change in Warp's translation changes nothing in what is compiled."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import warp as wp
from warp._src import codegen, context

import kernel_tests

kernel_tests.start()


ADDED = wp.constant(1.0)


@wp.struct
class Pair:
    a: float
    b: float


@wp.func
def leaf(x: float):
    return x + ADDED


@wp.func
def twice(x: float):
    return leaf(x) * 2.0


@wp.func
def of_pair(pair: Pair, x: float):
    return twice(pair.a) + leaf(pair.b) + x


@wp.func
def mixed(x: wp.array(dtype=float), n: wp.array(dtype=int), i: int):  # type: ignore[valid-type]
    v = wp.vec3(x[i], x[i] * x[i], x[i] - 2.5)
    k = n[i] * 3 - n[i] + 7
    return wp.dot(v, v + v) * x[i] + float(k) * (x[i] - 0.25) - x[i]


def kernel_of(number: float) -> Any:
    """A kernel in a module of its own that calls the functions of this file."""

    @wp.kernel(module="unique", enable_backward=False)
    def kernel(pairs: wp.array(dtype=Pair), x: wp.array(dtype=float)):  # type: ignore[valid-type]
        i = wp.tid()
        x[i] = twice(x[i]) + of_pair(pairs[i], wp.static(number))

    return kernel


def text_of(kernel: Any) -> list[str]:
    """Lines that are compiled for a kernel, without comments, which tell a line only where another one was before."""
    module = kernel.module
    module.get_module_hash(1)
    text = module._run_codegen(module.resolve_options(wp.config) | {"block_dim": 1}, True)[0]
    return [line for line in text.splitlines() if not line.lstrip().startswith("//")]


@pytest.fixture
def translated(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Names of functions that Warp translates meanwhile."""
    names, build = [], codegen.Adjoint.build

    def named(self: Any, *arguments: Any, **options: Any) -> None:
        names.append(self.fun_name)
        build(self, *arguments, **options)

    monkeypatch.setattr(codegen.Adjoint, "build", named)
    return names


def test_a_function_is_translated_once_for_two_modules_and_their_texts_are_those_of_modules_alone(translated):
    text_of(kernel_of(1.0))
    second = kernel_of(2.0)
    translated.clear()
    text = text_of(second)
    assert translated == ["kernel"]
    for function in leaf, twice, of_pair:
        function.adj.translation = None
    assert text_of(second) == text
    assert {"leaf", "twice", "of_pair"} <= set(translated)
    for function in "leaf", "twice", "of_pair":
        assert sum(f" {function}_0(" in line and line.startswith("static") for line in text) == 1
    assert sum(line.startswith("struct Pair_") for line in text) == 1


def test_a_function_whose_constant_changes_is_translated_anew(translated, monkeypatch):
    text_of(kernel_of(4.0))
    translated.clear()
    monkeypatch.setitem(globals(), "ADDED", wp.constant(5.5))
    assert any("5.5" in line for line in text_of(kernel_of(4.0)))
    assert "leaf" in translated


def test_derivatives_have_functions_of_their_own():
    @wp.kernel(module="unique", enable_backward=True)
    def kernel(x: wp.array(dtype=float), y: wp.array(dtype=float)):  # type: ignore[valid-type]
        y[0] = twice(x[0])

    text_of(kernel_of(3.0))
    x, y = (wp.array([value], dtype=float, requires_grad=True, device="cpu") for value in (3.0, 0.0))
    with wp.Tape() as tape:
        wp.launch(kernel, 1, [x], [y], device="cpu")
    tape.backward(grads={y: wp.ones(1, dtype=float, device="cpu")})
    assert y.numpy()[0] == 8.0
    assert x.grad.numpy()[0] == 2.0


def test_operators_take_the_place_of_calls_that_load_copy_and_reckon_with_scalars_of_one_type():
    declared = (
        "    const wp::float32 var_0 = 2.0;\n    wp::float32* var_1;\n    wp::int32 var_2;\n    wp::float32 var_3;\n"
        "    wp::vec_t<3, wp::float32> var_4;\n"
    )
    called = (
        "    var_5 = wp::load(var_1);\n    var_6 = wp::copy(var_5);\n    var_7 = wp::mul(var_0, var_3);\n"
        "    var_8 = wp::sub(var_2, var_2);\n    var_9 = wp::add(var_4, var_4);\n    var_10 = wp::mul(var_4, var_0);\n"
        "    var_11 = wp::add(var_2, var_0);\n    var_12 = wp::load(var_4, var_2);\n"
    )
    plain = (
        "    var_5 = *var_1;\n    var_6 = var_5;\n    var_7 = var_0 * var_3;\n"
        "    var_8 = var_2 - var_2;\n    var_9 = wp::add(var_4, var_4);\n    var_10 = wp::mul(var_4, var_0);\n"
        "    var_11 = wp::add(var_2, var_0);\n    var_12 = wp::load(var_4, var_2);\n"
    )
    assert kernel_tests.with_operators(declared + called) == declared + plain
    tiles = declared + called + "    wp::tile_register_t<wp::float32> var_13;\n"
    assert kernel_tests.with_operators(tiles) == tiles


def test_functions_whose_place_operators_take_do_no_more_than_these():
    native = Path(wp.__path__[0], "native")
    scalars, arrays = (" ".join((native / name).read_text().split()) for name in ("builtin.h", "array.h"))
    for name, operator in kernel_tests.OPERATORS.items():
        of_both = f"inline CUDA_CALLABLE T {name}(T a, T b) {{ return a{operator}b; }}"
        assert scalars.count(of_both) == 2, name  # of integers, and of floats
    assert "template <typename T> CUDA_CALLABLE inline T copy(const T& src) { return src; }" in scalars
    assert "T load(T* address) { T value = *address; FP_VERIFY_FWD(value) return value; }" in arrays


def test_what_operators_make_is_what_calls_made_to_the_bit():
    """Of a kernel that is compiled without optimisation, with and without them."""

    def kernel_to(count: int) -> Any:
        @wp.kernel(module="unique", module_options={"optimization_level": 0}, enable_backward=False)
        def kernel(x: wp.array(dtype=float), n: wp.array(dtype=int), y: wp.array(dtype=float)):  # type: ignore[valid-type]
            i = wp.tid()
            if i < wp.static(count):  # another number, so that what the other one is compiled to is not taken
                y[i] = mixed(x, n, i)

        return kernel

    random = np.random.default_rng(5)
    x = wp.array(random.normal(size=200).astype(np.float32), device="cpu")
    n = wp.array(random.integers(-1000, 1000, size=200), dtype=int, device="cpu")
    found, texts = [], []
    for count, replaced in ((200, True), (201, False)):
        with pytest.MonkeyPatch.context() as patch:
            if not replaced:
                patch.setattr(kernel_tests, "with_operators", lambda text: text)
            mixed.adj.translation = None
            kernel, y = kernel_to(count), wp.zeros(200, dtype=float, device="cpu")
            texts.append(text_of(kernel))
            wp.launch(kernel, 200, [x, n], [y], device="cpu")
            found.append(y.numpy())
    assert sum("wp::mul(" in line for line in texts[0]) < sum("wp::mul(" in line for line in texts[1])
    np.testing.assert_array_equal(found[0].view(np.int32), found[1].view(np.int32))


def test_this_is_the_warp_whose_translation_is_known():
    """With another Warp, tests do without, and this tells that they do."""
    assert context.ModuleBuilder.build_function.__name__ == "once"
