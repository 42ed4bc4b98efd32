"""The gallery has every shipped scene and every kind of figure, in pictures that keep the repository small."""

import re

import numpy as np
import pytest
from pages import ROOT

from warpmuscle.core.shipped import shipped_scenes
from warpmuscle.plots import KINDS

TEXT = (ROOT / "docs" / "gallery.md").read_text(encoding="utf-8")
PICTURES = ROOT / "docs" / "pictures" / "gallery"
FOUND = [f"{name}_found" for name in ("walker", "ostrich", "pony", "kangaroo")]
LARGEST, ALL = 40_000, 1_500_000  # bytes


def test_every_scene_and_every_figure_has_a_picture_and_its_command():
    shown = dict(re.findall(r"\*\*(\w+)\*\*: .* \| `([^`]+)` \|", TEXT))
    commands = {name: f"warpmuscle view {name}" for name in shipped_scenes()}
    commands |= {name: f"warpmuscle view {name}.toml" for name in FOUND}
    commands |= {name: f"warpmuscle plot walk.h5 --what {name}" for name in KINDS}
    assert shown == commands


def test_no_picture_is_left_over_and_all_are_small():
    sizes = {path.name: path.stat().st_size for path in PICTURES.iterdir()}
    assert set(sizes) == {f"{name}.webp" for name in [*shipped_scenes(), *FOUND, *KINDS]}
    assert max(sizes.values()) < LARGEST
    assert sum(sizes.values()) < ALL


@pytest.mark.parametrize("name", [*shipped_scenes(), *FOUND, *KINDS])
def test_a_picture_shows_something(name: str):
    image = np.asarray(pytest.importorskip("PIL.Image").open(PICTURES / f"{name}.webp").convert("L"), dtype=float)
    differs = np.abs(image - np.median(image, axis=1, keepdims=True)) > 25.0  # from the rest of its line
    assert differs.mean() > 0.01
