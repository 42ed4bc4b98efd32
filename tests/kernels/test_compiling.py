"""How modules are compiled for a processor in tests, and by users, changes no machine code."""

from pathlib import Path
from typing import Any

import pytest
import warp as wp
from warp._src import build

import kernel_tests
from warpmuscle.kernels.functions import CPU_FLAGS

kernel_tests.start()

# Structures that are copied, products that are fused, loops, and memory of two types.
TEXT = """
struct pair_t { float a, b; };
static inline pair_t product(const pair_t& x, const pair_t& y)
{ return {x.a * y.a - x.b * y.b, x.a * y.b + x.b * y.a}; }
extern "C" void powers(pair_t* pairs, int* counts, int n)
{
    for (int i = 0; i < n; i++) {
        pair_t whole = {1.0f, 0.0f};
        for (int k = 0; k < counts[i]; k++)
            whole = product(whole, pairs[i]);
        counts[i] = whole.a > whole.b;
        pairs[i] = whole;
    }
}
"""


def machine_code(folder: Path, flags: str, level: int) -> bytes:
    """What the text becomes."""
    source, made = folder / "text.cpp", folder / "text.o"
    source.write_text(TEXT)
    build.build_cpu.__wrapped__(str(made), str(source), extra_flags=flags, optimization_level=level)
    return made.read_bytes()


@pytest.mark.parametrize("level", [0, 2])
def test_without_checks_of_the_compilers_own_work_the_same_comes_out(tmp_path: Path, level: int) -> None:
    flags = CPU_FLAGS.split()
    assert set(kernel_tests.UNCHECKED) < set(flags)
    checked = [flag for flag in flags if flag not in kernel_tests.UNCHECKED]
    quick = " ".join((*checked, *kernel_tests.QUICK))
    for given in (CPU_FLAGS, quick):
        assert machine_code(tmp_path, given, level) == machine_code(tmp_path, " ".join(checked), level)
    assert machine_code(tmp_path, CPU_FLAGS, 0) != machine_code(tmp_path, CPU_FLAGS, 2)  # so it can differ


class TestHeaders:
    @pytest.fixture
    def calls(self, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> list[dict[str, Any]]:
        monkeypatch.setattr(kernel_tests, "_headers", [])
        kernel_tests.share_headers(tmp_path / "headers")
        return []

    @pytest.mark.skipif(kernel_tests.fcntl is None, reason="no locks of files here")
    def test_the_first_module_makes_them_alone_and_all_workers_find_them(self, calls: list[dict[str, Any]]) -> None:
        compiled = kernel_tests.with_less_work(lambda *paths, **options: calls.append(options))
        for flags in ("-march=native", "-march=native", "-O1 -discard-value-names"):
            compiled("a.o", "a.cpp", extra_flags=flags, pch_dir="own", block_dim=1)
        assert [call["pch_dir"] for call in calls] == [str(kernel_tests._headers[0])] * 3
        assert [sorted(call["extra_flags"].split()) for call in calls] == [
            *([sorted(("-march=native", *kernel_tests.QUICK))] * 2),
            sorted(("-O1", *kernel_tests.QUICK)),
        ]
        assert len(list(kernel_tests._headers[0].glob("*.made"))) == 2  # one for each choice of flags

    @pytest.mark.skipif(kernel_tests.fcntl is None, reason="no locks of files here")
    def test_where_the_first_fails_the_next_makes_them(self, calls: list[dict[str, Any]]) -> None:
        def failing_once(*paths: str, **options: Any) -> None:
            calls.append(options)
            if len(calls) == 1:
                raise RuntimeError("no such function")

        compiled = kernel_tests.with_less_work(failing_once)
        with pytest.raises(RuntimeError):
            compiled("a.o", "a.cpp", pch_dir="own")
        assert not list(kernel_tests._headers[0].glob("*.made"))
        compiled("a.o", "a.cpp", pch_dir="own")
        assert len(list(kernel_tests._headers[0].glob("*.made"))) == 1

    def test_a_module_without_headers_of_its_own_has_none_of_others(self, calls: list[dict[str, Any]]) -> None:
        compiled = kernel_tests.with_less_work(lambda *paths, **options: calls.append(options))
        compiled("a.o", "a.cpp", use_precompiled_headers=False, pch_dir=None)
        assert calls[0]["pch_dir"] is None


def test_this_version_of_warp_is_the_one_whose_function_is_replaced() -> None:
    assert wp.config.use_precompiled_headers
    assert build.build_cpu.__wrapped__.__module__ == build.__name__
