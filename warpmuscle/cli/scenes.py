"""Commands about scenes: list, show, fit, convert."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from warpmuscle.cli.common import (
    Device,
    Duration,
    LimitStiffness,
    SceneFile,
    Settings,
    Sources,
    Trust,
    changed,
    command_line,
    load_scene,
    start_warp,
    writable_beside,
)
from warpmuscle.cli.console import log, marked, out, print_ignored, print_table, suggest
from warpmuscle.cli.scene_list import print_scenes
from warpmuscle.core.plain_text import number_of

if TYPE_CHECKING:
    from warpmuscle.scene import Scene


def scenes(
    words: Annotated[
        list[str] | None,
        typer.Argument(metavar="[WORD]...", help="Only scenes with all of these words in names or descriptions."),
    ] = None,
) -> None:
    """List the shipped scenes by what they are good for.

    Example: warpmuscle scenes stairs
    """
    print_scenes(words or ())


def info(sources: Sources, settings: Settings = None, trust: Trust = False) -> None:
    """Show what a scene holds: bodies, degrees of freedom, mass, muscles, free parameters.

    Points out muscles whose moment arm about a joint that they cross stays under 1 mm over its range.
    """
    from warpmuscle.scene.masses import body_mass, muscle_mass_text, total_mass
    from warpmuscle.scene.parameters import at_start, free_parameters
    from warpmuscle.scene.topology import topology

    scene = load_scene(sources, settings=settings)
    parameters = free_parameters(scene)
    numeric, names = at_start(scene), topology(scene.character)
    mass = body_mass(numeric.character)
    root = names.speed_start[1]
    out.print(marked(scene.name, "bold", f"  {scene.description}"))
    out.print(
        f"{number_of(len(names.bodies), 'body')}, {number_of(len(names.joints), 'joint')}, "
        f"{number_of(names.speeds - root, 'joint degree')} of freedom and {root} of the root, {mass:.6g} kg"
    )
    out.print(f"{scene.duration:g} s in steps of {scene.time_step:g} s, {number_of(len(parameters), 'free parameter')}")
    bodies = []
    for i, name in enumerate(names.bodies):
        joint = scene.character.joints[names.joints[i - 1]] if i > 0 else None
        row = ["-", scene.character.root_joint, "world"]
        if joint is not None:
            kind = f"follows {joint.follows}" if joint.follows else joint.type
            row = [names.joints[i - 1], kind, joint.parent]
        bodies.append((name, f"{numeric.character.bodies[name].mass:g}", *row))
    words = ("body", "joint", "type", "parent")
    print_table(("body", "mass, kg", *words[1:]), bodies, words)
    if muscles := list(numeric.character.muscles.values()):
        share = f", {100.0 * total_mass(muscles, numeric.muscle_model) / mass:.3g} % of the body" if mass > 0.0 else ""
        out.print(muscle_mass_text(muscles, numeric.muscle_model) + share, markup=False)
        _print_driven_mass(numeric)
        _print_muscles(numeric)
    width = max((len(p.name) for p in parameters), default=0)
    for p in parameters:
        step = f" step {p.step:g}" if p.step else ""
        out.print(f"{p.name:{width}}  {p.value:g}  in {p.min:g}..{p.max:g}{step} {p.unit}".rstrip(), markup=False)


def fit_muscles(
    sources: Sources,
    output: SceneFile,
    strength: Annotated[float, typer.Option(min=0.01, help="Factor on f_max.")] = 1.5,
    mean_length: Annotated[float, typer.Option(min=0.1, help="Fibre length over l_opt at the mean path length.")] = 1.0,
    fibre_per_arm: Annotated[float, typer.Option(min=0.0, help="Minimum l_opt over the mean moment arm.")] = 1.0,
    properties_only: Annotated[
        bool, typer.Option("--properties-only", help="Write f_max, l_opt and l_slack only, to add to a character.")
    ] = False,
    duration: Duration = None,
    device: Device = None,
    trust: Trust = False,
) -> None:
    """Fit the muscles of a scene to its skeleton and to the motion that it makes on torques.

    Slack lengths follow from the mean path lengths, both sides get the same properties, and f_max grows by a factor.
    Example: warpmuscle fit-muscles walk56_legacy -o fitted.toml
    """
    from warpmuscle.core.files import replace_file
    from warpmuscle.formats import save
    from warpmuscle.formats.toml_layout import layout
    from warpmuscle.studies.fit_muscles import PropertyTable
    from warpmuscle.studies.fit_muscles import fit_muscles as fit

    writable_beside(sources, output)
    scene = changed(load_scene(sources), duration, None, None)
    start_warp()
    options = {"mean_length": mean_length, "fibre_per_arm": fibre_per_arm, "strength": strength}
    with log.status("simulating on torques"):
        fitted = fit(scene, **options, device=device)
    if properties_only:
        heading = "# Properties of muscles by `" + command_line() + "`; tables to add to a character."
        replace_file(output, f"{heading}\n\n{layout(PropertyTable.of(fitted))}")
    else:
        save(fitted, output)
    out.print(f"wrote {output}")


def fit_paths(
    sources: Sources,
    output: SceneFile,
    rms: Annotated[float, typer.Option(min=1e-7, help="Largest root mean square error of the polynomials, m.")] = 1e-4,
    order: Annotated[int, typer.Option(min=1, max=20, help="The highest order to try.")] = 8,
    trust: Trust = False,
) -> None:
    """Fit polynomials of the joints' coordinates to the paths of muscles, and write the scene with them.

    Lengths are taken in random poses within the joints' limits. Example: warpmuscle fit-paths arm26.osim -o fast.toml
    """
    from warpmuscle.formats import save
    from warpmuscle.studies.fit_paths import fit_paths as fit

    writable_beside(sources, output)
    scene = load_scene(sources)
    start_warp()
    with log.status("measuring paths"):
        fitted, fits = fit(scene, rms, order)
    save(fitted, output)
    for one in fits:
        if one.rms > rms:
            out.print(
                f"{one.muscle}: misses {1e3 * one.rms:.2g} mm in the root mean square even at order {one.order}, where "
                f"--rms allows {1e3 * rms:.2g} mm, and {1e3 * one.worst:.2g} mm at most"
            )
    terms = sum(one.terms for one in fits)
    out.print(f"wrote {output}: {number_of(len(fits), 'path')} of {number_of(terms, 'term')}")


def convert(
    sources: Sources,
    output: Annotated[
        Path, typer.Option("--output", "-o", help=".toml, .osim, .xml, .par; or .rbs, .sbc, .rs for all three.")
    ],
    keyword_rule: Annotated[
        bool, typer.Option("--keyword-rule", help="Muscles drive only joints that a .rbs marks `actuationType muscle`.")
    ] = False,
    ball_joints: Annotated[
        bool, typer.Option("--ball-joints", help="Three hinges of a .osim through one point become a ball joint.")
    ] = False,
    hard_points: Annotated[
        bool, typer.Option("--hard-points", help="Paths of a .osim jump where OpenSim's do.")
    ] = False,
    limit_stiffness: LimitStiffness = 0.0,
    merge_welds: Annotated[
        bool, typer.Option("--merge-welds", help="Bodies of a .osim that are welded to others, or locked, join these.")
    ] = False,
    trust: Trust = False,
) -> None:
    """Write a scene as TOML, as the original program's files, or its character and ground for OpenSim or MuJoCo."""
    from warpmuscle.formats import Ignored, mjcf, save

    three = (".rbs", ".sbc", ".rs")
    files = [output.with_suffix(suffix) for suffix in three] if output.suffix in three else [output]
    writable_beside(sources, *files)
    scene = load_scene(
        sources, keyword_rule, ball_joints=ball_joints, hard_points=hard_points, merge_welds=merge_welds,
        limit_stiffness=limit_stiffness,
    )  # fmt: skip
    lost: list[Ignored] = []
    if output.suffix == ".xml":
        mjcf.write(scene, output)
    else:
        save(scene, output, lost)
    print_ignored(lost, "not all was written:")
    out.print(f"wrote {', '.join(map(str, files))}")
    if output.suffix == ".toml":
        rests = scene.controller is None and scene.gait_states is None
        idle = " with its muscles at rest; `excitation` moves them" if rests else ""
        suggest(f"`warpmuscle simulate {output} -o {output.stem}.h5` runs it{idle}")


def _print_driven_mass(scene: Scene) -> None:
    """Print the mass of the muscles that are simulated, whose energy counts, where that is not all of them."""
    from warpmuscle.model.muscles import driven
    from warpmuscle.scene.masses import muscle_mass_text
    from warpmuscle.scene.topology import topology

    moving, count = driven(scene, topology(scene.character)).of(scene), len(scene.character.muscles)
    if 0 < len(moving) < count:
        mass = muscle_mass_text(moving, scene.muscle_model)
        out.print(f"{len(moving)} of the {count} muscles drive joints: {mass}, whose energy counts", markup=False)


def _print_muscles(scene: Scene) -> None:
    """Print the muscles of a scene without free parameters: properties, joints, and where they cannot act."""
    from warpmuscle.model.muscles import driven
    from warpmuscle.model.path_table import joints_of_muscles
    from warpmuscle.scene.topology import topology
    from warpmuscle.studies.moment_arms import useless_muscles

    names = topology(scene.character)
    found = driven(scene, names)
    rows = []
    for name, joints in joints_of_muscles(scene.character, names).items():
        m = scene.character.muscles[name]
        numbers = [f"{number:g}" for number in (m.f_max, m.l_opt, m.l_slack, m.delay)]
        rows.append((name, *numbers, "yes" if name in found.muscles else "no", " ".join(joints) or "-"))
    headings = ("muscle", "f_max, N", "l_opt, m", "l_slack, m", "delay, s", "driven", "joints")
    print_table(headings, rows, ("muscle", "driven", "joints"))
    for joint, words in found.drives.items():
        if joint in scene.actuation:
            out.print(f"{joint}: {', '.join(words)}")
    start_warp()
    with log.status("measuring moment arms"):
        useless = useless_muscles(scene)
    for name, joint, arm in useless:
        little = f" its moment arm stays under {1e3 * max(arm, 1e-5):.2g} mm"
        out.print(marked(f"{name} cannot act on {joint}:", "yellow", little))
    for name, joints in joints_of_muscles(scene.character, names).items():
        if not joints:
            out.print(marked(f"{name} cannot act at all:", "yellow", " it crosses no joint that moves"))
