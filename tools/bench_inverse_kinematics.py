"""Frames of inverse kinematics a second: here and by OpenSim, on one core each, from the same markers.

    python tools/bench_inverse_kinematics.py MODEL.osim MARKERS.trc [--frames 600] [--device cuda:0]
    python tools/bench_inverse_kinematics.py MODEL.osim MOTION.sto [--noise 0.01]
    python tools/bench_inverse_kinematics.py MODEL.osim MARKERS.trc --frames 500000 --trials 1000 --parts

A motion (`.sto`, `.mot`) gives the places of all markers of the model, each off by a vector of its own of so many
metres, and by a tenth of that anew in every frame. Frames are repeated until there are so many; OpenSim gets the first
60 of them. The first fit compiles and is not timed.

With `--parts` the fit runs again, all work of the device being waited for after each launch and copy: how long kernels,
copies and the rest, which is the host's, take. The last lines tell the most memory of the host and of the device.
"""

from __future__ import annotations

import argparse
import os
import resource
import tempfile
import time
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("OMP_NUM_THREADS", "1")

import numpy as np
import warp as wp

import warpmuscle as wm
from warpmuscle.formats.external_loads import TO_OPENSIM
from warpmuscle.inverse.chain import chain_of
from warpmuscle.inverse.files import angle_names, read_coordinates, read_markers
from warpmuscle.inverse.marker_fit import MarkerFitter
from warpmuscle.inverse.trial import Markers

THEIRS = 60  # frames for OpenSim


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("model")
    parser.add_argument("recording")
    parser.add_argument("--frames", type=int, default=3000)
    parser.add_argument("--noise", type=float, default=0.01)
    parser.add_argument("--trials", type=int, default=1, help="recordings that the frames are of")
    parser.add_argument("--parts", action="store_true", help="tell kernels, copies and the host apart")
    parser.add_argument("--no-opensim", action="store_true")
    parser.add_argument("--device")
    parser.add_argument("--degrees", action="store_true", help="angles of the motion are in degrees, whatever it says")
    options = parser.parse_args()
    warnings.simplefilter("ignore")
    scene = wm.load(options.model)
    markers = _markers(scene, options)
    many = _repeated(markers, options.frames, options.trials)
    wm.inverse_kinematics(scene, markers, device=options.device)
    with _fitting() as fitting:
        began, spent = time.perf_counter(), time.process_time()
        found = wm.inverse_kinematics(scene, many, device=options.device)
        wall, cpu = time.perf_counter() - began, time.process_time() - spent
    count = np.mean([np.abs(one.iterations).mean() for one in found])
    print(f"of it the fit itself, on the device: {sum(fitting):.3f} s of wall")
    print(
        f"here: {len(found[0].markers)} markers, {len(chain_of(scene).coordinates)} free coordinates, {options.frames} "
        f"frames in {wall:.3f} s of wall, {cpu:.3f} s of CPU time: {options.frames / wall:.0f} and "
        f"{options.frames / cpu:.0f} frames/s; {count:.1f} iterations a frame"
    )
    del found
    if options.parts:
        _parts(lambda: wm.inverse_kinematics(scene, many, device=options.device), options.frames)
    _memory(options.device)
    if not options.no_opensim:
        _opensim(scene, options.model, Markers(markers.names, markers.times[:THEIRS], markers.positions[:THEIRS]))


def _repeated(markers: Markers, frames: int, trials: int) -> list[Markers]:
    """So many frames in all, again and again those recorded, each recording off by a millimetre of its own."""
    random, found = np.random.default_rng(2), []
    for part in np.array_split(np.arange(frames), trials):
        off = 1e-3 * random.normal(size=(1, len(markers.names), 3))
        times = np.arange(len(part)) / 100.0
        found.append(Markers(markers.names, times, markers.positions[part % len(markers.times)] + off))
    return found


def _parts(work: Callable[[], object], frames: int) -> None:
    """Print how long kernels, copies to and from the device, and the rest take."""
    spent: dict[str, np.ndarray] = {}  # s of wall and of CPU time

    def timed(name: str, call: Callable[..., Any]) -> Callable[..., Any]:
        def run(*arguments: Any, **named: Any) -> Any:
            wp.synchronize()
            own = name or f"kernel {arguments[0].key.split('__')[0]}"
            began, used = time.perf_counter(), time.process_time()
            result = call(*arguments, **named)
            wp.synchronize()
            took = np.array([time.perf_counter() - began, time.process_time() - used])
            spent[own] = spent.get(own, np.zeros(2)) + took
            return result

        return run

    kept = wp.launch, wp.copy, wp.array.numpy, wp.empty, wp.zeros
    wp.launch, wp.copy = timed("", wp.launch), timed("copies", wp.copy)
    wp.empty, wp.zeros = (timed("memory", one) for one in (wp.empty, wp.zeros))
    wp.array.numpy = timed("results", wp.array.numpy)
    try:
        began, used = time.perf_counter(), time.process_time()
        work()
        whole = np.array([time.perf_counter() - began, time.process_time() - used])
    finally:
        wp.launch, wp.copy, wp.array.numpy, wp.empty, wp.zeros = kept
    spent["host"] = whole - np.sum(list(spent.values()), axis=0)
    print(f"parts, waited for one by one, {whole[0]:.3f} s of wall, {whole[1]:.3f} s of CPU time; us a frame:")
    for name, seconds in sorted(spent.items(), key=lambda item: -item[1][0]):
        print(f"  {name:<26} {1e6 * seconds[0] / frames:8.3f} {1e6 * seconds[1] / frames:8.3f}")


def _memory(device: str | None) -> None:
    """Print the most memory that the process and its device have used."""
    print(f"most memory of the process: {resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024:.0f} MB")
    place = wp.get_device(device)
    if place.is_cuda and place.is_mempool_enabled:
        print(f"most memory of the device: {wp.get_mempool_used_mem_high(place) / 2**20:.0f} MB")


@contextmanager
def _fitting() -> Iterator[list[float]]:
    """A list that gets the wall time of every launch of the fit meanwhile."""
    found: list[float] = []
    launch = MarkerFitter.launch

    def timed(self: MarkerFitter, *arguments: Any) -> None:
        began = time.perf_counter()
        launch(self, *arguments)
        wp.synchronize()
        found.append(time.perf_counter() - began)

    MarkerFitter.launch = timed  # type: ignore[method-assign]
    try:
        yield found
    finally:
        MarkerFitter.launch = launch  # type: ignore[method-assign]


def _markers(scene: wm.Scene, options: argparse.Namespace) -> Markers:
    if Path(options.recording).suffix not in (".sto", ".mot"):
        return read_markers(options.recording)
    motion = read_coordinates(options.recording, scene, options.degrees or None)
    chain = chain_of(scene)
    values = np.stack([motion.of(name) for name in chain.coordinates], axis=1)
    names = tuple(chain.markers)
    at = chain.places(chain.poses(values), list(chain.markers.values())) @ TO_OPENSIM.T
    random = np.random.default_rng(1)
    at += options.noise * random.normal(size=(1, len(names), 3)) + 0.1 * options.noise * random.normal(size=at.shape)
    return Markers(names, motion.times, at)


def _opensim(scene: wm.Scene, model: str, markers: Markers) -> None:
    try:
        import opensim
    except ImportError:
        print("OpenSim is not installed here")
        return
    opensim.Logger.setLevelString("off")
    with tempfile.TemporaryDirectory() as folder:
        trc, out = Path(folder, "markers.trc"), Path(folder, "ik.mot")
        trc.write_text(trc_text(markers))
        tool = opensim.InverseKinematicsTool()
        theirs = opensim.Model(model)
        tool.setModel(theirs)
        tool.setMarkerDataFileName(str(trc))
        tool.setStartTime(float(markers.times[0]))
        tool.setEndTime(float(markers.times[-1]))
        tool.setOutputMotionFileName(str(out))
        tool.set_report_errors(False)
        tool.set_accuracy(1e-5)
        began, spent = time.perf_counter(), time.process_time()
        tool.run()
        wall, cpu = time.perf_counter() - began, time.process_time() - spent
        their = read_coordinates(out, scene)
    count = len(their.times)
    print(
        f"OpenSim {opensim.GetVersion()}: {count} frames, {count / wall:.1f} a second of wall, "
        f"{count / cpu:.1f} of CPU time"
    )
    ours = wm.inverse_kinematics(scene, markers).coordinates
    angles = [name for name in their.names if name in angle_names(scene) and name in ours.names]
    off = {name: np.degrees(np.abs(ours.of(name)[:count] - their.of(name)).max()) for name in angles}
    worst = max(off, key=lambda name: off[name])
    print(
        f"angles differ by {off[worst]:.4f} degrees at most ({worst}), "
        f"{np.median(list(off.values())):.4f} in the median"
    )


def trc_text(markers: Markers) -> str:
    """Markers as a .trc file."""
    rate = (len(markers.times) - 1) / (markers.times[-1] - markers.times[0])
    head = [
        "PathFileType\t4\t(X/Y/Z)\tmarkers.trc",
        "DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\tOrigDataStartFrame\tOrigNumFrames",
        f"{rate:.6f}\t{rate:.6f}\t{len(markers.times)}\t{len(markers.names)}\tm\t{rate:.6f}\t1\t{len(markers.times)}",
        "Frame#\tTime\t" + "\t\t\t".join(markers.names),
        "\t\t" + "\t".join(f"{axis}{k + 1}" for k in range(len(markers.names)) for axis in "XYZ"),
        "",
    ]
    rows = [
        f"{k + 1}\t{time:.8f}\t" + "\t".join("" if np.isnan(x) else f"{x:.9f}" for x in row.ravel())
        for k, (time, row) in enumerate(zip(markers.times, markers.positions, strict=True))
    ]
    return "\n".join([*head, *rows]) + "\n"


if __name__ == "__main__":
    main()
