"""Opens OpenSim models of which one element is changed, with OpenSim 4.6 and with warpmuscle: what differs.

For docs/tutorials/opensim.md.

    python tools/opensim_changed.py MODEL.osim [...] --cases 100 --seed 1

Each case takes an element away, its text, or its name, or doubles it, or writes its number or truth in another way. Of
each kind of element one is changed. Those that OpenSim opens should load, with the same mass matrix, inverse dynamics
and gravity in two random poses. `pip install opensim` brings OpenSim 4.6.
"""

from __future__ import annotations

import copy
import warnings
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from multiprocessing import get_context
from pathlib import Path
from random import Random
from tempfile import TemporaryDirectory
from typing import Annotated, Any
from xml.etree import ElementTree

import numpy as np
import typer
from model_variants import COLONS, numbers_of
from opensim_ours import Ours
from opensim_posed import Posed

import warpmuscle as wm
from warpmuscle.cli.ending import run_script
from warpmuscle.core.errors import SceneError

DRAWN = {"Appearance", "VisibleObject", "attached_geometry", "geometry", "FrameGeometry", "defaults", "credits",
    "publications", "MarkerSet", "ProbeSet", "ModelVisualPreferences"}  # fmt: skip
POSES, TOLERANCE = 2, 1e-6
PATIENCE = 120.0  # s
Element = ElementTree.Element
Place = tuple[int, ...]  # number of a child, of its child, and so on


def places(root: Element) -> dict[str, list[Place]]:
    """Where elements of each kind are: by the tags that lead to them."""
    found: dict[str, list[Place]] = {}
    rest: list[tuple[Element, str, Place]] = [(root, root.tag, ())]
    while rest:
        element, path, place = rest.pop()
        found.setdefault(path, []).append(place)
        inner = [(child, f"{path}/{child.tag}", (*place, k)) for k, child in enumerate(element)]
        rest += [one for one in inner if one[0].tag not in DRAWN]
    return {path: at for path, at in found.items() if path.count("/") > 1}


def changed(root: Element, place: Place, rng: Random) -> tuple[str, Element]:
    """What is changed at a place, and the model with that."""
    root = copy.deepcopy(root)
    above = root
    for k in place[:-1]:
        above = above[k]
    element = above[place[-1]]
    ways = ["taken away", "doubled", *(["nameless"] if element.get("name") else []),
        *([] if len(element) else ["emptied", "written otherwise"])]  # fmt: skip
    way = rng.choice(ways)
    if way == "taken away":
        above.remove(element)
    elif way == "doubled":
        above.insert(place[-1], copy.deepcopy(element))
    elif way == "nameless":
        del element.attrib["name"]
    else:
        element.text = "" if way == "emptied" else otherwise(element, rng)
    return way, root


def otherwise(element: Element, rng: Random) -> str:
    """The text of an element in another notation, or another number or truth."""
    text = (element.text or "").strip()
    if text.lower() in ("true", "false"):
        return rng.choice([text.upper(), " 1 ", "0", "false" if text.lower() == "true" else "true"])
    numbers = numbers_of(element)
    if not numbers:
        return rng.choice([f" {text}\n", text.rpartition("/")[2]])
    factor = rng.choice([-1.0, 0.0, 1.3])
    return rng.choice(
        [", ".join(text.split()), "\n\t".join(text.split()), " ".join(f"{factor * x!r}" for x in numbers)]
    )


def cases(files: list[Path], count: int, seed: int) -> Iterator[tuple[str, Path]]:
    """Changed models in a folder that lasts as long as the iteration: what is changed, and the file."""
    kinds = []
    for file in files:
        root = ElementTree.fromstring(file.read_text("utf-8", "replace").replace("::", COLONS))
        kinds += [(file, root, path, at) for path, at in sorted(places(root).items())]
    rng = Random(seed)
    with TemporaryDirectory() as folder:
        for number, (file, root, path, at) in enumerate(rng.sample(kinds, min(count, len(kinds)))):
            way, model = changed(root, rng.choice(at), rng)
            other = Path(folder) / f"{file.stem}_{number}.osim"
            other.write_text(ElementTree.tostring(model, encoding="unicode").replace(COLONS, "::"))
            yield f"{file.stem}: {path.split('/', 2)[2]} {way}", other
            other.unlink()


def of_opensim(file: Path) -> dict[str, Any] | None:
    """What OpenSim computes in random poses; None if it does not open the model, or finds no dynamics."""
    try:
        model, rng = Posed(file), np.random.default_rng(1)
        q = model.random_poses(rng, POSES)
        rows = []
        for pose in q:
            rate, acceleration = np.zeros_like(pose), np.zeros_like(pose)
            rate[model.independent] = rng.normal(size=len(model.independent))
            acceleration[model.independent] = rng.normal(scale=5.0, size=len(model.independent))
            rate, acceleration = model.consistent(pose, rate, acceleration)
            rows.append((pose, rate, acceleration, model.dynamics(pose, rate, acceleration)))
    except (RuntimeError, ValueError):
        return None
    return {"names": model.names, "independent": [int(k) for k in model.independent], "rows": rows}


def of_ours(file: Path, theirs: dict[str, Any]) -> str:
    """How the scene differs; nothing if it does not."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            ours = Ours(wm.load(file), theirs["names"], theirs["independent"])
    except SceneError as error:
        return f"does not load: {error.message}"
    except (SystemExit, ValueError) as error:  # of names that are others
        return str(error)
    for q, rate, acceleration, expected in theirs["rows"]:
        mass, needed, gravity = (part[0] for part in ours.dynamics(q[None], rate[None], acceleration[None]))
        size = np.sqrt(np.diagonal(expected["mass"]))
        most = np.abs(expected["inverse_dynamics"]).max(initial=TOLERANCE)
        either = [np.abs(needed - expected[name]) for name in ("inverse_dynamics", "dynamics_by_slope")]
        off = {
            "mass matrix": np.abs(mass - expected["mass"]) / np.maximum(np.outer(size, size), TOLERANCE),
            "inverse dynamics": np.minimum(*either) / most, "gravity": np.abs(gravity - expected["gravity"]) / most,
        }  # fmt: skip
        for name, values in off.items():
            if values.size and not values.max() < TOLERANCE:
                return f"{name} differs by {values.max():.1g}"
    return ""


class Side:
    """A process that asks one of both, and another when it has died."""

    def __init__(self) -> None:
        self._pool = self._fresh()

    def _fresh(self) -> ProcessPoolExecutor:
        return ProcessPoolExecutor(1, get_context("spawn"))

    def ask(self, task: Callable[..., Any], *args: object) -> Any:
        """What a task returns; None if its process died."""
        try:
            return self._pool.submit(task, *args).result(PATIENCE)
        except BrokenProcessPool:
            self._pool = self._fresh()
            return None


def main(
    models: Annotated[list[Path], typer.Argument(help="Files of models.")],
    count: Annotated[int, typer.Option("--cases", min=1, help="How many.")] = 100,
    seed: Annotated[int, typer.Option(help="Of the changes.")] = 1,
) -> None:
    """Print each case that differs, and how many do not."""
    opensim, ours = Side(), Side()
    opened = alike = 0
    for what, file in cases(models, count, seed):
        theirs = opensim.ask(of_opensim, file)
        if theirs is None:
            continue
        opened += 1
        difference = ours.ask(of_ours, file, theirs)
        alike += difference == ""
        if difference != "":
            print(f"- {what}: {difference or 'the process died'}", flush=True)
    print(f"OpenSim opens {opened}; {alike} of them load and have its dynamics")


if __name__ == "__main__":
    run_script(main)
