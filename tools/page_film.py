"""A film of a page of motions, frame by frame, drawn by Chromium: .gif, .webp, .mp4 or .webm, by the output's name.

.venv/bin/warpmuscle view walk56_person --duration 8 --export walk.html
.venv/bin/python tools/page_film.py walk.html walk.gif --begin 4 --end 6.3 --size 480 360 --view side
"""

from __future__ import annotations

import argparse
import io
import shutil
from pathlib import Path

import numpy as np
from PIL import Image
from playwright.sync_api import sync_playwright

DRAWN = "new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))"


def main() -> None:
    """Do what the command line says."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("page", type=Path)
    parser.add_argument("film", type=Path)
    parser.add_argument("--begin", type=float, default=0.0, help="s")
    parser.add_argument("--end", type=float, default=float("inf"), help="s")
    parser.add_argument("--rate", type=float, default=20.0, help="pictures a second")
    parser.add_argument("--size", type=int, nargs=2, default=(640, 480))
    parser.add_argument("--view", default="oblique")
    parser.add_argument("--quality", type=int, default=60, help="of .webp, 0 to 100")
    parser.add_argument("--colour", default="", help="of bodies: activation, cost, rank or condition, if known")
    parser.add_argument("--bare", action="store_true", help="without title, legend and names")
    parser.add_argument("--turn", type=float, default=0.0, help="degrees that the camera goes around over the film")
    parser.add_argument("--tilt", type=float, default=0.0, help="degrees that the camera is higher")
    parser.add_argument("--zoom", type=float, default=1.0, help="how much nearer than where all is seen")
    given = parser.parse_args()
    pictures = drawn(given)
    if given.film.suffix == ".gif":
        first, *others = [picture.quantize(96, dither=Image.Dither.NONE) for picture in pictures]
        first.save(given.film, save_all=True, append_images=others, duration=round(1000.0 / given.rate), loop=0)
    elif given.film.suffix == ".webp":
        first, *others = pictures
        first.save(given.film, save_all=True, append_images=others, duration=round(1000.0 / given.rate), loop=0,
                   quality=given.quality, method=6)  # fmt: skip
    else:
        import imageio_ffmpeg

        writer = imageio_ffmpeg.write_frames(str(given.film), pictures[0].size, fps=given.rate)
        writer.send(None)
        for picture in pictures:
            writer.send(np.ascontiguousarray(picture))
        writer.close()
    print(f"wrote {len(pictures)} pictures to {given.film}")


def drawn(given: argparse.Namespace) -> list[Image.Image]:
    """The pictures of a page from the begin to the end."""
    width, height = given.size
    flags = ["--no-sandbox", "--disable-gpu", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
    with sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=shutil.which("chromium"), args=flags)
        page = browser.new_page(viewport={"width": width, "height": height})
        page.set_default_timeout(120_000)
        page.goto(f"{given.page.resolve().as_uri()}?time={given.begin}&shot=1&view={given.view}")
        end = min(given.end, page.evaluate("warpmuscle.ready.then(() => warpmuscle.state().end)"))
        page.evaluate(f"warpmuscle.zoom({1.0 / given.zoom}); warpmuscle.turn(0, {np.radians(given.tilt)})")
        if given.colour:
            choose = (
                'name => { const s = document.getElementById("shade"); s.value = name; s.onchange(); return s.value; }'
            )
            if page.evaluate(choose, given.colour) != given.colour:
                raise SystemExit(f"{given.page}: nothing to colour by {given.colour!r}")
        if given.bare:
            page.add_style_tag(content="#legend, #labels { display: none }")
        pictures, step = [], np.radians(given.turn) / max(given.rate * (end - given.begin), 1.0)
        for time in np.arange(given.begin, end, 1.0 / given.rate):
            page.evaluate(f"warpmuscle.turn({step}); warpmuscle.seek({time}); {DRAWN}")
            pictures.append(Image.open(io.BytesIO(page.screenshot())).convert("RGB"))
        browser.close()
    return pictures


if __name__ == "__main__":
    main()
