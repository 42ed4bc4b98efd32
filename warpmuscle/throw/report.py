"""What fits came to: as rows of text for people, and as HDF5 for programs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.hdf5_writing import store
from warpmuscle.core.number_rows import first_number
from warpmuscle.core.plain_text import number_of
from warpmuscle.formats import toml
from warpmuscle.results.records import Result, parameter_table
from warpmuscle.results.result import THROW_FORMAT, write_extended
from warpmuscle.scene.parameters import free_parameters, start_values, substitute, with_values
from warpmuscle.simulation.devices import find_device
from warpmuscle.throw.arm import Arm
from warpmuscle.throw.fit import Fitted, Stage
from warpmuscle.throw.follow import Follower
from warpmuscle.throw.measured import Calibration
from warpmuscle.throw.metrics import Agreement, leave_one_out
from warpmuscle.throw.published import Published
from warpmuscle.throw.replays import fitted_replays, published_replay, put_throws
from warpmuscle.throw.synthesis import Throw

# Shoulder, elbow and wrist in Cruz Ruiz 2015, sections 3.3 and 3.4; its first wrist is only said to be negative.
PAPER = {"parameters": ("0.897", "0.890", "< 0"), "signals": ("0.927", "0.942", "0.814")}


@dataclass(frozen=True)
class TableRow:
    """A line of a table."""

    name: str
    cells: tuple[str, ...]


def published_rows(result: Published) -> list[TableRow]:
    """r2 by joint after each stage of the published procedure: median, and worst of all motions."""
    rows = []
    for stage in result.stages:
        cells = [
            f"{middle:.3f} ({worst:.3f})" if len(stage.r2) > 1 else f"{middle:.3f}"
            for middle, worst in zip(*_spread(stage.r2), strict=True)
        ]
        rows.append(TableRow(stage.name, (*cells, f"{stage.seconds:.1f} s")))
    return rows


def stage_rows(stages: Sequence[Stage], held_out: Sequence[int]) -> list[TableRow]:
    """What each stage of the better fit came to."""
    rows = []
    for stage in stages:
        a = stage.agreement
        good = a.good()
        cells = [f"{middle:.4f}" for middle in np.median(a.r2, axis=0)]
        cells += [f"{a.r2.min():.4f}", f"{np.median(a.velocity_r2.min(axis=1)):.3f}", f"{a.velocity_r2.min():.3f}"]
        cells += [f"{100.0 * np.median(a.hand_error):.1f} ({100.0 * a.hand_error.max():.1f})"]
        cells += [f"{np.nanmedian(a.correlation):.3f} ({np.nanmin(a.correlation):.3f})"]
        cells += [f"{good.sum()}/{len(good)}"]
        if held_out:
            cells += [f"{good[list(held_out)].sum()}/{len(held_out)}"]
        rows.append(TableRow(stage.name, (*cells, f"{stage.seconds:.1f} s")))
    return rows


def number_row(follower: Follower, fitted: Fitted) -> TableRow:
    """What a fit with so many synergies came to."""
    a, synergies = fitted.agreement, follower.synergies
    good = a.good()
    share = float((synergies.weights.max(axis=0) / synergies.weights.sum(axis=0)).max())
    cells = [f"{synergies.explained:.4f}", f"{share:.2f}", *(f"{middle:.4f}" for middle in np.median(a.r2, axis=0))]
    cells += [f"{a.r2.min():.4f}", f"{a.velocity_r2.min():.3f}", f"{100.0 * a.hand_error.max():.1f}"]
    cells += [f"{np.nanmin(a.correlation):.3f}", f"{good.sum()}/{len(good)}"]
    return TableRow(f"{number_of(synergies.count, 'synergy')}", tuple(cells))


def synergy_rows(agreement: Agreement) -> list[TableRow]:
    """Correlations of each synergy's fitted signal with the extracted one, and with those of other motions.

    Medians over motions, the least, and by how much the first exceeds the second: median, and least.
    """
    rows = []
    for k in range(agreement.by_synergy.shape[1]):
        individual = agreement.by_synergy[:, k]
        if not np.isfinite(individual).any():
            continue
        cells = [f"{np.nanmedian(individual):.3f} ({np.nanmin(individual):.3f})"]
        if agreement.null_by_synergy is not None and np.isfinite(agreement.lead[:, k]).any():
            lead = agreement.lead[:, k]
            cells += [f"{np.nanmedian(agreement.null_by_synergy[:, k]):.3f}"]
            cells += [f"{np.nanmedian(lead):+.3f} ({np.nanmin(lead):+.3f})"]
        else:
            cells += ["-", "-"]
        rows.append(TableRow(f"w{k + 1}", tuple(cells)))
    return rows


def calibration_rows(arm: Arm, found: Calibration) -> list[TableRow]:
    """Each channel's gain and delay, and its muscle's strength and slack length before and after.

    Of a muscle on pulleys it is the rest length of the path that stands for the slack length: one more, the other less.
    """
    muscles = arm.scene.character.muscles
    plain = [substitute(arm.scene, values).character.muscles
             for values in (start_values(arm.scene), arm.values(found.unknowns))]  # fmt: skip
    lines = []
    for k, name in enumerate(found.muscles):
        f_max = [first_number(table[name].f_max) for table in plain]
        slack = [first_number(table[name].l_slack) for table in plain]
        if muscles[name].rest_length is not None:
            rest = [first_number(table[name].rest_length) for table in plain]
            slack[1] -= rest[1] - rest[0]
        cells = (f"{found.gain[k]:.2f}", f"{1000.0 * found.delay[k]:+.0f}", f"{f_max[0]:.0f}", f"{f_max[1]:.0f}",
                 f"{1000.0 * slack[0]:.0f}", f"{1000.0 * slack[1]:.0f}")  # fmt: skip
        lines.append(TableRow(name, cells))
    return lines


def baseline_row(follower: Follower) -> TableRow | None:
    """The mean of the other motions in place of each; None of a single motion."""
    motions, free = follower.motions, follower.arm.free
    if len(motions) < 2:
        return None
    r2 = leave_one_out(motions.angles[0][:, :, free], motions.valid)
    return TableRow("mean of the others", (*(f"{v:.4f}" for v in np.median(r2, axis=0)), f"{r2.min():.4f}"))


def _spread(values: Floats) -> tuple[Floats, Floats]:
    return np.median(values, axis=0), values.min(axis=0)


AGREEMENT = {  # further axes of what `metrics.Agreement` has, and what it is
    "r2": (", joint", "coefficient of determination of the angles"),
    "velocity_r2": (", joint", "coefficient of determination of the speeds"),
    "hand_error": ("", "greatest distance of the hand's tip from where it was recorded"),
    "correlation": ("", "of the fitted with the extracted signals, of all synergies together"),
    "by_synergy": (", synergy", "the same of each synergy; 0 where one of the two does not change"),
    "null": ("", "correlation with the extracted signals of another motion"),
    "null_by_synergy": (", synergy", "the same of each synergy"),
}


def write(
    path: str | Path,
    follower: Follower,
    fitted: Fitted | None,
    published: Published | None,
    training: Sequence[int],
    attributes: Mapping[str, Any],
    throws: Sequence[Throw] = (),
    quantities: Sequence[str] | None = None,
    single: bool = False,
) -> None:
    """Write fits as HDF5, whole or not at all.

    `/scene`, `/parameters` and `/replay` are as in other results (see `results.result`): the scene with the fitted
    parameters, every fitted motion with the recorded one as its `joint_target`, and new throws behind them; of the
    published fit alone, which has parameters for each motion, the first. Besides, `/motions`: names, time, recorded
    angles and speeds; `/synergies`: W and extracted C; `/fit`: parameters, the scene with them, knots, C, simulated
    angles and speeds, and what each stage came to; `/published`: the same of that
    one; `/throws`: goals, releases, flights and landings of new throws.

    Args:
        quantities: those of `/replay` that are kept, all by default. single: whether they are in single precision.

    Raises:
        ResultError: the file cannot be written; nothing is left behind then.
    """

    def add(file: Any) -> None:
        _put_recorded(file, follower, training)
        if fitted is not None:
            _put_fit(file.create_group("fit", track_order=True), follower, fitted)
        if published is not None:
            _put_published(file.create_group("published", track_order=True), follower, published)
        if throws:
            put_throws(file.create_group("throws", track_order=True), throws, follower.arm.joints)

    result = _result(follower, fitted, published, attributes, throws)
    write_extended(path, result, add, kind=THROW_FORMAT, quantities=quantities, single=single)


def _result(
    follower: Follower,
    fitted: Fitted | None,
    published: Published | None,
    attributes: Mapping[str, Any],
    throws: Sequence[Throw],
) -> Result:
    """What the file holds in the layout of all results."""
    arm, scene, replays = follower.arm, follower.arm.scene, None
    if fitted is not None:
        replays = fitted_replays(follower, fitted, throws)
    elif published is not None:
        replays = published_replay(follower, published)
    if replays is not None:
        scene = with_values(scene, np.clip(replays.parameters, *_ends(arm)))
    return Result(
        scene=toml.dumps(scene),
        device=str(find_device(follower.simulator.device)),
        command=str(attributes.get("command", "")),
        seed=int(attributes.get("seed", 0)),
        parameters=parameter_table(free_parameters(scene)),
        replays=replays.motions if replays is not None else (),
        replay_names=replays.names if replays is not None else (),
    )


def _put_recorded(file: Any, follower: Follower, training: Sequence[int]) -> None:
    motions, arm, synergies = follower.motions, follower.arm, follower.synergies
    fitted, series = np.isin(np.arange(len(motions)), training), "motion, sample, joint"
    group = file.create_group("motions", track_order=True)
    store(group, "names", tuple(motions.names), axes="motion", description="recorded motions")
    store(group, "joints", tuple(arm.joints), axes="joint", description="joints that were recorded")
    store(group, "driven", tuple(arm.driven), axes="driven joint", description="joints that muscles move")
    store(group, "fitted", fitted, axes="motion", description="whether parameters were fitted to it")
    store(group, "time", motions.time, "s", "sample", description="of the samples, from the begin of each motion")
    store(
        group, "valid", motions.valid > 0.0, axes="motion, sample",
        description="whether a motion has the sample, or has ended",
    )  # fmt: skip
    store(group, "angle", motions.angles[0], "rad", series, description="recorded angles of the joints")
    store(group, "speed", motions.angles[1], "rad/s", series, description="recorded speeds of the joints")
    group = file.create_group("synergies", track_order=True)
    store(group, "muscles", tuple(arm.muscles), axes="muscle", description="muscles that synergies excite")
    store(
        group, "W", synergies.weights, axes="muscle, synergy",
        description="weight of each muscle in each synergy, as extracted",
    )  # fmt: skip
    store(
        group, "C", synergies.signals, axes="motion, sample, synergy",
        description="signals of the synergies, as extracted",
    )  # fmt: skip
    group.attrs["source"], group.attrs["vaf"] = synergies.source, synergies.explained


def _put_fit(group: Any, follower: Follower, fitted: Fitted) -> None:
    arm, series = follower.arm, "motion, sample, joint"
    values = arm.values(fitted.unknowns)
    group.attrs["scene"] = toml.dumps(with_values(arm.scene, np.clip(values, *_ends(arm))))
    _put_parameters(group, arm, values, "parameter", "fitted parameters of the scene")
    store(group, "knots", follower.knots.time, "s", "knot", description="times of the knots of the fitted signals")
    individual = follower.shaped(fitted.individual)
    store(
        group, "knot_values", individual, axes="motion, synergy, knot",
        description="fitted signals of the synergies at the knots",
    )  # fmt: skip
    store(
        group, "start", fitted.individual[:, -follower.synergies.count :], axes="motion, synergy",
        description="signals that the activations start by",
    )  # fmt: skip
    store(
        group, "C", follower.knots.sampled(individual), axes="motion, sample, synergy",
        description="fitted signals of the synergies",
    )  # fmt: skip
    store(group, "angle", fitted.replay.angle, "rad", series, description="angles of the joints as simulated")
    store(group, "speed", fitted.replay.speed, "rad/s", series, description="speeds of the joints as simulated")
    _put_stages(group, fitted.stages, "stages of the fit")
    names = ["r2", "velocity_r2", "hand_error", "correlation", "by_synergy"]
    names += ["null", "null_by_synergy"] if fitted.agreement.null is not None else []
    for name in names:
        axes, description = AGREEMENT[name]
        found = np.nan_to_num(np.stack([getattr(stage.agreement, name) for stage in fitted.stages]))
        unit = "m" if name == "hand_error" else "1"
        store(group, name, found, unit, f"stage, motion{axes}", description=description)
    simulations = np.array([stage.simulations for stage in fitted.stages])
    store(group, "simulations", simulations, axes="stage", description="motions that each stage simulated")


def _put_published(group: Any, follower: Follower, published: Published) -> None:
    arm = follower.arm
    values = arm.values(published.unknowns)
    _put_parameters(group, arm, values, "motion, parameter", "parameters of the scene, of each motion its own")
    store(
        group, "C", published.signals, axes="motion, sample, synergy",
        description="signals of the synergies after the filter",
    )  # fmt: skip
    store(
        group, "angle", published.replay.angle, "rad", "motion, sample, joint",
        description="angles of the joints as simulated",
    )  # fmt: skip
    _put_stages(group, published.stages, "stages of the procedure")
    axes, description = AGREEMENT["r2"]
    r2 = np.stack([stage.r2 for stage in published.stages])
    store(group, "r2", r2, axes=f"stage, motion{axes}", description=description)


def _put_parameters(group: Any, arm: Arm, values: Floats, axes: str, description: str) -> None:
    """Values of the arm's free parameters, with their paths and units."""
    store(group, "parameters", values, "see parameter_units", axes, description=description)
    for name, text in {"name": "paths of the parameters in the scene", "unit": "units of the parameters"}.items():
        texts = tuple(getattr(parameter, name) for parameter in arm.parameters)
        store(group, f"parameter_{name}s", texts, axes="parameter", description=text)


def _put_stages(group: Any, stages: Sequence[Any], description: str) -> None:
    """Names of the stages of a fit, and how long each took."""
    store(group, "stages", tuple(stage.name for stage in stages), axes="stage", description=description)
    seconds = np.array([stage.seconds for stage in stages])
    store(group, "seconds", seconds, "s", "stage", description="wall time that each stage took")


def _ends(arm: Arm) -> tuple[Floats, Floats]:
    return np.array([p.min for p in arm.parameters]), np.array([p.max for p in arm.parameters])
