"""What tests change in Warp's translation changes nothing in what is compiled."""

from typing import Any

import pytest
import warp as wp
from warp._src import codegen, context

import kernel_tests
from kernel_text import lines_of

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


def kernel_of(number: float) -> Any:
    """A kernel in a module of its own that calls the functions of this file."""

    @wp.kernel(module="unique", enable_backward=False)
    def kernel(pairs: wp.array(dtype=Pair), x: wp.array(dtype=float)):  # type: ignore[valid-type]
        i = wp.tid()
        x[i] = twice(x[i]) + of_pair(pairs[i], wp.static(number))

    return kernel


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
    lines_of(kernel_of(1.0))
    second = kernel_of(2.0)
    translated.clear()
    text = lines_of(second)
    assert translated == ["kernel"]
    for function in leaf, twice, of_pair:
        function.adj.translation = None
    assert lines_of(second) == text
    assert {"leaf", "twice", "of_pair"} <= set(translated)
    for function in "leaf", "twice", "of_pair":
        assert sum(f" {function}_0(" in line and line.startswith("static") for line in text) == 1
    assert sum(line.startswith("struct Pair_") for line in text) == 1


def test_a_function_whose_constant_changes_is_translated_anew(translated, monkeypatch):
    lines_of(kernel_of(4.0))
    translated.clear()
    monkeypatch.setitem(globals(), "ADDED", wp.constant(5.5))
    assert any("5.5" in line for line in lines_of(kernel_of(4.0)))
    assert "leaf" in translated


def test_derivatives_have_functions_of_their_own():
    @wp.kernel(module="unique", enable_backward=True)
    def kernel(x: wp.array(dtype=float), y: wp.array(dtype=float)):  # type: ignore[valid-type]
        y[0] = twice(x[0])

    lines_of(kernel_of(3.0))
    x, y = (wp.array([value], dtype=float, requires_grad=True, device="cpu") for value in (3.0, 0.0))
    with wp.Tape() as tape:
        wp.launch(kernel, 1, [x], [y], device="cpu")
    tape.backward(grads={y: wp.ones(1, dtype=float, device="cpu")})
    assert y.numpy()[0] == 8.0
    assert x.grad.numpy()[0] == 2.0


def test_this_is_the_warp_whose_translation_is_known():
    """With another Warp, tests do without, and this tells that they do."""
    assert context.ModuleBuilder.build_function.__name__ == "once"
