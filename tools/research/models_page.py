"""Which published models load: the page that lists a folder's files, with the reason where one does not.

For docs/explanation/models-that-run.md.

    python tools/research/models_page.py FOLDER [FOLDER ...] -o docs/explanation/models-that-run.md

Every `.osim` in the folders, and every `.xml` that is a whole model of MuJoCo, is loaded as `wm.load` does.
A row says how large its scene is and what it leaves out that would act. Files of the same text count once.
"""

from __future__ import annotations

import hashlib
import os
import re
import warnings
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import typer

from warpmuscle.cli.ending import run_script
from warpmuscle.core.errors import SceneError
from warpmuscle.core.plain_text import number_of
from warpmuscle.formats import Ignored, load
from warpmuscle.scene import Scene
from warpmuscle.scene.joints import joint_type
from warpmuscle.scene.muscles import is_cable

LOST = re.compile(
    r"left out|holds nothing|touch(es)? nothing|pulls on nothing|cannot stand|has no effect|have no effect|not kept"
)
SWITCHED_OFF = "switched off in the model"
LONGEST = 160  # characters of a reason
COLUMNS = (
    "model",
    "bodies",
    "coordinates",
    "muscles",
    "ligaments",
    "forces",
    "constraints",
    "left out, or why it does not load",
)
INTRODUCTION = """# Which published models run

This page lists published models of other people and says which of them warpmuscle can run. `warpmuscle convert MODEL`
makes a scene of each model that has numbers in the table. [The tutorial on OpenSim
models](../tutorials/opensim.md#which-models-load) and [the one on MuJoCo](../tutorials/mujoco.md#how-closely-it-agrees)
say how closely scenes agree with OpenSim and MuJoCo. Only free coordinates are counted. Ligaments include springs along
paths and path actuators. Forces are those other than muscles: springs, limits, bushings, actuators. The last column
names parts of the file that the scene leaves out, if they would act in a simulation.

The files are not part of warpmuscle: OpenSim's models and those of its users (simtk.org, GitHub), MyoSuite 2.11.6 and
the arms and full body of MyoSim 0.2.4 (Apache-2.0). This command makes such a page for any folder of models:

<!-- by hand: needs the models -->
```bash
python tools/research/models_page.py FOLDER -o page.md
```

"""


@dataclass
class Row:
    """A file, its scene if it loads, and what is to be said."""

    name: str
    scene: Scene | None
    said: str

    def text(self) -> str:
        """The row of the table."""
        if self.scene is None:
            return f"| {self.name} | | | | | | | **does not load**: {self.said} |"
        character = self.scene.character
        cables = sum(is_cable(muscle) for muscle in character.muscles.values())
        free = sum(joint_type(joint).scalars * bool(joint_type(joint).moves) for joint in character.joints.values()
                   if not joint.follows)  # fmt: skip
        balls = sum(3 for joint in character.joints.values() if joint.type == "ball")
        root = {"free": 6, "planar": 3}.get(character.root_joint, 0)
        counts = (
            sum(body.mass != 0.0 for body in character.bodies.values()), free + balls + root,
            len(character.muscles) - cables, cables, len(self.scene.forces), len(character.constraints),
        )  # fmt: skip
        return f"| {self.name} | {' | '.join(str(count or '') for count in counts)} | {self.said} |"


def row_of(file: Path, name: str) -> Row:
    """Load a file and say what is left out."""
    ignored: list[Ignored] = []
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            scene = load(file, ignored=ignored)
    except SceneError as error:
        return Row(name, None, shortened(error.message))
    return Row(name, scene, left_out(ignored))


def left_out(ignored: list[Ignored]) -> str:
    """What would act and does not, by kind; what a model switches off itself is counted apart."""
    kinds: Counter[str] = Counter()
    off = 0
    for one in ignored:
        if SWITCHED_OFF in one.reason:
            off += 1
        elif LOST.search(one.reason):
            kinds[one.text.split()[0] if one.line else kind_of(one)] += 1
    parts = [f"{count} {kind}" if count > 1 else kind for kind, count in kinds.most_common()]
    parts += [f"{number_of(off, 'part')} that the model switches off"] if off else []
    return shortened("; ".join(parts))


def kind_of(one: Ignored) -> str:
    """What is noted of a part of MuJoCo's model that has no line, without its name and numbers."""
    reason = re.split("[:;]", one.reason)[0].replace("does here", "do here")
    return f"{one.text.split()[0]} ({re.sub('^[0-9]+ geoms? of it touch(es)?', 'geoms touch', reason)})"


def shortened(text: str) -> str:
    """A text for a cell."""
    plain = " ".join(text.replace("|", "/").split())
    return plain if len(plain) <= LONGEST else plain[: LONGEST - 1].rsplit(" ", 1)[0] + " ..."


def models_in(folders: list[Path]) -> Iterator[Path]:
    """Whole models, those of the same text once."""
    seen: set[str] = set()
    for folder in folders:
        for file in sorted([*folder.rglob("*.osim"), *folder.rglob("*.xml")], key=lambda path: path.name.lower()):
            data = file.read_bytes()
            text = data.decode("utf-8", errors="replace")
            whole = file.suffix == ".osim" or (
                re.search(r"<mujoco[\s>]", text[:3000]) is not None
                and "<actuator" in text + "".join(included(file, text))
            )
            digest = hashlib.sha256(data).hexdigest()
            if whole and digest not in seen:
                seen.add(digest)
                yield file


def included(file: Path, text: str) -> Iterator[str]:
    """Texts of the files that a model of MuJoCo includes itself."""
    for name in re.findall(r'<include file="([^"]+)"', text):
        path = file.parent / name
        if path.is_file():
            yield path.read_text(errors="replace")


def main(
    folders: Annotated[list[Path], typer.Argument(help="Folders of models.")],
    output: Annotated[Path | None, typer.Option("-o", help="File for the page.")] = None,
) -> None:
    """Make the page."""
    rows = []
    for file in models_in(folders):
        rows.append(row_of(file, file.stem))
        print(rows[-1].text(), flush=True)
    loaded = sum(row.scene is not None for row in rows)
    head = f"| {' | '.join(COLUMNS)} |\n" + "|---" * len(COLUMNS) + "|\n"
    table = head + "\n".join(row.text() for row in rows) + "\n"
    text = f"{INTRODUCTION}Of {number_of(len(rows), 'model')} {loaded} load.\n\n{table}"
    if output is not None:
        part = output.with_suffix(".part")
        part.write_text(text)
        os.replace(part, output)


if __name__ == "__main__":
    run_script(main)
