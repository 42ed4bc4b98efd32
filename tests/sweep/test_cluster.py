"""Sweeps on a Ray cluster: equal to those without, also when workers die; and what is said where there is none."""

import os
import signal
import socket
import sys
import threading
from pathlib import Path

import pytest

from patience import until
from small_sweep import RUNS, assert_same_file, small_sweep
from warpmuscle.core.errors import Error
from warpmuscle.sweep import cluster
from warpmuscle.sweep.run import sweep
from warpmuscle.sweep.status import sweep_status


@pytest.fixture(scope="module")
def two_nodes():
    """Address of a cluster of two nodes with a CPU each, on this machine."""
    pytest.importorskip("ray", reason="Ray is not installed: pip install warpmuscle[cluster]")
    from ray.cluster_utils import Cluster

    found = Cluster(initialize_head=True, head_node_args={"num_cpus": 1, "include_dashboard": False})
    found.add_node(num_cpus=1)
    yield found.address
    found.shutdown()


def worker_at(journals: Path) -> int | None:
    """Process that has a journal of this folder open, other than this one."""
    for process in Path("/proc").iterdir():
        if process.name.isdigit() and int(process.name) != os.getpid():
            try:
                opened = [os.readlink(link) for link in (process / "fd").iterdir()]
            except OSError:
                continue
            if any(name.startswith(f"{journals}/") and name.endswith(".journal") for name in opened):
                return int(process.name)
    return None


def kill_half_way(output: Path, killed: list[int]) -> None:
    """Kill the worker that is at work when half of the candidates have been evaluated."""

    def is_half_way() -> bool:
        if not (output.parent / "small.sweep" / "sweep.json").exists():
            return False
        status = sweep_status(output)
        return status.evaluated >= sum(run.candidates for run in status.runs) // 2

    until(lambda: is_half_way() and (found := worker_at(output.parent / "small.sweep")) and not killed.append(found))
    os.kill(killed[0], signal.SIGKILL)


def test_sweep_with_a_worker_killed_half_way_equals_the_sweep_without_ray(two_nodes, tmp_path):
    for name in ("here", "cluster"):
        (tmp_path / name).mkdir()
        small_sweep(tmp_path / name, candidates=60, duration=0.2)
    output, killed = tmp_path / "cluster" / "small.h5", []
    killer = threading.Thread(target=kill_half_way, args=(output, killed), daemon=True)
    killer.start()
    result = sweep(output.with_suffix(".toml"), output, cluster=two_nodes, device="cpu", command="test")
    killer.join()
    assert len(killed) == 1
    assert (result.failed, result.gathered) == ({}, RUNS)
    sweep(tmp_path / "here" / "small.toml", tmp_path / "here" / "small.h5", device="cpu", command="test")
    assert_same_file(output, tmp_path / "here" / "small.h5")


def test_neither_probe_nor_workers_import_from_the_current_folder(two_nodes, tmp_path, monkeypatch):
    for name in ("ray", "logging", "warpmuscle", "numpy", "msgspec"):
        (tmp_path / f"{name}.py").write_text(f"open({str(tmp_path / name)!r}, 'w')\nraise SystemExit('ran')\n")
    monkeypatch.chdir(tmp_path)
    result = sweep(small_sweep(tmp_path), cluster=two_nodes, device="cpu", command="test")
    assert (result.failed, result.gathered) == ({}, RUNS)
    assert not [path for path in tmp_path.iterdir() if not path.suffix]


def test_workers_that_do_not_see_the_folder_send_back_files(two_nodes, tmp_path, monkeypatch):
    for name in ("here", "cluster"):
        (tmp_path / name).mkdir()
        small_sweep(tmp_path / name)
    output = tmp_path / "cluster" / "small.h5"
    original = cluster._work

    def elsewhere(tasks, folder, token, *more):
        return original(tasks, folder, "another", *more)

    def interrupt(progress):
        if progress.ended >= 5:
            raise KeyboardInterrupt

    monkeypatch.setattr(cluster, "_work", elsewhere)
    with pytest.raises(KeyboardInterrupt):
        sweep(
            output.with_suffix(".toml"), output, cluster=two_nodes, device="cpu", share=3, command="test",
            progress=interrupt,
        )  # fmt: skip
    assert 5 <= sweep_status(output).ended < RUNS
    sweep(output.with_suffix(".toml"), output, cluster=two_nodes, device="cpu", share=3, command="test")
    sweep(tmp_path / "here" / "small.toml", tmp_path / "here" / "small.h5", device="cpu", command="test")
    assert_same_file(output, tmp_path / "here" / "small.h5")


def test_worker_that_always_dies_is_said_to_and_the_same_sweep_goes_on(two_nodes, tmp_path, monkeypatch):
    def dies(*arguments):
        os.kill(os.getpid(), signal.SIGKILL)

    file = tmp_path / "a.toml"
    file.write_text('scene = "fwalk"\n[set]\nduration = 0.1\n[search]\ncandidates = 4\npopulation = 2\n')
    output = tmp_path / "a.h5"
    with monkeypatch.context() as patch:
        patch.setattr(cluster, "_work", dies)
        patch.setattr(cluster, "RETRIES", 1)
        result = sweep(file, output, cluster=two_nodes, device="cpu")
    assert result.failed == {"run": "its worker died 2 times (WorkerCrashedError); the same command goes on"}
    assert sweep(file, output, cluster=two_nodes, device="cpu").failed == {}


def test_cluster_without_what_is_asked_for_is_an_error(two_nodes, tmp_path):
    file = small_sweep(tmp_path)
    with pytest.raises(Error, match="the cluster has no GPU: it has 2 CPU cores and 0 GPUs"):
        sweep(file, tmp_path / "small.h5", cluster=two_nodes, device="cuda:0")
    with pytest.raises(Error, match="has no 9 CPU cores for a task"):
        sweep(file, tmp_path / "small.h5", cluster=two_nodes, threads=9)
    assert not (tmp_path / "small.sweep").exists()


def test_unreachable_cluster_is_one_line(tmp_path, monkeypatch):
    pytest.importorskip("ray", reason="Ray is not installed: pip install warpmuscle[cluster]")
    monkeypatch.setattr(cluster, "PROBE_TIMEOUT", 8.0)
    with socket.socket() as other:
        other.bind(("127.0.0.1", 0))
        address = f"127.0.0.1:{other.getsockname()[1]}"
        with pytest.raises(Error, match=f"no Ray cluster answers at '{address}': Connection refused"):
            sweep(small_sweep(tmp_path), tmp_path / "small.h5", cluster=address)
        other.listen()  # somebody, but no Ray
        with pytest.raises(Error, match=f"no Ray cluster answers at '{address}' within 8 s"):
            sweep(small_sweep(tmp_path), tmp_path / "small.h5", cluster=address)
    assert not (tmp_path / "small.sweep").exists()


def test_missing_ray_is_one_line_that_says_what_to_install(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "ray", None)  # as where it is not installed
    with pytest.raises(Error, match=r'a cluster needs Ray: pip install "warpmuscle\[cluster\]"'):
        sweep(small_sweep(tmp_path), tmp_path / "small.h5", cluster="auto")
