"""Colours of activation go from blue to red in equal steps that every eye tells apart, and none is dark."""

import itertools
import json
import re
from importlib.resources import files

import numpy as np
import pytest

from warpmuscle.core.array_types import Floats

# Linear sRGB to Oklab, and the sight of people without one kind of cones, in linear sRGB: Ottosson (2020), "A
# perceptual color space for image processing"; Machado, Oliveira and Fernandes (2009), severity 1.
TO_CONES = np.array([[0.4122214708, 0.5363325363, 0.0514459929], [0.2119034982, 0.6806995451, 0.1073969566],
                     [0.0883024619, 0.2817188376, 0.6299787005]])  # fmt: skip
TO_LAB = np.array([[0.2104542553, 0.7936177850, -0.0040720468], [1.9779984951, -2.4285922050, 0.4505937099],
                   [0.0259040371, 0.7827717662, -0.8086757660]])  # fmt: skip
PROTANOPIA = np.array(
    [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]]
)
DEUTERANOPIA = np.array(
    [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]]
)


RAMPS = {"red": 0, "yellow": 1}


def stops(ramp: str) -> Floats:
    text = (files("warpmuscle.view") / "assets" / "renderer.js").read_text(encoding="utf-8")
    return np.array(json.loads(re.search(r"const ACTIVATIONS = (\[.*\]);", text)[1])[RAMPS[ramp]])


def linear(colours: Floats) -> Floats:
    return np.where(colours <= 0.04045, colours / 12.92, ((colours + 0.055) / 1.055) ** 2.4)


def oklab(light: Floats) -> Floats:
    return np.cbrt(np.clip(light, 0.0, 1.0) @ TO_CONES.T) @ TO_LAB.T


@pytest.mark.parametrize("ramp", RAMPS)
def test_steps_are_equal_and_each_is_lighter(ramp):
    seen = oklab(linear(stops(ramp)))
    step = np.linalg.norm(np.diff(seen, axis=0), axis=1)
    assert np.ptp(step) < 0.05 * step.mean()
    assert (np.diff(seen[:, 0]) > 0.02).all()


@pytest.mark.parametrize("ramp", RAMPS)
def test_rest_is_blue_full_activation_red_or_yellow_and_nothing_is_dark(ramp):
    first, last = stops(ramp)[[0, -1]]
    assert first.argmax() == 2
    assert last.argmax() == 0
    assert oklab(linear(stops(ramp)))[:, 0].min() > 0.44  # black is 0, white 1


@pytest.mark.parametrize("ramp", RAMPS)
def test_who_lacks_a_kind_of_cones_tells_the_stops_apart(ramp):
    for sight in (PROTANOPIA, DEUTERANOPIA):
        seen = oklab(linear(stops(ramp)) @ sight.T)
        for one, other in itertools.combinations(range(len(seen)), 2):  # 0.02 is just seen
            assert np.linalg.norm(seen[one] - seen[other]) > 0.04 * (other - one), (one, other)
