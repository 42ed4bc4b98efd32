"""Figures of results; they need matplotlib, the extra `plot` of the package.

A kind of figure is a small file with a function `draw(subject)` that gives a matplotlib figure, and a line in `KINDS`.

May import: studies and all below.
To add: a figure as said above.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

from warpmuscle.core.arguments import answering, as_path, as_text, as_texts, as_truth, in_words
from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import ArgumentError, Error
from warpmuscle.core.plain_text import number_of
from warpmuscle.formats import SceneLike, scene_names, scene_of
from warpmuscle.plots import (
    activation,
    angles,
    columns,
    convergence,
    dataset,
    feet,
    ground_force,
    joints,
    moment_arms,
    moments,
    muscle_control,
    one_curve,
    overlay,
    parameters,
    stick_figures,
)
from warpmuscle.plots.names import FEW, curves_named, kind_named, without_side
from warpmuscle.plots.overlay import OVERLAYS
from warpmuscle.plots.style import check_picture, save, style
from warpmuscle.plots.subject import Absent, Choices, Subject, of_recording
from warpmuscle.results.holders import HasRecordings, HasResult
from warpmuscle.results.recording import Recording
from warpmuscle.results.records import Result
from warpmuscle.results.result import read
from warpmuscle.scene import Scene
from warpmuscle.scene.validation.checks import near

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["KINDS", "Absent", "Choices", "Kind", "Subject", "check_kind", "draw", "draw_over", "plot", "save"]


class HasTimes(Protocol):
    """A table over time, such as inverse dynamics gives."""

    @property
    def times(self) -> Floats:
        """(F,) s."""


Source = Result | Recording | HasResult | HasRecordings | HasTimes | str | Path
ARGUMENTS = {
    **dict.fromkeys(("save", "savefig", "output", "file", "filename"), "path='hip.png' writes the figure"),
    **dict.fromkeys(
        ("title", "ax", "show", "figsize", "color", "xlim", "ylim", "label", "legend", "lw", "style", "dpi"),
        "plot returns a figure of matplotlib: fig.axes[0], fig.savefig('hip.png', dpi=300)",
    ),
    **dict.fromkeys(("x", "y", "name", "curve", "quantity", "what"), "the second argument names the curve"),
}
DATASET = "dataset:"  # before the path of a dataset, in place of a kind
RECORDED = "objects.", "ground.treadmill."  # what names of quantities begin with that motions have curves of


class Kind(NamedTuple):
    """A kind of figure."""

    draw: Callable[[Subject], Any]
    description: str


KINDS: dict[str, Kind] = {
    "sticks": Kind(stick_figures.draw, "stick figures over time, from the side and the front"),
    "angles": Kind(angles.draw, "hip, knee and ankle over the gait cycle beside the norm"),
    "ground_force": Kind(ground_force.draw, "ground forces over the gait cycle in body weights"),
    "moments": Kind(moments.draw, "moments and powers of hip, knee and ankle over the gait cycle beside people's"),
    "body": Kind(moments.draw_body, "pelvis, trunk, fore-aft force and centre of pressure over the gait cycle"),
    "feet": Kind(feet.draw, "the feet frame by frame at touch-down and toe-off"),
    "activation": Kind(activation.draw, "muscle activations over the gait cycle, or over time"),
    "control": Kind(muscle_control.draw, "desired torque, excitation and activation about a joint"),
    "joints": Kind(joints.draw, "angles of all joints over time"),
    "moment_arms": Kind(moment_arms.draw, "moment arms of muscles over joint angles"),
    "convergence": Kind(convergence.draw, "cost over the candidates of a search, and their spread"),
    "parameters": Kind(parameters.draw, "candidates of a search between the bounds of each parameter"),
}


@answering(ARGUMENTS)
def plot(
    source: Source | Sequence[Source],
    kind: str | Sequence[str] = "",
    path: str | Path | None = None,
    *,
    scene: SceneLike | None = None,
    joints: Sequence[str] = (),
    muscles: Sequence[str] = (),
    norms: bool = True,
    replay: int = 0,
    start: float | None = None,
    end: float | None = None,
    run: str | None = None,
) -> Figure:
    """Draw a figure, and write it if a file is named.

    Args:
        source: a result, a run, or the path of its HDF5 file, or a recording, of which `scene` made it; a rollout, all
            of whose recorded motions are drawn; or a list of these, to be drawn over one another where the kind is a
            curve or one of `overlay.OVERLAYS`. Or a table over time, such as moments of inverse dynamics.
        kind: one of `KINDS`; or `dataset:` and the path of a dataset in a file; or the name of a curve, such as `hip
            flexion`, `knee moment`, a degree of freedom or a muscle, or a list of curves, see `one_curve`. By default
            the angles of a walk over the gait cycle, those of other motions over time, the convergence of a search
            without a motion, and all of a table.
        path: file to write; its ending (.png, .svg, .pdf) chooses the format.
        scene: of a recording that does not know it, or its name or file; free parameters count with their start values.
        joints: names or patterns such as `l*` of what is shown, by default all. muscles: the same.
        norms: whether norms of human walking are drawn.
        replay: number of the motion.
        start: s, of the part of the motion that counts. end: s.
        run: name of a run in the file of a sweep.

    Returns:
        The figure, which notebooks show.

    Raises:
        Absent: the source does not hold what the kind shows.
        Error: matplotlib is not installed, an unknown kind or choice, or a file cannot be read or written.
    """
    several = as_texts(kind, "kind") if isinstance(kind, list | tuple) and kind else ()
    only = several[0] if several else as_text(kind, "kind")
    picture = None if path is None else as_path(path, "path")
    if picture is not None:
        if not picture.suffix and only:
            raise Error(
                f"path must be the name of a picture, not {str(path)!r}; a list draws several: {[only, str(path)]}"
            )
        check_picture(picture)
    choices = Choices.between(
        replay, start, end, joints=as_texts(joints, "joints"), muscles=as_texts(muscles, "muscles"),
        norms=as_truth(norms, "norms"),
    )  # fmt: skip
    sources = list(source) if isinstance(source, list | tuple) else [source]
    if not sources:
        raise Error("source must be a result, a recording, the path of a file, or a list of these, not an empty list")
    if len(sources) == 1 and (table := columns.columns_of(sources[0])) is not None:
        drawn = columns.draw(table, several or [only] if only else [])
        if picture is not None:
            save(drawn, picture)
        return drawn  # type: ignore[no-any-return]
    subjects = [_subject(one, choices, scene, run) for given in sources for one in _each(given)]
    only = only or _usual(subjects[0])
    if len(several) > 1 and len(subjects) > 1:
        raise Error("a list of curves is drawn of one result at a time")
    figure: Figure
    try:
        figure = draw_curves(subjects[0], several) if len(several) > 1 else draw_over(subjects, only)
    except Error as error:
        if several:
            raise type(error)(f"kind: {error}") from None
        raise
    if picture is not None:
        save(figure, picture)
    return figure


def _each(source: Any) -> list[Any]:
    """The recorded motions of a rollout; or what else is given, alone."""
    if not isinstance(source, HasRecordings):
        return [source]
    if not source.recorded_instances:
        raise Error("this rollout has recorded nothing to draw: name instances in Rollout(..., record=[0])")
    return [source.recording(one) for one in source.recorded_instances]


def _usual(subject: Subject) -> str:
    """The kind that is drawn where none is named."""
    if not subject.result.replays and subject.result.evaluations is not None:
        return "convergence"
    return "angles" if not subject.result.replays or subject.walks else "joints"


def _subject(source: Any, choices: Choices, scene: SceneLike | None, run: str | None) -> Subject:
    """What is drawn of one source; see `plot`."""
    file = None
    if isinstance(source, Recording):
        made = scene if scene is not None or source.origin is None else source.origin()
        if made is None:
            raise Error("a recording is drawn with its scene: plot(recording, kind, scene=scene)")
        result = of_recording(source, scene_of(made))
    elif isinstance(source, Result):
        result = source
    elif isinstance(source, HasResult):
        result = source.result
    else:
        if isinstance(source, Scene) or (isinstance(source, str) and source in scene_names()):
            named = repr(source) if isinstance(source, str) else "scene"
            raise Error(f"a scene is simulated before it is drawn: wm.simulate({named}).plot()")
        if not isinstance(source, str | PathLike):
            kinds = "a run, a result or its file, a recording, a rollout, or a table over time"
            raise ArgumentError(f"source must be {kinds}, not {in_words(source)}")
        file = as_path(source, "source")
        result = read(file, run, replay=choices.replay)
    return Subject(result, choices, file, run)


def draw_over(subjects: Sequence[Subject], kind: str) -> Any:
    """The matplotlib figure of several results over one another; of one alone as `draw`.

    Raises:
        Absent: a result does not hold what the kind shows. Error: a kind that shows one result only.
    """
    if len(subjects) == 1:
        return draw(subjects[0], kind)
    kind = kind_named(kind, KINDS)
    if kind not in KINDS and not kind.startswith((DATASET, *RECORDED)):
        names = {_curve_named(subject, kind).strip().lower() for subject in subjects}
        if len(names) > 1:
            raise Error(f"{kind!r} is another curve in each result: {', '.join(sorted(names))}")
        with style():
            return overlay.curve(subjects, names.pop())
    if kind not in OVERLAYS:
        raise Error(f"{kind} shows one result at a time; over one another there are {', '.join(OVERLAYS)}, and curves")
    with style():
        return OVERLAYS[kind](subjects)


def check_kind(kind: str) -> None:
    """Raise Error, which lists what there is, for an unknown kind."""
    if kind not in KINDS and not kind.startswith((DATASET, *RECORDED)):
        hint = near(kind, KINDS)
        listed = " There are" if hint else "; there are"
        raise Error(f"no figure is called {kind!r}{hint}{listed} {', '.join(KINDS)}, {DATASET}/PATH")


def draw(subject: Subject, kind: str) -> Any:
    """The matplotlib figure of a kind, or of a dataset by `dataset:` and its path in the subject's file.

    Raises:
        Absent: the result does not hold what the kind shows.
        Error: matplotlib is not installed, an unknown kind or curve, or a choice that the result does not have.
    """
    with style():
        if kind.startswith(DATASET):
            return dataset.draw(subject, kind.removeprefix(DATASET))
        if (known := kind_named(kind, KINDS)) in KINDS:
            return KINDS[known].draw(subject)
        return one_curve.draw(subject, [_curve_named(subject, kind)])


def curve_of(result: Result, name: str, beside: Sequence[str] = ()) -> tuple[str, str, dict[str, Floats]]:
    """A curve of the first motion of a result over time, by a name as `plot` takes it.

    Args:
        beside: what else there is to choose from, for messages.

    Returns:
        Its name, its unit, and a line (F,) by "", or one of each side by "left" and "right".

    Raises:
        Error: none is called so, or several are.
    """
    subject = Subject(result, Choices())
    curves = one_curve.over_time(subject)
    names = [title for title, _, _ in curves.values()]
    try:
        return curves[_curve_named(subject, name, beside, "quantity", names).lower()]
    except Error as error:
        rest, side = without_side(name)
        found = curves_named(rest, names) if side else []
        title, unit, lines = curves[found[0].lower()] if len(found) == 1 else ("", "", {})
        if side not in lines:
            raise error from None
        return f"{title}, {side}", unit, {"": lines[side]}


def draw_curves(subject: Subject, names: Sequence[str]) -> Any:
    """The matplotlib figure of several curves below one another; see `draw` for what it raises."""
    with style():
        return one_curve.draw(subject, [_curve_named(subject, name) for name in names])


def _curve_named(
    subject: Subject, name: str, beside: Sequence[str] = (*KINDS,), what: str = "figure", known: Sequence[str] = ()
) -> str:
    """The curve of a motion that a name means; raises Error, which lists what there is, for none, or for several.

    Args:
        known: names of the curves; by default all that figures show.
    """
    try:
        curves = list(known) or one_curve.curve_names(subject)
    except Absent:
        if what == "figure":
            check_kind(name)
        raise
    found = curves_named(name, curves)
    if len(found) > 1:
        some = ", ".join(map(repr, found[:FEW])) + (", ..." if len(found) > FEW else "")
        raise Error(f"{number_of(len(found), 'curve')} are called {name!r}; name one of {some}")
    if not found:
        also = ["and curves: "] if beside else ["curves: "]
        few = ", ".join(curves[:12]) + (", ..." if len(curves) > 12 else "")
        hint = near(name, [*beside, *curves])
        rest, side = without_side(name)
        if side and curves_named(rest, curves):
            hint = f"; {rest!r} shows both sides, run[{name!r}] is one."
        listed = " There are" if hint else "; there are"
        raise Error(f"no {what} is called {name!r}{hint}{listed} {', '.join([*beside, *also])}{few}")
    return found[0]
