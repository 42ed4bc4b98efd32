"""How fast recordings become moments and muscle forces, on any device: a table of rates.

    python tools/bench_inverse.py MODEL.osim MOTION.sto --loads LOADS.xml
    python tools/bench_inverse.py MODEL.osim MOTION.sto --loads LOADS.xml --strides 1000 --frames 100 --device cuda:0
    python tools/bench_inverse.py MODEL.osim MOTION.sto --loads LOADS.xml --strides 20 --opensim

The motion is cut into strides of so many frames, again and again, each a little other than those before, which are
written as files of motions and loads; the whole chain starts from these. Every rate is of the best of some runs,
kernels being compiled; on a CPU it is by processor time. With `--opensim` OpenSim does frames of the motion by its own
tools, on one core and by processor time, too, and the chain is put beside its static optimisation.
"""

from __future__ import annotations

import resource
import time
import warnings
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Annotated, Any

import numpy as np
import typer
import warp as wp
from opensim_static_optimization import analyze, write_reserves

from warpmuscle.cli.ending import run_script
from warpmuscle.formats.sto import storage_text
from warpmuscle.inverse.activations import ActivationOptions
from warpmuscle.inverse.body_model import BodyModel
from warpmuscle.inverse.dynamics import inverse_dynamics, prepare
from warpmuscle.inverse.files import read_coordinates
from warpmuscle.inverse.loads import read_loads
from warpmuscle.inverse.reactions.joint_reactions import reactions_of
from warpmuscle.inverse.static_optimization import Launch, Solver, activations_of
from warpmuscle.inverse.trial import Coordinates, Loads

OPENSIMS = 41  # frames that OpenSim's static optimisation does
NOISE = 0.01  # of a coordinate's range, by which strides differ


def best(work: Callable[[], Any], device: Any, runs: int = 3) -> float:
    """Shortest time of several runs, s; on a CPU, which others may use, too, of the processor."""
    clock = time.process_time if device.is_cpu else time.perf_counter
    found = []
    for _ in range(runs):
        start = clock()
        work()
        wp.synchronize()
        found.append(clock() - start)
    return min(found)


def strides(motion: Coordinates, loads: Loads, count: int, frames: int) -> list[tuple[Coordinates, Loads]]:
    """So many pieces of a motion and its loads, each a little other than the piece that it is of."""
    random = np.random.default_rng(0)
    last = max(len(motion.times) - frames, 0)
    step = max((len(motion.times) - 1) // max(frames - 1, 1), 1)
    found = []
    for k in range(count):
        rows = slice(0, None, step) if last >= frames * (step - 1) and step > 1 else slice(k % (last + 1), None)
        times, values = motion.times[rows][:frames], motion.values[rows][:frames]
        shift = NOISE * np.ptp(motion.values, axis=0) * random.normal(size=values.shape[1])
        found.append((Coordinates(motion.names, times, values + shift), loads))
    return found


def write(trials: list[tuple[Coordinates, Loads]], body: BodyModel, folder: Path) -> list[tuple[Path, Path]]:
    """Files of trials: coordinates in rad, and loads of their time."""
    found = []
    for k, (motion, loads) in enumerate(trials):
        paths = folder / f"motion{k}.sto", folder / f"loads{k}.mot"
        table = np.column_stack([motion.times, motion.values])
        paths[0].write_text(storage_text("motion", ["time", *motion.names], table))
        rows = (loads.times > motion.times[0] - 0.02) & (loads.times < motion.times[-1] + 0.02)
        names, columns = ["time"], [loads.times[rows][:, None]]
        for plate in loads.plates:
            parts = (plate.force, f"{plate.body}_force_v"), (plate.point, f"{plate.body}_force_p"), (
                plate.moment, f"{plate.body}_torque_",
            )  # fmt: skip
            for values, start in parts:
                names += [f"{start}{axis}" for axis in "xyz"]
                columns.append(values[rows])
        paths[1].write_text(storage_text("loads", names, np.concatenate(columns, axis=1)))
        found.append(paths)
    return found


def opensim_seconds(model: Path, motion: Path, loads: Path, times: Any, step: int) -> float:
    """Processor time a frame, s, of OpenSim's static optimisation of a motion.

    The start of the tool does not count: two runs of some and of twice as many frames are taken from each other.

    Args:
        times: of the motion's frames. step: every so manieth is optimised, as far apart as those of strides.
    """
    import opensim

    opensim.Logger.setLevelString("off")
    loaded = opensim.Model(str(model))
    coordinates = loaded.getCoordinateSet()
    names = [coordinates.get(k).getName() for k in range(coordinates.getSize())]
    with TemporaryDirectory() as place:
        folder = Path(place)
        file = folder / "reserves.xml"
        write_reserves({name: 100.0 if name.startswith("pelvis") else 1.0 for name in names}, file)
        half, took = len(times) // (2 * step) * step, []
        for end in (times[half], times[-1]):
            start = time.process_time()
            wanted = opensim.StaticOptimization()
            wanted.setStepInterval(step)
            analyze(model, motion, loads, file, [wanted], (float(times[0]), float(end)), folder)
            took.append(time.process_time() - start)
    return (took[1] - took[0]) / ((len(times) - 1 - half) // step)


def main(
    model: Annotated[Path, typer.Argument(help="OpenSim model.")],
    motion: Annotated[Path, typer.Argument(help="Coordinates, .mot or .sto.")],
    loads: Annotated[Path, typer.Option(help="External loads, .xml.")],
    strides_: Annotated[int, typer.Option("--strides", min=1, help="How many trials.")] = 20,
    frames: Annotated[int, typer.Option(min=2, help="Frames of each.")] = 100,
    device: Annotated[str | None, typer.Option(help="cpu, cuda:0, ...")] = None,
    markers: Annotated[Path | None, typer.Option(help="Markers, .trc, of the inverse kinematics.")] = None,
    marker_model: Annotated[Path | None, typer.Option(help="Its model, if it is another one.")] = None,
    opensim: Annotated[bool, typer.Option("--opensim", help="And OpenSim's tools on the motion.")] = False,
) -> None:
    """Print the table."""
    warnings.simplefilter("ignore")
    start = time.perf_counter()
    body = BodyModel(model, device)
    print(f"model: {time.perf_counter() - start:.1f} s; {len(body.muscles)} muscles, {len(body.map.names)} coordinates")
    recorded, forces = read_coordinates(motion, body.scene), read_loads(loads)
    trials = strides(recorded, forces, strides_, frames)
    with TemporaryDirectory() as folder:
        paths = write(trials, body, Path(folder))
        start = time.perf_counter()
        activations_of(body, prepare(body, *map(list, zip(*trials[:1], strict=True)), None, None), ActivationOptions())
        print(f"first trial, kernels compiled or loaded: {time.perf_counter() - start:.1f} s")
        n = sum(len(one.times) for one, _ in trials)
        print(f"{strides_} trials, {n} frames, on {body.device}\n\n| step | s | frames/s |\n|---|---|---|")

        def row(name: str, seconds: float) -> None:
            print(f"| {name} | {seconds:.3g} | {n / seconds:,.0f} |", flush=True)

        read: list[tuple[Coordinates, Loads]] = []

        def read_all() -> None:
            read[:] = [(read_coordinates(one, body.scene), read_loads(other)) for one, other in paths]

        row("files read", best(read_all, body.device, 1))
        bodies = [plate.body for plate in forces.plates]
        named = [(one, told(other, bodies)) for one, other in read]
        motions, all_loads = [one for one, _ in named], [other for _, other in named]
        row("splines, states and loads", best(lambda: prepare(body, motions, all_loads, None, None), body.device))
        prepared = prepare(body, motions, all_loads, None, None)
        row("inverse dynamics alone", best(lambda: body.dynamics(prepared.states, prepared.loads), body.device))
        row("inverse dynamics, from arrays", best(lambda: inverse_dynamics(body, motions, all_loads), body.device))
        row("muscles: paths, moment arms, forces", best(lambda: [
            body.muscle_frames(prepared.states, part) for part in body.chunks(n)], body.device))  # fmt: skip
        dynamics = body.dynamics(prepared.states, prepared.loads)
        effort = dynamics.effort + dynamics.followed
        alone, again = solves(body, prepared, effort)
        row("static optimisation alone, solves/s", alone)
        print(f"| of it frames that are solved again, in double precision | {again:.3g} | |")
        row(
            "static optimisation with muscles",
            best(lambda: activations_of(body, prepared, ActivationOptions(), (), effort), body.device),
        )
        acting = activations_of(body, prepared, ActivationOptions(), (), effort)
        row("joint reactions", best(lambda: reactions_of(body, prepared, acting), body.device, 2))

        def chain() -> None:
            read_all()
            own = [told(two, bodies) for _, two in read]
            activations_of(body, prepare(body, [one for one, _ in read], own, None, None), ActivationOptions())

        whole = best(chain, body.device, 2)
        row("whole chain, files to activations", whole)
    if markers is not None:
        kinematics(marker_model or model, markers, strides_, device)
    memory(body)
    if opensim:
        step = max(round(float(np.diff(trials[0][0].times).mean() / np.diff(recorded.times).mean())), 1)
        times = recorded.times[: (OPENSIMS - 1) * step + 1]
        seconds = opensim_seconds(model.resolve(), motion.resolve(), loads.resolve(), times, step)
        print(f"| OpenSim's static optimisation, one core, a frame | {seconds:.3g} | {1 / seconds:.1f} |")
        print(f"\nthe whole chain is {seconds * n / whole:,.0f} times as fast as OpenSim's")


def kinematics(model: Path, markers: Path, count: int, device: str | None) -> None:
    """Print the rate of inverse kinematics of so many trials of the same markers, each a little other."""
    from warpmuscle.formats import load
    from warpmuscle.inverse.files import read_markers
    from warpmuscle.inverse.kinematics import inverse_kinematics

    scene, recorded, random = load(model, ignored=[]), read_markers(markers), np.random.default_rng(0)
    trials = [
        replace(recorded, positions=recorded.positions + 1e-3 * random.normal(size=recorded.positions.shape))
        for _ in range(count)
    ]
    inverse_kinematics(scene, trials[:1], device=device)
    seconds, n = (
        best(lambda: inverse_kinematics(scene, trials, device=device), wp.get_device(device), 2),
        count * len(recorded.times),
    )
    print(f"| inverse kinematics, {n} frames, {len(recorded.names)} markers | {seconds:.3g} | {n / seconds:,.0f} |")


def memory(body: BodyModel) -> None:
    """Print how much memory has been in use at most, by this process and on its GPU."""
    print(f"\nmost memory of the process: {resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024:,.0f} MB")
    if body.device.is_cuda and body.device.is_mempool_enabled:
        print(f"most memory of the device: {wp.get_mempool_used_mem_high(body.device) / 2**20:,.0f} MB")


def told(loads: Loads, bodies: list[str | None]) -> Loads:
    """Loads whose plates act on these bodies."""
    return Loads(
        loads.times, tuple(replace(plate, body=name) for plate, name in zip(loads.plates, bodies, strict=True))
    )


def solves(body: BodyModel, prepared: Any, effort: Any) -> tuple[float, float]:
    """Seconds of the solver alone for all frames, and of those that it solves twice; all it needs is on the device."""
    solver = Solver(body, prepared, ActivationOptions(), ())
    launches: list[Launch] = [
        solver.launch(effort[part], body.muscle_frames(prepared.states, part), part)
        for part in body.chunks(len(effort))
    ]

    def first() -> None:
        for one in launches:
            one.run()

    def whole() -> None:
        first()
        for one in launches:
            one.mend()

    whole()
    return (found := best(whole, body.device)), max(found - best(first, body.device), 0.0)


if __name__ == "__main__":
    run_script(main)
