"""The command from recordings to muscles."""

from __future__ import annotations

import json
import math
import shlex
import warnings
from collections import Counter
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from warpmuscle.cli.common import Device, Trust, command_line, start_warp, writable, writable_folder
from warpmuscle.cli.console import log, out, suggest
from warpmuscle.cli.recordings.inputs import predicted_loads, read_all_emg, read_all_loads, read_motions, reserves_of
from warpmuscle.core.errors import Error
from warpmuscle.core.plain_text import number_of, readable

if TYPE_CHECKING:
    from collections.abc import Sequence

    from warpmuscle.inverse.activations import ActivationOptions
    from warpmuscle.inverse.body_model import BodyModel
    from warpmuscle.inverse.emg import Emg
    from warpmuscle.inverse.output import Trial
    from warpmuscle.inverse.simulated_ground.ground_run import GroundRun
    from warpmuscle.inverse.tracking.tracker import TrackingOptions
    from warpmuscle.inverse.trial import Loads

SHOWN = 5  # of a list of frames
CHOICES = "rates", "pennation"  # of ways in which OpenSim is not exact
NOTED = 1.0e-3  # N m or N, of what acts beside muscles

LoadFiles = Annotated[
    list[Path] | None,
    typer.Option(
        "--loads", help="External loads' .xml, or forces in .mot, .sto, .csv or .c3d. One for all, or one each."
    ),
]
EmgFiles = Annotated[
    list[Path] | None,
    typer.Option("--emg", help="Envelopes from 0 to 1 by names of muscles, or raw in .c3d. One a motion."),
]
Channels = Annotated[
    list[str] | None, typer.Option(metavar="MUSCLE=NAME", help="Analog channel of a muscle in an --emg that is a .c3d.")
]
ModelForces = Annotated[
    bool, typer.Option("--model-forces", help="Springs, bushings and limits of the model act, as in OpenSim.")
]
NoPlates = Annotated[bool, typer.Option("--no-plates", help="Find the ground's forces on the feet from the motion.")]


def inverse(
    model: Annotated[str, typer.Argument(metavar="MODEL", help="A .osim file, or a scene.")],
    motions: Annotated[
        list[Path],
        typer.Argument(metavar="MOTION...", help="Coordinates: .mot, .sto or .csv; or markers: .trc or .c3d."),
    ],
    loads: LoadFiles = None,
    emg: EmgFiles = None,
    channel: Channels = None,
    up: Annotated[str | None, typer.Option(help="Axis of markers and of .c3d that is up, such as z.")] = None,
    forward: Annotated[str | None, typer.Option(help="Axis of them that is forward, such as -x.")] = None,
    no_plates: NoPlates = False,
    steps: Annotated[str, typer.Option(help="What is found: ik, id, so, jr, track.")] = "id,so,jr",
    setup: Annotated[
        Path | None, typer.Option(help="Set-up file of OpenSim's InverseKinematicsTool, for markers.")
    ] = None,
    filter: Annotated[float | None, typer.Option(metavar="HZ", help="Cut-off of a low-pass of coordinates.")] = None,
    begin: Annotated[float, typer.Option(help="First time, s.")] = -math.inf,
    end: Annotated[float, typer.Option(help="Last time, s.")] = math.inf,
    every: Annotated[int, typer.Option(min=1, help="Take only every Nth frame; splines go through all.")] = 1,
    power: Annotated[int, typer.Option(min=1, max=4, help="p of the cost, a sum of activations^p.")] = 2,
    weight: Annotated[str, typer.Option(help="Of activations in the cost: none, or volume.")] = "none",
    reserve: Annotated[
        list[str] | None,
        typer.Option(metavar="[NAME=]STRENGTH", help="N m or N, of the reserves of all coordinates, or of one. [0.1]"),
    ] = None,
    passive: Annotated[bool, typer.Option("--passive", help="Passive forces of muscles make moments, too.")] = False,
    isometric: Annotated[bool, typer.Option("--isometric", help="Forces do not depend on length and speed.")] = False,
    emg_weight: Annotated[float, typer.Option(min=0, help="Of differences from EMG in the cost.")] = 1.0,
    rates: Annotated[bool, typer.Option("--rates", help="Activations change as fast as muscles can.")] = False,
    elastic: Annotated[bool, typer.Option("--elastic", help="Tendons stretch: a second pass.")] = False,
    pennation: Annotated[bool, typer.Option("--pennation", help="Angles of fibres count; OpenSim omits some.")] = False,
    exact_rates: Annotated[bool, typer.Option("--exact-rates", help="Of knees, where OpenSim's are not.")] = False,
    model_forces: ModelForces = False,
    on: Annotated[str, typer.Option(help="Body that joints act on: child or parent.")] = "child",
    frame: Annotated[str, typer.Option(help="Axes of joint reactions: child, parent or ground.")] = "child",
    window: Annotated[float, typer.Option(metavar="SECONDS", help="Over which tracked excitations stay.")] = 0.015,
    no_reserves: Annotated[
        bool, typer.Option("--no-reserves", help="Muscles alone follow the motion; reserves are only told.")
    ] = False,
    no_residuals: Annotated[bool, typer.Option("--no-residuals", help="Nothing holds the root meanwhile.")] = False,
    ground: Annotated[bool, typer.Option("--ground", help="The ground carries what follows, not --loads.")] = False,
    sto: Annotated[Path | None, typer.Option("--sto", help="Folder for .sto files with OpenSim's names.")] = None,
    output: Annotated[Path | None, typer.Option("--output", "-o", help="HDF5 file of all trials.")] = None,
    report: Annotated[
        Path | None, typer.Option("--report", help=".html page: curves beside people's, residuals beside limits.")
    ] = None,
    device: Device = None,
    trust: Trust = False,
) -> None:
    """Find moments, muscle forces and joint reactions of recorded motions, of many trials at once.

    Steps: ik coordinates from markers; id generalised forces; so activations and forces of muscles by static
    optimisation; jr forces and moments in joints; track excitations with which a simulation follows the motion, as by
    computed muscle control, with --ground on a simulated ground. Examples: warpmuscle inverse model.osim walk.mot
    --loads loads.xml -o result.h5; warpmuscle inverse model.osim a.sto b.sto --loads a_grf.mot --loads b_grf.mot
    --filter 6 --sto out
    """
    _check_outputs(output, report, sto)
    start_warp()
    from warpmuscle.inverse.activations import ActivationOptions
    from warpmuscle.inverse.as_opensim.differences import choices
    from warpmuscle.inverse.body_model import BodyModel
    from warpmuscle.inverse.steps import frames_of, run_steps, steps_of

    wanted = steps_of(steps)
    options = ActivationOptions(
        power=power, weight=_weight(weight), physiology=not isometric, passive=passive, pennation=pennation,
        reserve=reserves_of(reserve or []), emg_weight=emg_weight if emg else 0.0, rates=rates, elastic=elastic,
    )  # fmt: skip
    with _notes(), log.status("reading") as shown:
        body = BodyModel(model, device, trust=trust, model_forces=model_forces)
        fitted, trials = read_motions(motions, body, setup, device, up, forward)
        predicted = predicted_loads(body, trials, loads, filter) if no_plates else None
        forces = predicted or read_all_loads(loads or [], motions, up, forward, wanted != ("ik",))
        signals = read_all_emg(emg or [], len(motions), body, channel or [])
        times = [frames_of(trial, begin, end, every) for trial in trials]
        shown.update("computing; kernels that are new are compiled first")
        found = run_steps(
            body, wanted, list(map(_name, motions)), trials, forces, filter=filter, times=times, emg=signals,
            options=options, on=on, frame=frame, recorded=output is not None, fitted=fitted, exact_rates=exact_rates,
            tracking=_tracking(options, window, not no_reserves, not no_residuals, ground),
        )  # fmt: skip
        about = _about(model, wanted, options, filter)
        about |= dict(
            choices(body, wanted, trials, forces, times, filter=filter, options=options, exact_rates=exact_rates)
        )
    _give(found, output, sto, about, body)
    _page(report, body, found, forces, signals, about)


def _about(model: str, steps: Sequence[str], options: ActivationOptions, cutoff: float | None) -> dict[str, str]:
    """How a result was made, as attributes of its file."""
    about = {"command": command_line(), "model": model, "steps": ",".join(steps)}
    return about | {"options": json.dumps(vars(options)), "filter": "none" if cutoff is None else f"{cutoff:g} Hz"}


def _name(motion: Path) -> str:
    return readable(motion.stem)


def _tracking(
    options: ActivationOptions, window: float, reserves: bool, residuals: bool, ground: bool
) -> TrackingOptions:
    """Options of tracking, whose reserves are as strong as those of static optimisation."""
    from warpmuscle.inverse.tracking.tracker import TrackingOptions

    strength = options.reserve if isinstance(options.reserve, float) else options.reserve[""]
    return TrackingOptions(window, reserve=strength, reserves=reserves, residuals=residuals, ground=ground)


def _weight(word: str) -> str:
    if word not in ("none", "volume"):
        raise Error(f"--weight is none or volume, not {word!r}")
    return word.replace("none", "")


def _check_outputs(output: Path | None, path: Path | None, sto: Path | None) -> None:
    """Say now, rather than after the work, that a file, a page or tables in a folder cannot be made."""
    from warpmuscle.core.extras import check_report

    writable(output)
    writable_folder(sto, "--sto")
    if path is None:
        return
    check_report(path)


def _page(
    path: Path | None, body: BodyModel, found: list[Trial], loads: list[Loads | None], emg: list[Emg | None],
    about: dict[str, str],
) -> None:  # fmt: skip
    """Write the page of a subject, if one is asked for."""
    if path is None:
        return
    from warpmuscle.core.files import replace_file
    from warpmuscle.report.subject_page import subject_html

    with _notes(), log.status("drawing") as shown:
        page = subject_html(body, found, loads, emg, list(about.items()), lambda what: shown.update(f"drawing: {what}"))
    replace_file(path, page)
    out.print(f"wrote {path}", markup=False)


def _give(found: list[Trial], output: Path | None, sto: Path | None, about: dict[str, str], body: BodyModel) -> None:
    """Tell what was found, and write it."""
    from warpmuscle.inverse.output import write_result, write_storages

    for trial in found:
        _tell(trial)
        _tell_tracked(trial)
    for name in CHOICES:
        if name in about:
            out.print(about[name], markup=False)
    if output is not None:
        write_result(output, found, about, body)
        out.print(f"wrote {output}: {number_of(len(found), 'trial')}", markup=False)
    if sto is not None:
        out.print(f"wrote {number_of(len(write_storages(sto, found)), 'file')} to {sto}", markup=False)
    if output is not None:
        suggest(
            f"`warpmuscle report {shlex.quote(str(output))} -o page.html` draws it, `warpmuscle view` shows the motion"
        )


class _notes(warnings.catch_warnings):
    """Prints what is warned of within as notes, each once."""

    def __enter__(self) -> None:
        super().__enter__()
        from warpmuscle.scene.validation.muscles import SceneWarning

        printed: set[str] = set()

        def show(message: Warning | str, *_: Any) -> None:
            if str(message) not in printed:
                printed.add(str(message))
                log.print(f"note: {message}", markup=False)

        warnings.simplefilter("always", UserWarning)
        warnings.simplefilter("ignore", SceneWarning)  # of free runs, which nothing here is
        warnings.showwarning = show  # type: ignore[assignment]


def _tell(trial: Trial) -> None:
    """A few lines about a trial: residuals, reserves that are too great, frames that did not converge."""
    import numpy as np

    moments = trial.moments or (trial.activations.moments if trial.activations is not None else None)
    if moments is None:
        return
    parts = []
    for unit in ("N", "N m"):
        own = [k for k in range(moments.residuals) if moments.units[k] == unit]
        if own:
            worst = max(own, key=lambda k: float(np.abs(moments.values[:, k]).max()))
            parts.append(f"{np.abs(moments.values[:, worst]).max():.3g} {unit} ({moments.names[worst]})")
    line = f"{trial.name}: {number_of(len(moments.times), 'frame')}"
    out.print(line + (f", residuals up to {' and '.join(parts)}" if parts else ""), markup=False)
    if trial.activations is None:
        return
    lost = trial.activations.unconverged
    if lost:
        out.print(f"  {number_of(len(lost), 'frame')} did not converge: {_listed(lost)}", markup=False)
    flagged = trial.activations.flagged()
    if flagged:
        by_name = Counter(name for _, name, _ in flagged)
        worst_frame = max(flagged, key=lambda one: one[2])
        most = [f"{name} ({number_of(count, 'frame')})" for name, count in by_name.most_common(SHOWN)]
        out.print(
            f"  reserves of {', '.join(most)} "
            f"exceed 5 % of the peak moment, most {worst_frame[1]} by {worst_frame[2]:.0%} at "
            f"{trial.activations.times[worst_frame[0]]:.3g} s",
            markup=False,
        )


def _tell_tracked(trial: Trial) -> None:
    """A few lines about a simulation that follows a trial: how far it is from it, and what acted beside muscles."""
    import numpy as np

    one = trial.tracked
    if one is None:
        return
    parts = []
    for unit, factor, word in (("rad", 180.0 / math.pi, "degrees"), ("m", 1000.0, "mm")):
        own = [k for k, other in enumerate(one.units) if other == unit]
        if own:
            worst = max(own, key=lambda k: float(one.rms[k]))
            parts.append(f"{factor * one.rms[worst]:.3g} {word} RMS ({one.names[worst]})")
    windows = number_of(len(one.excitation), "window")
    out.print(f"{trial.name}: followed over {windows} to {' and '.join(parts)} at most", markup=False)
    pushed = [k for k in np.argsort(-one.greatest_effort) if one.greatest_effort[k] > NOTED]
    for what, some in (("at the root", [k for k in pushed if k < one.residuals]),
                       ("beside muscles", [k for k in pushed if k >= one.residuals])):  # fmt: skip
        if some:
            units = ["N m" if one.units[k] == "rad" else "N" for k in some]
            most = [
                f"{one.greatest_effort[k]:.3g} {unit} ({one.names[k]})" for k, unit in zip(some, units, strict=True)
            ]
            out.print(f"  forces {what}: up to {', '.join(most[:SHOWN])}", markup=False)
    if one.ground is not None:
        _tell_ground(one.ground)


def _tell_ground(ground: GroundRun) -> None:
    """A few lines about the ground that carries a simulation: where it lies, and its forces beside the plates'."""
    import numpy as np

    belt, lift = float(np.linalg.norm(ground.belt)), 1000.0 * ground.lift
    moved = f", walking ahead at {belt:.2f} m/s, the speed of the belt" if belt else ""
    out.print(f"  on the ground, moved upwards by {lift.min():.0f} to {lift.max():.0f} mm{moved}", markup=False)
    up = ground.force_error[:, 1]
    out.print(
        f"  nothing acts at the root; the ground pushes upwards with {up[0]:.0f} and {up[1]:.0f} N RMS of difference "
        f"from plates, left and right, of which the greatest is {ground.plates[..., 1].max():.0f} N",
        markup=False,
    )


def _listed(frames: list[int]) -> str:
    """Some of a list of frames, counted from 1."""
    return ", ".join(str(frame + 1) for frame in frames[:SHOWN]) + (", ..." if len(frames) > SHOWN else "")
