"""What tests leave out of the text that is compiled without optimisation changes nothing in what it comes to."""

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import warp as wp

import kernel_tests
import kernel_text
from kernel_text import lines_of
from warpmuscle.kernels.memory.compiler_hints import known_rows_of

kernel_tests.start()


@wp.struct
class Rows:
    value: wp.array(dtype=float)  # type: ignore[valid-type]
    count: int


know_rows = known_rows_of(Rows)


@wp.func
def mixed(x: wp.array(dtype=float), n: wp.array(dtype=int), i: int):  # type: ignore[valid-type]
    v = wp.vec3(x[i], x[i] * x[i], x[i] - 2.5)
    k = n[i] * 3 - n[i] + 7
    return wp.dot(v, v + v) * x[i] + float(k) * (x[i] - 0.25) - x[i]


@wp.func
def exchanged(rows: Rows, i: int):
    before = rows.value[i]
    rows.value[i] = before + float(rows.count) * rows.value[i]
    other = rows
    other.count = other.count * 2 + i
    for k in range(other.count):
        if k == rows.count:
            before += rows.value[i]
        rows.value[i] = rows.value[i] * 0.5
    return before - rows.value[i] * float(other.count) + float(rows.count)


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
    assert kernel_text.with_operators(declared + called) == declared + plain
    tiles = declared + called + "    wp::tile_register_t<wp::float32> var_13;\n"
    assert kernel_text.shortened(tiles) == tiles


def test_functions_whose_place_operators_take_do_no_more_than_these():
    native = Path(wp.__path__[0], "native")
    scalars, arrays = (" ".join((native / name).read_text().split()) for name in ("builtin.h", "array.h"))
    for name, operator in kernel_text.OPERATORS.items():
        of_both = f"inline CUDA_CALLABLE T {name}(T a, T b) {{ return a{operator}b; }}"
        assert scalars.count(of_both) == 2, name  # of integers, and of floats
    assert "template <typename T> CUDA_CALLABLE inline T copy(const T& src) { return src; }" in scalars
    assert "T load(T* address) { T value = *address; FP_VERIFY_FWD(value) return value; }" in arrays


def body_of(*statements: str) -> str:
    """A function of these statements, with the declarations that Warp writes above them."""
    named = sorted({name for line in statements for name in kernel_text.NAMES.findall(line)})
    declared = "".join(f"    wp::float32 {name};\n" for name in named if name != "var_p")
    return f"static void f(\n    P* var_p)\n{{\n{declared}    // forward\n" + "\n".join(statements) + "\n}\n"


def test_reads_take_the_place_of_variables_that_only_the_next_statement_uses():
    text = body_of(
        "    var_0 = &((*(var_p)).gain);", "    // a comment  <L 7>", "    var_1 = &((*(var_p)).rows);",
        "    var_2 = *var_0;", "    var_3 = *var_1;", "    var_4 = at_0(var_3, var_2, var_2);", "    return var_4;",
    )  # fmt: skip
    left = kernel_text.with_reads_in_place(text)
    assert "var_4 = at_0(((*(var_p)).rows), var_2, var_2);" in left  # what is used twice stays
    assert "    var_2 = *var_0;\n" in left
    assert "var_1" not in left
    assert "var_3" not in left


@pytest.mark.parametrize(
    "statements",
    [
        ("    var_1 = *var_p;", "    wp::store(var_p, var_0);", "    var_2 = var_1 + var_0;"),  # read before it changes
        ("    var_1 = *var_p;", "    f_0(&(var_1));"),  # a copy that somebody else may change
        ("    var_1 = *var_p;", "    wp::assign_inplace(var_1, 0, var_0);"),
        ("    var_1 = *var_p;", "    var_2 = &((var_1).x);", "    wp::store(var_p, var_0);", "    var_3 = *var_2;"),
        ("    var_1 = *var_p;", "    }", "    return var_1;"),
        ("    var_1 = *var_p;", "    end_for_0:;", "    return var_1;"),
    ],
)
def test_what_another_statement_may_come_between_is_read_where_it_was(statements):
    assert kernel_text.with_reads_in_place(body_of(*statements)) == body_of(*statements)


def test_an_address_of_another_block_is_read_through_its_variable():
    text = body_of(
        "    var_0 = &((*(var_p)).gain);",
        "    if (var_1) {",
        "        var_2 = *var_0;",
        "        var_3 = -var_2;",
        "    }",
    )
    assert kernel_text.with_reads_in_place(text) == body_of(
        "    var_0 = &((*(var_p)).gain);", "    if (var_1) {", "        var_3 = -(*var_0);", "    }"
    ).replace("    wp::float32 var_2;\n", "").replace("{\n    wp::float32 var_0;", "{\n    wp::float32 var_0;")


def test_hints_are_left_out_where_nothing_is_optimised():
    def kernel_at(level: int | None) -> Any:
        @wp.kernel(module="unique", module_options={"optimization_level": level}, enable_backward=False)
        def kernel(rows: Rows):
            know_rows(rows)
            rows.value[wp.tid()] = 1.0

        return kernel

    with_them, without = ("\n".join(lines_of(kernel_at(level))) for level in (2, 0))
    assert "__builtin_assume" in with_them
    assert "__builtin_assume" not in without
    named = re.compile(r"know_rows_\d+\(")  # by a number that depends on what other tests have made
    assert len(named.findall(without)) == len(named.findall(with_them)) > 1  # made, and called


def test_what_is_shorter_comes_to_the_same_to_the_bit():
    """Of a kernel that is compiled without optimisation, with and without them."""

    def kernel_to(count: int) -> Any:
        @wp.kernel(module="unique", module_options={"optimization_level": 0}, enable_backward=False)
        def kernel(
            x: wp.array(dtype=float),
            n: wp.array(dtype=int),
            rows: Rows,
            y: wp.array(dtype=float),  # type: ignore[valid-type]
        ):
            i = wp.tid()
            if i < wp.static(count):  # another number, so that what the other one is compiled to is not taken
                y[i] = mixed(x, n, i) + exchanged(rows, i)

        return kernel

    random = np.random.default_rng(5)
    x = wp.array(random.normal(size=200).astype(np.float32), device="cpu")
    n = wp.array(random.integers(-1000, 1000, size=200), dtype=int, device="cpu")
    found, texts = [], []
    for count, replaced in ((200, True), (201, False)):
        with pytest.MonkeyPatch.context() as patch:
            if not replaced:
                patch.setattr(kernel_text, "shortened", lambda text: text)
            for function in mixed, exchanged:
                function.adj.translation = None
            rows = Rows()
            rows.value, rows.count = wp.clone(x), 3
            kernel, y = kernel_to(count), wp.zeros(200, dtype=float, device="cpu")
            texts.append(lines_of(kernel))
            wp.launch(kernel, 200, [x, n, rows], [y], device="cpu")
            found.append(np.concatenate([y.numpy(), rows.value.numpy()]))
    assert len(texts[0]) < 0.9 * len(texts[1])
    assert sum("wp::mul(" in line for line in texts[0]) < sum("wp::mul(" in line for line in texts[1])
    np.testing.assert_array_equal(found[0].view(np.int32), found[1].view(np.int32))
