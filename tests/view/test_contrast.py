"""Every colour of text in the style sheets of pages stands out from what it is written on, in the light and dark.

The ratio is that of WCAG 2.1; 4.5 is what its level AA asks of text.
"""

from __future__ import annotations

import itertools
import json
import re
from importlib.resources import files

import numpy as np
import pytest

from warpmuscle.core.array_types import Floats
from warpmuscle.report import before_after

LEAST = 4.5
SHEETS = {
    "viewer": (files("warpmuscle.view") / "assets" / "page.css").read_text(encoding="utf-8"),
    "report": (files("warpmuscle.report") / "templates" / "report.css").read_text(encoding="utf-8"),
    "before and after": before_after._STYLE,
}
SHADERS = (files("warpmuscle.view") / "assets" / "shaders.js").read_text(encoding="utf-8")
OVER_THE_PICTURE = ("#legend", "#labels", "#tools", "#tip", "#toggles", ".dark", "#scale")


def parsed(color: str, variables: dict[str, str]) -> Floats | None:
    """Red, green, blue and opacity, 0 to 1; None of what is no plain colour, such as `transparent` or `inherit`."""
    color = re.sub(r"var\((--[\w-]+)\)", lambda found: variables[found[1]], color.strip())
    digits = re.fullmatch(r"#([0-9a-f]{3,4}|[0-9a-f]{6}|[0-9a-f]{8})", color.lower())
    if digits is None:
        return None
    text = digits[1] if len(digits[1]) > 4 else "".join(2 * digit for digit in digits[1])
    return np.array([int(text[k : k + 2], 16) / 255.0 for k in range(0, len(text), 2)] + [1.0])[:4]


def luminance(color: Floats) -> float:
    linear = np.where(color <= 0.04045, color / 12.92, ((color + 0.055) / 1.055) ** 2.4)
    return float(linear[:3] @ [0.2126, 0.7152, 0.0722])


def contrast(text: Floats, below: Floats) -> float:
    low, high = sorted((luminance(text), luminance(below)))
    return (high + 0.05) / (low + 0.05)


def rules(sheet: str) -> list[tuple[str, dict[str, str], bool]]:
    """Selectors and declarations, and whether they count in the dark alone."""
    sheet = re.sub(r"/\*.*?\*/", "", sheet, flags=re.DOTALL)
    dark = sheet.find("prefers-color-scheme: dark")
    found = []
    for rule in re.finditer(r"([^{}]+)\{([^{}]*)\}", sheet):
        pairs = (one.split(":", 1) for one in rule[2].split(";") if ":" in one)
        found.append(
            (rule[1].strip(), {name.strip(): value.strip() for name, value in pairs}, 0 <= dark < rule.start())
        )
    return found


def stage(dark: bool) -> list[Floats]:
    """Colours of the sky and of the ground below, which the picture's own text lies over."""
    light = [json.loads(re.search(rf"const {name} = (\[.*?\])[,;]", SHADERS.replace(", ZENITH", "; const ZENITH"))[1])
             for name in ("HORIZON", "ZENITH")]  # fmt: skip
    night = re.search(r"\{ horizon: (\[[\d., ]+\]), zenith: (\[[\d., ]+\]), dim: ([\d.]+) \}", SHADERS)
    ground, dim = np.array([[0.735, 0.765, 0.785], [0.76, 0.788, 0.807]]), float(night[3])
    return [
        np.array(one)
        for one in ([json.loads(night[1]), json.loads(night[2]), *(dim * ground)] if dark else [*light, *ground])
    ]


def surfaces(
    selector: str, sheet: list[tuple[str, dict[str, str], bool]], dark: bool, variables: dict[str, str]
) -> list[Floats]:
    """What a text without a background of its own may stand on."""
    if ".dark" in selector:
        return stage(dark=True)
    if selector.startswith("#legend"):
        return stage(dark=False)
    names = ("background", "background-color")
    whole = [value for name, own, at_night in sheet if at_night is dark and name in ("body", "html, body", "section")
             for key, value in own.items() if key in names]  # fmt: skip
    found = [parsed(value, variables) for value in whole]
    return [one[:3] for one in found if one is not None] or [np.ones(3)]


def texts() -> list[tuple[str, str, bool]]:
    return [
        (name, selector, dark)
        for name, sheet in SHEETS.items()
        for selector, own, dark in rules(sheet)
        if "color" in own
    ]


@pytest.mark.parametrize(("name", "selector", "dark"), texts())
def test_text_stands_out_from_what_it_is_written_on(name: str, selector: str, dark: bool):
    sheet = rules(SHEETS[name])
    variables = {key: value for _, own, _ in sheet for key, value in own.items() if key.startswith("--")}
    own = next(own for one, own, at_night in sheet if (one, at_night) == (selector, dark) and "color" in own)
    text = parsed(own["color"], variables)
    if text is None:
        assert own["color"] == "inherit"
        return
    own_ground = parsed(own.get("background", ""), variables)
    below = surfaces(selector, sheet, dark, variables)
    if own_ground is not None:  # which may be seen through, to the picture or the page
        behind = stage(dark=False) + stage(dark=True) if selector.startswith(OVER_THE_PICTURE) else below
        below = [own_ground[3] * own_ground[:3] + (1.0 - own_ground[3]) * one for one in behind]
    for one in below:
        assert contrast(text, one) >= LEAST, (selector, contrast(text, one))


def test_ink_is_read_on_every_surface_of_the_viewer():
    sheet = rules(SHEETS["viewer"])
    variables = {key: value for _, own, _ in sheet for key, value in own.items() if key.startswith("--")}
    ink, stages = parsed("var(--ink)", variables), stage(dark=False) + stage(dark=True)
    seen = 0
    for selector, own, _ in sheet:
        ground = parsed(own.get("background", ""), variables)
        if ground is None or "color" in own or selector in ("#view",):
            continue
        for behind in stages if ground[3] < 1.0 else [np.ones(3)]:
            seen += 1
            assert contrast(ink, ground[3] * ground[:3] + (1.0 - ground[3]) * behind) >= LEAST, selector
    assert seen > 10


def test_known_ratios():
    black, white, grey = np.zeros(3), np.ones(3), np.full(3, 0x76 / 255.0)
    assert contrast(black, white) == pytest.approx(21.0)
    assert contrast(grey, white) == pytest.approx(4.54, abs=0.01)  # #767676, the lightest grey that passes on white
    assert len(list(itertools.chain(texts()))) > 20
