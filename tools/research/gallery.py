"""The page docs/gallery.md and its pictures: every shipped scene in motion, and every kind of figure, with its command.

For docs/gallery.md.

.venv/bin/python tools/research/gallery.py            # what is missing; minutes where kernels are to be compiled
.venv/bin/python tools/research/gallery.py fwalk feet # these again

Pictures of scenes are the page of `warpmuscle view` as Chromium draws it without a graphics card.
"""

from __future__ import annotations

import argparse
import io
import shutil
import tempfile
from pathlib import Path
from typing import Any

import msgspec
from PIL import Image
from playwright.sync_api import sync_playwright

import warpmuscle as wm
from warpmuscle.core.shipped import STUDIES, description, scene_groups, shipped_scenes
from warpmuscle.plots import KINDS
from warpmuscle.view.sources import of_scene, page_of_sights

ROOT = Path(__file__).resolve().parents[2]
PAGE, PICTURES = ROOT / "docs" / "gallery.md", ROOT / "docs" / "pictures" / "gallery"
EXAMPLES = ROOT / "warpmuscle" / "examples" / "files"
SHOWN, SECONDS = 0.62, 2.0  # of the motion, at which it is shown; s that are simulated of walks
SIZE, FIGURE = (360, 300), 460  # px of a scene; width of a figure
WALK, SEARCH = "walk56_person", "stumble56"
FOUND = tuple(f"{name}_found" for name in ("walker", "ostrich", "pony", "kangaroo"))  # of `example creatures`
OF_A_SEARCH = ("convergence", "parameters")
TITLES = {
    "bergmann2017": "Bergmann 2017",
    "wang2012": "Wang 2012",
    "opensim": "OpenSim",
    "programs": "Quadratic programmes",
}
FILM = """
A film of the four that searches found, [and how to make others](how-to/creatures.md):

![A walker, a pony, an ostrich and a kangaroo on the muscles that searches gave them](pictures/creatures.webp)

The same in space, where they may fall to their sides:

![The walker, the pony, the ostrich and the kangaroo in space](pictures/creatures_space.webp)
"""
TABLE = "| picture | what | command |\n|---|---|---|\n"
FLAGS = ["--no-sandbox", "--disable-gpu", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
HEAD = """# Gallery

Every shipped scene, and every kind of figure, with the command that shows it.
[How to look at a motion](how-to/look-at-a-motion.md) and [how to make figures and films](how-to/plots-and-films.md)
say more. `python tools/research/gallery.py` makes this page.
"""


def main() -> None:
    """Do what the command line says."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*", help="scenes and figures to be made again")
    given = parser.parse_args()
    PICTURES.mkdir(parents=True, exist_ok=True)
    for name in given.names:
        picture(name).unlink(missing_ok=True)
    draw_scenes([name for name in (*shipped_scenes(), *FOUND) if not picture(name).exists()])
    draw_figures([name for name in KINDS if not picture(name).exists()])
    PAGE.write_text(page(), encoding="utf-8")
    total = sum(path.stat().st_size for path in PICTURES.iterdir())
    print(f"wrote {PAGE.relative_to(ROOT)}; {total / 1e6:.2f} MB of pictures")


def picture(name: str) -> Path:
    """The file of a scene or a figure."""
    return PICTURES / f"{name}.webp"


def draw_scenes(names: list[str]) -> None:
    """Simulate scenes, and keep what their pages show."""
    if not names:
        return
    with sync_playwright() as driver, tempfile.TemporaryDirectory() as folder:
        browser = driver.chromium.launch(executable_path=shutil.which("chromium"), args=FLAGS)
        window = browser.new_page(viewport={"width": SIZE[0], "height": SIZE[1]})
        window.set_default_timeout(180_000)
        for name in names:
            scene = wm.load(name if name not in FOUND else str(EXAMPLES / f"{name}.toml"))
            (sight,) = of_scene(msgspec.structs.replace(scene, duration=min(scene.duration, SECONDS)), "cpu")
            path = Path(folder) / f"{name}.html"
            page_of_sights([sight]).save(path)
            keep(name, shot(window, path))
            print(name, flush=True)
        browser.close()


def shot(window: Any, path: Path) -> Image.Image:
    """A moment of a page, without its controls."""
    window.goto(f"{path.as_uri()}?shot=1")
    end = window.evaluate("warpmuscle.ready.then(() => warpmuscle.state().end)")
    window.add_style_tag(content="#legend { display: none }")
    window.evaluate(f"warpmuscle.seek({SHOWN * end}); warpmuscle.fit()")
    window.wait_for_timeout(500)
    return Image.open(io.BytesIO(window.screenshot()))


def draw_figures(names: list[str]) -> None:
    """Figures of one walk, and those of a search of one search."""
    if not names:
        return
    run = wm.simulate(WALK, 4.0)
    found = wm.optimize(SEARCH, 200) if set(names) & set(OF_A_SEARCH) else None
    for name in names:
        source = found if name in OF_A_SEARCH and found is not None else run.result
        data = io.BytesIO()
        wm.plot(source, name).savefig(data, format="png", dpi=80)
        image = Image.open(data).convert("RGB")
        keep(name, image.resize((FIGURE, round(FIGURE * image.height / image.width)), Image.Resampling.LANCZOS))
        print(name, flush=True)


def keep(name: str, image: Image.Image) -> None:
    """Write a picture."""
    image.convert("RGB").save(picture(name), quality=62, method=6)


def page() -> str:
    """The text of the page."""
    scenes = shipped_scenes()
    parts = [HEAD]
    for study, names in scene_groups(scenes).items():
        rows = [entry(name, f"warpmuscle view {name}", description(scenes[name], scenes)) for name in names]
        if study == "creatures":
            rows += [entry(name, f"warpmuscle view {name}.toml", example(name)) for name in FOUND]
        parts.append(
            f"## {TITLES.get(study, study.capitalize())}\n\n{STUDIES[study][0].upper()}{STUDIES[study][1:]}.\n\n{TABLE}"
            + "".join(rows)
            + (FILM if study == "creatures" else "")
        )
    figures = [entry(name, f"warpmuscle plot walk.h5 --what {name}", kind.description) for name, kind in KINDS.items()]
    parts.append(f"## Figures\n\n{TABLE}" + "".join(figures))
    return "\n".join(parts)


def example(name: str) -> str:
    """What an example is, and the command that writes it."""
    said = wm.load(str(EXAMPLES / f"{name}.toml")).description.rstrip(".")
    return f"{said}; `warpmuscle example creatures` writes it."


def entry(name: str, command: str, text: str) -> str:
    """A row: a picture, what it is, and the command that shows it."""
    plain = text.replace("|", "\\|")
    return f"| ![{name}](pictures/gallery/{name}.webp) | **{name}**: {plain} | `{command}` |\n"


if __name__ == "__main__":
    main()
