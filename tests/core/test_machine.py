"""What says on which machine a result was made."""

import os
import subprocess
import sys

import h5py
import pytest
from threadpoolctl import threadpool_info

from patience import PATIENCE
from small_result import search_result
from warpmuscle.core.machine import _processor, cores, this_machine
from warpmuscle.results.result import read, write


def test_names_processor_and_blas_of_numpy():
    machine = this_machine()
    assert set(machine) == {"processor", "blas"}
    assert all(text and "\n" not in text for text in machine.values())
    for library in threadpool_info():
        if library["user_api"] == "blas" and "numpy" in library["filepath"]:
            assert library["version"] in machine["blas"]


@pytest.mark.skipif("openblas" not in this_machine()["blas"], reason="only OpenBLAS can be told which kernels to take")
@pytest.mark.skipif(
    "x86_64" not in this_machine()["processor"], reason="names of kernels are those of one architecture"
)
def test_kernels_of_blas_are_told_apart(monkeypatch):
    monkeypatch.setenv("OPENBLAS_CORETYPE", "Nehalem")  # which every processor of this architecture has
    code = "from warpmuscle.core.machine import this_machine; print(this_machine()['blas'])"
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=PATIENCE, check=True)
    assert found.stdout.strip().endswith(", Nehalem kernels")


def test_models_of_one_name_are_told_apart(tmp_path):
    described = tmp_path / "cpuinfo"
    described.write_text("processor\t: 0\ncpu family\t: 25\nmodel\t\t: 17\nmodel name\t: AMD  EPYC\n\nprocessor\t: 1\n")
    assert _processor(described).endswith("AMD EPYC, family 25, model 17")
    assert _processor(tmp_path / "none")


def test_result_keeps_the_machine_that_made_it_and_older_ones_have_none(tmp_path):
    path = tmp_path / "a.h5"
    write(path, search_result())
    assert read(path).machine == this_machine()
    with h5py.File(path, "a") as file:
        file.attrs["processor"] = "an abacus"
    assert read(path).machine == this_machine() | {"processor": "an abacus"}
    with h5py.File(path, "a") as file:
        del file.attrs["processor"], file.attrs["blas"]
    assert read(path).machine == {}


def test_cores_are_those_that_the_process_may_use(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(os, "sched_getaffinity", lambda process: {0, 3, 5}, raising=False)
    monkeypatch.setattr(os, "cpu_count", lambda: 64)
    assert cores() == 3
    monkeypatch.delattr(os, "sched_getaffinity")
    assert cores() == 64
