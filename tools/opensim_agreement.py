"""How closely scenes made of OpenSim models agree with OpenSim 4.6, which `pip install opensim` brings: tables.

    python tools/opensim_agreement.py MODEL.osim [...] --poses 1000 --json agreement.json
    python tools/opensim_agreement.py MODEL.osim --motion MOTION.mot --lengths LENGTHS.sto

The first form poses both at random inside the coordinates' ranges (see `opensim_oracle.py`) and compares path lengths,
moment arms, mass matrix, inverse dynamics, gravity and forces of muscles in equilibrium; then it moves both along
lines of 0.1 degree and shows the greatest change of a path in one move. The second form compares path lengths with a
file of OpenSim's along a motion, and needs no OpenSim. What is beyond a tolerance is listed with both values.
"""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer
import warp as wp
from opensim_oracle import Numbers, numbers
from opensim_ours import Ours
from opensim_posed import LINE, Floats

import warpmuscle as wm
from warpmuscle.cli.ending import run_script
from warpmuscle.scene import EllipsoidSurface, Scene
from warpmuscle.scene.masses import body_mass

LENGTH, ELLIPSOID_LENGTH = 1e-5, 1.5e-3  # m
ARM, ELLIPSOID_ARM = 1e-4, 2e-3  # m
DYNAMICS, FORCE, POWER, JUMP = 1e-3, 5e-3, 1e-4, 5e-3  # parts of the whole; m
LISTED = 12  # at most, of what is beyond a tolerance


@dataclass
class Measure:
    """How many of so many values agree, and the worst that do not."""

    name: str
    unit: str
    tolerance: float
    count: int
    within: float  # part of them
    median: float
    worst: float
    beyond: list[dict[str, Any]] = field(default_factory=list)  # the worst of each muscle or coordinate


def measure(
    name: str, unit: str, ours: Floats, theirs: Floats, labels: list[str], tolerance: float | Floats, scale: Any = 1.0
) -> Measure:
    """Compare (n, L) values of L labels; a value that OpenSim does not have is NaN and does not count.

    Args:
        tolerance: one for all, or one a label. scale: by which differences are divided.
    """
    off = np.abs(ours - theirs) / scale
    known = np.isfinite(theirs)
    allowed = np.broadcast_to(tolerance, off.shape)
    bad = known & ~(off <= allowed)
    listed = []
    for k in np.flatnonzero(bad.any(axis=0)):
        at = int(np.argmax(np.where(known[:, k], np.nan_to_num(off[:, k], nan=np.inf), -1.0)))
        both = {"pose": at, "ours": float(ours[at, k]), "opensim": float(theirs[at, k]), "off": float(off[at, k])}
        listed.append({"label": labels[k], "poses": int(bad[:, k].sum()), **both})
    listed.sort(key=lambda row: -row["off"])
    values = off[known]
    least = float(np.min(tolerance))
    if not values.size:
        return Measure(name, unit, least, 0, 1.0, 0.0, 0.0)
    within, middle, worst = 1.0 - bad[known].mean(), np.median(values), values.max()
    return Measure(name, unit, least, values.size, float(within), float(middle), float(worst), listed)


def paths(found: Numbers, ours: Ours, ellipsoids: float = ELLIPSOID_LENGTH) -> list[Measure]:
    """Lengths, moment arms about independent coordinates, and virtual power.

    Args:
        ellipsoids: tolerance of lengths of paths that may go round ellipsoids, m.
    """
    columns = [ours.muscles.index(name) for name in found.muscles]
    length, speed, arm = (values[:, columns] for values in ours.paths(found.q, found.rate))
    round_ellipsoids = np.array([over_ellipsoid(ours.scene, name) for name in found.muscles])
    names, count = list(found.muscles), len(found.q)
    allowed = np.where(round_ellipsoids, ellipsoids, LENGTH)
    measures = [measure("path length", "m", length, found.length, names, allowed)]
    labels = [f"{muscle} {found.coordinates[k]}" for muscle in names for k in found.independent]
    allowed = np.repeat(np.where(round_ellipsoids, ELLIPSOID_ARM, ARM), len(found.independent))
    theirs, slopes = (values[:, :, found.independent].reshape(count, -1) for values in (found.arm, found.slope))
    mine, own = arm.reshape(count, -1), ours.slopes(found.q)[:, columns].reshape(count, -1)
    crossed = (theirs != 0.0).any(axis=0) | (slopes != 0.0).any(axis=0) | (mine != 0.0).any(axis=0)
    labels = [label for label, known in zip(labels, crossed, strict=True) if known]
    mine, own, theirs, slopes = (values[:, crossed] for values in (mine, own, theirs, slopes))
    allowed = allowed[crossed]
    measures.append(measure("moment arm", "m", mine, theirs, labels, allowed))
    measures.append(measure("OpenSim's moment arm and the slope of its length", "m", theirs, slopes, labels, allowed))
    measures.append(measure("our moment arm and the slope of our length", "m", mine, own, labels, allowed))
    agreed = np.where(np.abs(theirs - slopes) <= 0.1 * allowed, theirs, np.nan)
    measures.append(measure("moment arm, where OpenSim's is the slope", "m", mine, agreed, labels, allowed))
    power = -np.einsum("nmi,ni->nm", arm, found.rate[:, found.independent])
    scale = np.maximum(np.abs(speed).max(axis=0), 1e-6)
    measures.append(measure("virtual power, moment arms and speed of ours", "1", power, speed, names, POWER, scale))
    return measures


def dynamics(found: Numbers, ours: Ours) -> list[Measure]:
    """Mass matrix over the roots of its diagonal, forces over the greatest of each coordinate."""
    mass, needed, gravity = ours.dynamics(found.q, found.rate, found.acceleration)
    names = [str(found.coordinates[k]) for k in found.independent]
    pairs = [f"{a} {b}" for a in names for b in names]
    root = np.sqrt(np.diagonal(found.mass, axis1=1, axis2=2))
    scale = (root[:, :, None] * root[:, None, :]).reshape(len(mass), -1)
    flat = [values.reshape(len(mass), -1) for values in (mass, found.mass)]
    most = np.maximum(np.abs(found.inverse_dynamics).max(axis=0), 1e-9)
    return [
        measure("mass matrix", "1", *flat, pairs, DYNAMICS, scale),
        measure("inverse dynamics", "1", needed, found.inverse_dynamics, names, DYNAMICS, most),
        measure(
            "OpenSim's accelerations and the rate of its velocities",
            "1",
            found.acceleration_off[:, None],
            np.zeros((len(mass), 1)),
            ["bodies"],
            DYNAMICS,
        ),
        measure("inverse dynamics, with that rate", "1", needed, found.dynamics_by_slope, names, DYNAMICS, most),
        measure("gravity", "1", gravity, found.gravity, names, DYNAMICS, most),
    ]


def forces(found: Numbers, ours: Ours) -> Measure:
    """Tension in equilibrium over itself, or over a hundredth of f_max where it is less."""
    names = [str(name) for name in found.muscles]
    tension = ours.forces(found.q, found.activation, names)
    least = 0.01 * np.array([float(ours.scene.character.muscles[name].f_max) for name in names])  # type: ignore[arg-type]
    scale = np.maximum(np.abs(found.force), least)
    theirs = np.where(np.isinf(tension), np.nan, found.force)
    return measure("force in equilibrium", "1", tension, theirs, names, FORCE, scale)


def jumps(found: Numbers, ours: Ours) -> dict[str, Any]:
    """The greatest change of each path in a move of 0.1 degree, ours and OpenSim's, where one is beyond 5 mm."""
    columns = [ours.muscles.index(name) for name in found.muscles]
    lines = [values.reshape(-1, LINE + 1, len(columns)) for values in (ours.lengths(found.line_q)[:, columns],
             found.line_length)]  # fmt: skip
    change = [np.abs(np.diff(values, axis=1)).reshape(-1, len(columns)) for values in lines]
    off = np.abs(lines[0] - lines[1])
    listed = [
        {
            "label": str(found.muscles[k]), "ours": float(change[0][:, k].max()),
            "opensim": float(change[1][:, k].max()), "ours_count": int((change[0][:, k] > JUMP).sum()),
            "opensim_count": int((change[1][:, k] > JUMP).sum()),
        }
        for k in range(len(columns)) if max(part[:, k].max() for part in change) > JUMP
    ]  # fmt: skip
    return {
        "moves": len(change[0]), "ours": float(change[0].max()), "opensim": float(change[1].max()),
        "within": float((off <= LENGTH).mean()), "beyond": listed,
    }  # fmt: skip


def over_ellipsoid(scene: Scene, muscle: str) -> bool:
    """Whether a muscle wraps around an ellipsoid."""
    wraps = scene.character.muscles[muscle].wraps
    return any(isinstance(scene.character.surfaces[wrap.surface], EllipsoidSurface) for wrap in wraps)


def storage(file: Path) -> tuple[list[str], Floats, bool]:
    """Columns of a .mot or .sto file, the last part of their paths, values (n, columns), and whether in degrees."""
    head, _, body = file.read_text().partition("endheader")
    lines = body.strip().splitlines()
    names = [name.split("|")[0].removesuffix("/value").split("/")[-1] for name in lines[0].split("\t")]
    values = np.array([[float(word) for word in line.split()] for line in lines[1:]])
    return names, values, "inDegrees=yes" in head.replace(" ", "")


def along(scene: Scene, motion: Path, lengths: Path) -> Measure:
    """Path lengths along a motion beside a file of OpenSim's."""
    names, values, degrees = storage(motion)
    held = scene.opensim.locked | scene.opensim.couplers if scene.opensim else {}
    moving = [name for name in names[1:] if name not in held]
    moving += [name for name in coordinates_of(scene) if name not in moving and name not in held]
    q = np.zeros((len(values), len(moving)))
    for k, name in enumerate(moving):
        if name in names:
            turn = degrees and turns(scene, name)
            q[:, k] = np.radians(values[:, names.index(name)]) if turn else values[:, names.index(name)]
    ours = Ours(scene, moving, [k for k, name in enumerate(moving) if name in coordinates_of(scene)])
    muscles, expected, _ = storage(lengths)
    theirs = np.column_stack([np.interp(values[:, 0], expected[:, 0], part) for part in expected[:, 1:].T])
    found = ours.lengths(q)[:, [ours.muscles.index(name) for name in muscles[1:]]]
    return measure(f"path length along {motion.name}", "m", found, theirs, muscles[1:], LENGTH)


def coordinates_of(scene: Scene) -> list[str]:
    """Names of the independent coordinates of a scene made of a model."""
    assert scene.opensim is not None
    joints = scene.character.joints.items()
    own = [name for name, joint in joints if joint.type != "fixed" and not joint.follows]
    return [*scene.opensim.root_coordinates, *own]


def turns(scene: Scene, coordinate: str) -> bool:
    """Whether a coordinate is an angle."""
    assert scene.opensim is not None
    root = scene.opensim.root_coordinates
    if coordinate in root:
        return root.index(coordinate) < len(scene.opensim.root.rotations)  # type: ignore[union-attr]
    return coordinate in scene.character.joints and scene.character.joints[coordinate].type != "slide"


def compare(
    file: Path, poses: int, seed: int, moves: int, hard_points: bool, beyond: float = 0.0,
    ellipsoids: float = ELLIPSOID_LENGTH,
) -> dict[str, Any]:  # fmt: skip
    """All measures of a model."""
    scene, found = wm.load(file, hard_points=hard_points), numbers(file, poses, seed, moves, beyond)
    ours = Ours(scene, [str(name) for name in found.coordinates], [int(k) for k in found.independent])
    missing = sorted(set(found.muscles.tolist()) - set(ours.muscles))
    if missing:
        raise SystemExit(f"{file.name}: the scene has no muscle {', '.join(missing)}")
    muscles, heavy = len(found.muscles) > 0, body_mass(scene.character) > 0.0
    measures = [
        *(paths(found, ours, ellipsoids) if muscles else []), *(dynamics(found, ours) if heavy else []),
        *([forces(found, ours)] if muscles and heavy else []),  # muscles that move nothing are not simulated
    ]  # fmt: skip
    report: dict[str, Any] = {"model": file.name, "poses": poses, "seed": seed}
    return report | {"measures": [asdict(one) for one in measures], "jumps": jumps(found, ours) if moves else None}


def show(report: dict[str, Any]) -> None:
    """Print a model's tables."""
    print(f"\n## {report['model']}, {report['poses']} poses, seed {report['seed']}\n")
    print("| | within | tolerance | values | median | worst |\n|---|---|---|---|---|---|")
    for one in report["measures"]:
        tolerance, within = f"{one['tolerance']:g} {one['unit']}".removesuffix(" 1"), f"{100.0 * one['within']:.3f} %"
        row = f"{within} | {tolerance} | {one['count']} | {one['median']:.1e} | {one['worst']:.1e}"
        print(f"| {one['name']} | {row} |")
    if report.get("jumps"):
        both = report["jumps"]
        print(f"| greatest change in {both['moves']} moves of 0.1 degree | ours {1e3 * both['ours']:.2f} mm | 5 mm "
              f"| OpenSim {1e3 * both['opensim']:.2f} mm | | |")  # fmt: skip
    for one in report["measures"]:
        for row in one["beyond"][:LISTED]:
            print(f"- {one['name']}: {row['label']} in {row['poses']} poses, worst {row['pose']}: ours "
                  f"{row['ours']:.7g}, OpenSim {row['opensim']:.7g}")  # fmt: skip
    for row in (report.get("jumps") or {"beyond": []})["beyond"]:
        print(f"- jump of {row['label']}: ours {1e3 * row['ours']:.2f} mm ({row['ours_count']} moves beyond 5 mm), "
              f"OpenSim {1e3 * row['opensim']:.2f} mm ({row['opensim_count']})")  # fmt: skip


def main(
    models: Annotated[list[Path], typer.Argument(help="Files of the models.")],
    poses: Annotated[int, typer.Option(help="Random poses.")] = 1000,
    seed: Annotated[int, typer.Option(help="Of the poses.")] = 1,
    moves: Annotated[int, typer.Option(help="Moves of 0.1 degree.")] = 100_000,
    hard_points: Annotated[bool, typer.Option("--hard-points", help="As of `warpmuscle convert`.")] = False,
    beyond: Annotated[float, typer.Option(help="Part of each range that poses may be beyond its ends.")] = 0.0,
    ellipsoids: Annotated[float, typer.Option(help="Tolerance of paths round ellipsoids, m.")] = ELLIPSOID_LENGTH,
    motion: Annotated[Path | None, typer.Option(help="Coordinates over time.")] = None,
    lengths: Annotated[Path | None, typer.Option(help="OpenSim's path lengths along it.")] = None,
    json_file: Annotated[Path | None, typer.Option("--json", help="File for all that was measured.")] = None,
) -> None:
    """Compare."""
    wp.config.log_level = wp.LOG_WARNING
    reports = []
    for model in models:
        if motion is not None and lengths is not None:
            found = along(wm.load(model), motion, lengths)
            reports.append({"model": model.name, "poses": found.count, "seed": 0, "measures": [asdict(found)]})
        else:
            reports.append(compare(model, poses, seed, moves, hard_points, beyond, ellipsoids))
        show(reports[-1])
        if json_file is not None:
            json_file.write_text(json.dumps(reports, indent=1))


if __name__ == "__main__":
    run_script(main)
