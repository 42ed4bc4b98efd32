"""The command that fits muscles and synergies to recorded motions of an arm."""

from __future__ import annotations

from warpmuscle.cli.common import Device, Figure, Quantities, ResultFile, Single, Threads, Trust
from warpmuscle.cli.throw.options import (
    FIDELITY,
    Arm,
    Calibrate,
    Channels,
    Emg,
    Fidelity,
    FitAll,
    LowPass,
    Motions,
    Number,
    PlotEach,
    Prescribed,
    Seed,
    check_files,
    check_synergies,
    load_arm,
    pairs,
    write_files,
)
from warpmuscle.cli.throw.options import fit as fit_job
from warpmuscle.cli.throw.tables import print_fit, print_problem, tell_kept
from warpmuscle.core.interruption import INTERRUPTED


def fit(
    files: Motions,
    scene: Arm = None,
    number: Number = None,
    emg: Emg = None,
    channel: Channels = None,
    calibrate: Calibrate = False,
    low_pass: LowPass = None,
    prescribe: Prescribed = None,
    fit_all: FitAll = False,
    fidelity: Fidelity = FIDELITY,
    output: ResultFile = None,
    plot: Figure = None,
    plot_each: PlotEach = None,
    device: Device = None,
    threads: Threads = None,
    seed: Seed = 0,
    trust: Trust = False,
    quantities: Quantities = None,
    single: Single = False,
) -> int:
    """Fit an arm's muscles and synergies to recorded motions, and replay them.

    A MOTION has columns time_s and, for each joint, shoulder_deg, elbow_deg, wrist_deg (or _rad; also
    shoulder_flexion_deg and so on). Read as well, and taken to be 0 where they are missing: trunk_pitch_deg, how far
    the trunk leans forwards, or shoulder_flexion_gravity_deg, the upper arm's angle to gravity, from which that
    follows; shoulder_forward_m and shoulder_up_m, the shoulder's place.

    Exit codes: 0; 2 if an input cannot be used; 130 after Ctrl-C, with the stages that were complete written.

    Examples: warpmuscle throw fit throws/*.csv -o throw.h5; warpmuscle throw fit serve.csv --prescribe shoulder;
    warpmuscle throw fit lift.csv --emg syn.h5 --prescribe wrist
    """
    from warpmuscle.throw.job import Job, JobOptions

    check_files(output, plot, plot_each)
    check_synergies(emg, channel, calibrate, number)
    loaded = load_arm(scene or ("throw18" if emg is None else "throw"), device)
    options = JobOptions(
        count=number, prescribed=tuple(prescribe or ()), emg=emg, channels=pairs(channel), calibrated=calibrate,
        fit_all=fit_all, fidelity=fidelity, low_pass=low_pass, device=device, threads=threads, seed=seed,
    )  # fmt: skip
    job = Job(loaded, files, options)
    print_problem(job)
    interrupted = False
    try:
        fit_job(job)
        assert job.fitted is not None
        print_fit(job, job.fitted)
    except KeyboardInterrupt:
        interrupted = True
        tell_kept(job, 0)
        if job.fitted is None:
            raise
    write_files(job, output, plot, plot_each, seed, quantities, single)
    return INTERRUPTED if interrupted else 0
