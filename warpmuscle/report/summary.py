"""What a result file says, as lines of text: outcomes, convergence, the score explained, parameters in their bounds."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.plain_text import number_of
from warpmuscle.core.status import Status
from warpmuscle.model.objective import described, weight_of
from warpmuscle.optimization.best_scene import recorded_scene, scene_in
from warpmuscle.results.learned import Learned
from warpmuscle.results.records import Evaluations, Fit, ParameterTable, Result
from warpmuscle.scene.accounting import accounting
from warpmuscle.scene.masses import mass_warnings
from warpmuscle.scene.parameters import at_start
from warpmuscle.scene.stage_scene import stage_scene

BLOCKS = "▁▂▃▄▅▆▇█"
BAR = 21  # characters between the bounds of a parameter
AT_BOUND = 0.01  # of the interval: nearer than this, a value leans on its bound
LARGEST = 5  # parts of a term that are named
CURVE = 60  # characters of a convergence curve


def report(result: Result) -> list[str]:
    """Lines about a result, in plain text."""
    lines = [f"made by: {line}" for line in result.command.splitlines()]
    lines.append(
        f"device {result.device}, seed {result.seed}, {number_of(len(result.parameters.name), 'free parameter')}"
    )
    if result.fit is not None:
        lines += ["", *fit(result.fit)]
        lines += [f"motion {number}: {name}" for number, name in enumerate(result.replay_names)]
        return lines
    if result.learned is not None:
        return [*lines, "", *learning(result.learned), *heaviness(result)]
    if result.evaluations is None or result.best is None:
        count = len(result.replays)
        return [*lines, f"no search; {number_of(count, 'motion')}", *heaviness(result)]
    lines += ["", *_candidates(result), "", *convergence(result)]
    lines += [
        "",
        *score(result),
        *heaviness(result),
        "",
        *parameters(result.parameters, np.asarray(result.best.params)),
    ]
    return lines


def fit(found: Fit) -> list[str]:
    """r2 of each joint's angle after each stage: the median of all motions, and the worst one of several."""
    count = found.r2.shape[1]
    width = max(map(len, found.stages), default=0)
    lines = [f"fit of {number_of(count, 'motion')}: r2 of {', '.join(found.joints)}{' (worst)' * (count > 1)}"]
    for name, r2, seconds in zip(found.stages, found.r2, found.seconds, strict=True):
        middle, worst = np.median(r2, axis=0), r2.min(axis=0)
        cells = [f"{m:8.4f}" + (f" ({w:.4f})" if count > 1 else "") for m, w in zip(middle, worst, strict=True)]
        lines.append(f"  {name:{width}} {' '.join(cells)}  after {seconds:.1f} s")
    return lines


def learning(learned: Learned) -> list[str]:
    """What a policy is like, and how it was learnt."""
    policy, rows = learned.policy, learned.curve
    sizes = "-".join(str(len(layer.bias)) for layer in policy.layers)
    lines = [
        f"policy: {number_of(len(policy.observation), 'observation')}, layers of {sizes}, "
        f"{number_of(len(policy.action), 'action')}"
    ]
    if len(rows["iteration"]):
        last = {name: float(values[-1]) for name, values in rows.items()}
        rate = last["decisions"] / max(last["wall_time"], 1e-9)
        lines += [
            f"{last['iteration']:.0f} iterations, {last['decisions'] / 1e6:.4g} million decisions in "
            f"{last['wall_time']:.1f} s, {rate:.0f} a second",
            f"rewards of an episode {rows['gain'][0]:.4g} {blocks(rows['gain'])} {last['gain']:.4g}",
            f"episodes last {last['upright']:.2f} s, {100.0 * last['completed']:.0f} % their whole time, at "
            f"{last['speed']:.2f} m/s",
        ]
    lines += [f"begun with {ancestor}" for ancestor in learned.ancestors]
    options = ", ".join(f"{name} {value}" for name, value in learned.options.items())
    return [*lines, f"options: {options}", *([f"ended: {learned.ended}"] if learned.ended else [])]


def _candidates(result: Result) -> list[str]:
    """How many candidates came to each end, or that only some of them were kept."""
    assert result.evaluations is not None
    if result.is_brief:
        return [f"{number_of(result.evaluated, 'candidate')}, of which the first and the best are kept"]
    return outcomes(result.evaluations)


def outcomes(evaluations: Evaluations) -> list[str]:
    """How many candidates came to each end."""
    lines = [f"{number_of(len(evaluations), 'candidate')}, {evaluations.end_time.sum():.0f} s of motion"]
    for status in Status:
        if count := int((evaluations.status == status).sum()):
            lines.append(f"  {count:7d}  {status.meaning}")
    return lines


def convergence(result: Result) -> list[str]:
    """Least cost over the candidates of all searches, and the best of each search; of each stage if there are any."""
    assert result.evaluations is not None
    searched = result.searched
    if searched is not None and result.is_brief:
        least = np.minimum.accumulate(np.r_[result.evaluations.cost[0], searched.history.best])
        return [f"lowest cost {least[0]:.6g} {curve(least)} {least[-1]:.6g}", f"ended: {searched.ended}"]
    if searched is None or not searched.stages:
        return _descent(result.evaluations, searched.ended if searched is not None else "")
    lines = []
    for number, stage in enumerate(searched.stages[: searched.stage + 1]):
        mine = result.evaluations.rows(result.evaluations.stage == number)
        count = f"{number_of(len(mine), 'candidate')}, {number_of(len(stage.free), 'parameter')}"
        lines.append(f"stage {number + 1}, {stage.name}: {count}")
        ended = searched.ended if number == searched.stage else stage.ended
        lines += [f"  {line}" for line in _descent(mine, ended)]
    waiting = ", ".join(stage.name for stage in searched.stages[searched.stage + 1 :])
    return [*lines, f"not begun: {waiting}"] if waiting else lines


def _descent(evaluations: Evaluations, ended: str) -> list[str]:
    """Convergence of candidates that have the same objective."""
    cost, search = evaluations.cost, evaluations.search
    best, lines = np.minimum.accumulate(cost), []
    if len(best) > 0:
        lines.append(f"lowest cost {best[0]:.6g} {curve(best)} {best[-1]:.6g}")
    if ended:
        lines.append(f"ended: {ended}")
    ranked = sorted((float(cost[search == k].min()), k) for k in np.unique(search) if k >= 0)
    if len(ranked) > 1:
        shown = ", ".join(f"{k}: {value:.6g}" for value, k in ranked[:8])
        lines.append(f"searches by their best: {shown}{', ...' if len(ranked) > 8 else ''}")
    return lines


def curve(values: Floats) -> str:
    """Positive falling values as a line of blocks, by their logarithm."""
    return blocks(np.log(np.maximum(values, 1e-30)))


def blocks(values: Floats) -> str:
    """Values as a line of blocks."""
    level = values[np.linspace(0, len(values) - 1, min(CURVE, len(values))).round().astype(int)]
    span = float(level.max() - level.min())
    scaled = (level - level.min()) / span if span > 0.0 else np.zeros(len(level))
    return "".join(BLOCKS[round(x * (len(BLOCKS) - 1))] for x in scaled)


@dataclass(frozen=True)
class Share:
    """A term of the objective and its part in a cost, which is their product."""

    name: str
    weight: float
    value: float
    unit: str
    description: str
    parts: Mapping[str, float] = field(default_factory=dict)  # what joints and muscles add to the value

    @property
    def largest(self) -> str:
        """Which joints or muscles add most, in words; empty if it is no sum over them."""
        total = sum(self.parts.values())
        if total <= 0.0:
            return ""
        ranked = sorted(self.parts.items(), key=lambda part: -part[1])
        shown = [f"{name} {100.0 * value / total:.0f} %" for name, value in ranked[:LARGEST]]
        if rest := ranked[LARGEST:]:
            shown.append(f"{number_of(len(rest), 'other')} {100.0 * sum(value for _, value in rest) / total:.0f} %")
        return ", ".join(shown)

    @property
    def cost(self) -> float:
        """Weight times value."""
        return self.weight * self.value


def shares(result: Result) -> tuple[str, list[Share]]:
    """The stage that the best candidate's cost is of, empty without stages, and the weighted terms that make it up.

    Terms that are not a number, as of a candidate that diverged, are left out.
    """
    assert result.best is not None
    assert result.evaluations is not None
    scene, index, of = scene_in(result), result.best.index, ""
    stage = int(result.evaluations.stage[index])
    if scene.stages:
        of = f"stage {stage + 1}, {scene.stages[stage].name}"
    scene = stage_scene(scene, stage, np.asarray(result.best.params, dtype=np.float64))
    objective = at_start(scene).objective
    found = []
    for name, value in zip(result.evaluations.term_names, result.evaluations.terms[index], strict=True):
        weight = float(np.asarray(weight_of(objective, name)))
        if weight and np.isfinite(weight * float(value)):
            term, parts = described(name), result.parts.get(name, {})
            found.append(Share(name, weight, float(value), term.unit, term.description, parts))
    return of, found


def score(result: Result) -> list[str]:
    """The best candidate's cost as the sum of its weighted terms, and who adds most to them."""
    assert result.best is not None
    of, terms = shares(result)
    lines = [f"cost of the best, candidate {result.best.index}{of and f' of {of}'}: {result.best.cost:.6g}"]
    for term in terms:
        product = f"{term.cost:12.6g} = {term.weight:g} x {term.value:.6g} {term.unit}"
        lines.append(f"  {product}  {term.name}: {term.description}")
        if term.largest:
            lines.append(f"{'':15}{term.largest}")
    if counted := energy_accounting(result, terms):
        lines.append(f"  metabolic energy by {counted}")
    return lines


def energy_accounting(result: Result, terms: Iterable[Share]) -> str:
    """How the metabolic energy among terms is counted, in words; empty where there is none."""
    if not {"metabolic", "cost_of_transport"} & {term.name for term in terms}:
        return ""
    scene = recorded_scene(result)
    names = result.replays[0].muscle_names if result.replays else tuple(scene.character.muscles)
    return accounting(scene, names)


def heaviness(result: Result) -> list[str]:
    """A line if the muscles of a result's character are too heavy for it."""
    if not result.scene:
        return []
    return [f"warning: {doubt.message}" for doubt in mass_warnings(recorded_scene(result))]


def parameters(table: ParameterTable, best: Floats) -> list[str]:
    """Each parameter's best value between its bounds, the start value marked, and whether it leans on a bound."""
    width = max(map(len, table.name), default=0)
    lines = ["parameters: start |, best o, ! on a bound"]
    for k, name in enumerate(table.name):
        log = table.scale[k] == "log"
        low, high, start, value = (float(v[k]) for v in (table.min, table.max, table.value, best))
        ends = np.log([low, high, start, value]) if log else np.array([low, high, start, value])
        span = max(float(ends[1] - ends[0]), 1e-300)
        at_start, at_best = (float(x - ends[0]) / span for x in ends[2:])
        bar = ["-"] * BAR
        bar[_place(at_start)] = "|"
        bar[_place(at_best)] = "o"
        leaning = "!" if min(at_best, 1.0 - at_best) < AT_BOUND and high > low else " "
        text = f"{name:{width}}  {low:>9.4g} [{''.join(bar)}] {high:<9.4g}{leaning} {value:.6g} {table.unit[k]}"
        lines.append(text.rstrip())
    return lines


def _place(part: float) -> int:
    return round(min(max(part, 0.0), 1.0) * (BAR - 1))
