"""Makes others of a kind of OpenSim models, and shows how closely they agree with OpenSim 4.6.

Left and right, of another size, under other names and in another order, and with other coordinates locked, clamped and
at rest.

For docs/tutorials/opensim.md.

    python tools/model_variants.py MODEL.osim [...] --folder variants --poses 20 --beyond 10 -o table.md

Each model is read and written anew by OpenSim, which brings files of all versions to its own; the other variants are
made of that file. A variant that OpenSim itself does not open is left out, which a line says.
"""

from __future__ import annotations

import re
import warnings
from collections.abc import Callable
from pathlib import Path
from random import Random
from typing import Annotated
from xml.etree import ElementTree

import typer
import warp as wp
from opensim_agreement import compare
from opensim_oracle import with_process

from warpmuscle.cli.ending import run_script
from warpmuscle.core.errors import SceneError

PLACES = re.compile(r"translation|location(_\w+)?|mass_center|point(_on_\w+)?|line_direction_vec|gravity|center")
TURNS = {"orientation", "xyz_body_rotation"}
OTHER_SIDE = {"z": "-z", "-z": "z", "+z": "-z"}
NAMED = ("bodyset", "jointset")
BEYOND = 0.25  # of each range
COLONS = "__"  # in place of those in OpenSim's tags, which are no XML
WIDEST = 50.0  # rad or m, of a range that says where a coordinate is
COLUMNS = (
    "variant",
    "path lengths",
    "moment arms, where OpenSim's are slopes",
    "mass matrix",
    "inverse dynamics",
    "beyond",
)
Root = ElementTree.Element


def numbers_of(element: Root) -> list[float]:
    """The numbers in an element, none if it holds anything else."""
    try:
        return [float(word) for word in (element.text or "").split()]
    except ValueError:
        return []


def turned(element: Root, signs: tuple[float, ...]) -> None:
    """Multiply the numbers of an element, if it has as many."""
    values = numbers_of(element)
    if len(values) == len(signs):
        element.text = " ".join(f"{sign * value:.17g}" for sign, value in zip(signs, values, strict=True))


def mirrored(root: Root, rng: Random) -> None:
    """The other side of the body: all places at -z, turns about x and y the other way round."""
    for element in root.iter():
        if PLACES.fullmatch(element.tag):
            turned(element, (1.0, 1.0, -1.0))
        elif element.tag in TURNS:
            turned(element, (-1.0, -1.0, 1.0))
        elif element.tag == "inertia":
            turned(element, (1.0, 1.0, 1.0, 1.0, -1.0, -1.0))
        elif element.tag == "quadrant":
            element.text = OTHER_SIDE.get((element.text or "").strip(), element.text)
        elif element.tag == "TransformAxis":
            rotates = element.get("name", "").startswith("rotation")
            for axis in element.iterfind("axis"):
                turned(axis, (-1.0, -1.0, 1.0) if rotates else (1.0, 1.0, -1.0))
        elif element.tag == "z_location":
            for value in [*element.iter("y"), *element.iter("value")]:
                turned(value, (-1.0,) * len(numbers_of(value)))


def renamed(root: Root, rng: Random) -> None:
    """Bodies and joints of other names, and muscles in another order."""
    names = [
        part.get("name", "") for kind in NAMED for part in root.iterfind(f".//*[@name='{kind}']/objects/*")
    ]  # fmt: skip
    known = re.compile(r"(?<=/)(" + "|".join(map(re.escape, sorted(names, key=len, reverse=True))) + r")(?=/|\s|$)")
    for element in root.iter():
        if element.text and "/" in element.text:
            element.text = known.sub(r"\g<1>_of_another", element.text)
    for kind in NAMED:
        for part in root.iterfind(f".//*[@name='{kind}']/objects/*"):
            part.set("name", f"{part.get('name')}_of_another")
    for forces in root.iterfind(".//*[@name='forceset']/objects"):
        parts = list(forces)
        rng.shuffle(parts)
        forces[:] = parts


def held(root: Root, rng: Random) -> None:
    """Some coordinates locked, others clamped or not, at other defaults within narrower ranges; none that follows."""
    following = {(part.text or "").strip() for part in root.iter("dependent_coordinate_name")}
    for coordinate in root.iter("Coordinate"):
        part = coordinate.find("range")
        limits = [] if part is None else numbers_of(part)
        if part is None or coordinate.get("name") in following or not 0.0 < limits[1] - limits[0] < WIDEST:
            continue
        low, high = 0.9 * limits[0] + 0.1 * limits[1], 0.2 * limits[0] + 0.8 * limits[1]
        part.text = f"{low:.9g} {high:.9g}"
        _put(coordinate, "default_value", f"{rng.uniform(low, high):.9g}")
        _put(coordinate, "clamped", rng.choice(["true", "false"]))
        if rng.random() < 0.15:
            _put(coordinate, "locked", "true")


def _put(element: Root, tag: str, text: str) -> None:
    part = element.find(tag)
    if part is None:
        part = ElementTree.SubElement(element, tag)
    part.text = text


WAYS: dict[str, Callable[[Root, Random], None]] = {"mirrored": mirrored, "renamed": renamed, "held": held}


def _written(source: Path, saved: Path, scaled: Path, seed: int) -> None:
    """Write a model anew, and in another size: each body by factors of its own, or all by one where OpenSim cannot."""
    import opensim

    opensim.Logger.setLevelString("Off")
    model = opensim.Model(str(source))
    model.initSystem()
    model.printToXML(str(saved))
    for spread in (0.05, 0.0):
        rng, common, scales = Random(seed), Random(seed + 1).uniform(0.8, 1.2), opensim.ScaleSet()
        model = opensim.Model(str(source))
        state = model.initSystem()
        for body in range(model.getBodySet().getSize()):
            scale = opensim.Scale()
            scale.setSegmentName(model.getBodySet().get(body).getName())
            factors = [common * rng.uniform(1.0 - spread, 1.0 + spread) for _ in range(3)]
            scale.setScaleFactors(opensim.Vec3(*factors))
            scale.setApply(True)
            scales.cloneAndAppend(scale)
        try:
            model.scale(state, scales, True)
            model.initSystem()
        except RuntimeError:  # of couplers, for one
            continue
        model.printToXML(str(scaled))
        return


def _opens(file: Path) -> bool:
    import opensim

    opensim.Logger.setLevelString("Off")
    try:
        opensim.Model(str(file)).initSystem()
    except RuntimeError:
        return False
    return True


def variants(source: Path, folder: Path, seed: int) -> list[Path]:
    """Write the variants of a model that OpenSim opens, and return their files."""
    folder.mkdir(parents=True, exist_ok=True)
    files = {way: folder / f"{source.stem}_{way}.osim" for way in ("saved", "scaled", *WAYS)}
    with_process(_written, source, files["saved"], files["scaled"], seed)
    for way, change in WAYS.items():
        root = ElementTree.fromstring(files["saved"].read_text("utf-8", "replace").replace("::", COLONS))
        change(root, Random(f"{seed} {source.stem} {way}"))
        files[way].write_text(ElementTree.tostring(root, encoding="unicode").replace(COLONS, "::"))
    opened = []
    for way, file in files.items():
        if file.exists() and with_process(_opens, file):
            opened.append(file)
        else:
            print(f"OpenSim does not open {source.stem} {way}", flush=True)
    return opened


def row(file: Path, poses: int, beyond: int, seed: int, hard_points: bool) -> str:
    """The row of a variant, or why it does not load."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            inside = compare(file, poses, seed, 0, hard_points, ellipsoids=1e-5)
            outside = compare(file, beyond, seed, 0, hard_points, BEYOND, 1e-5) if beyond else {"measures": []}
    except SceneError as error:
        return f"| {file.stem} | {error.message} | | | | |"
    within = {one["name"]: one for one in inside["measures"]}
    farther = {one["name"]: one for one in outside["measures"]}
    cells = [
        _part(within, "path length"), _part(within, "moment arm, where OpenSim's is the slope"),
        _worst(within, "mass matrix"), _worst(within, "inverse dynamics"), _part(farther, "path length"),
    ]  # fmt: skip
    return f"| {file.stem} | {' | '.join(cells)} |"


def _part(measures: dict[str, dict[str, float]], name: str) -> str:
    return f"{100.0 * measures[name]['within']:.2f} %" if name in measures else ""


def _worst(measures: dict[str, dict[str, float]], name: str) -> str:
    return f"{measures[name]['worst']:.0e}" if name in measures else ""


def main(
    models: Annotated[list[Path], typer.Argument(help="Files of models.")],
    folder: Annotated[Path, typer.Option(help="For the variants.")] = Path("variants"),
    poses: Annotated[int, typer.Option(help="Random poses inside of the ranges.")] = 20,
    beyond: Annotated[int, typer.Option(help="And up to a quarter of each range beyond its ends.")] = 10,
    seed: Annotated[int, typer.Option(help="Of variants and poses.")] = 1,
    hard_points: Annotated[bool, typer.Option("--hard-points/--smooth", help="As of `warpmuscle convert`.")] = True,
    output: Annotated[Path | None, typer.Option("-o", help="File for the table.")] = None,
) -> None:
    """Print the table as it comes."""
    wp.config.log_level = wp.LOG_WARNING
    lines = [f"| {' | '.join(COLUMNS)} |", "|" + "---|" * len(COLUMNS)]
    print("\n".join(lines), flush=True)
    for model in models:
        for file in variants(model, folder, seed):
            lines.append(row(file, poses, beyond, seed, hard_points))
            print(lines[-1], flush=True)
            if output is not None:
                output.write_text("\n".join([*lines, ""]))


if __name__ == "__main__":
    run_script(main)
