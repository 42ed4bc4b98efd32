"""Ground that is not flat in a real browser: it is drawn, and as high as that of the scene."""

import msgspec
import numpy as np
import pytest

from warpmuscle.formats import load
from warpmuscle.scene import Ground, Scene, Terrain
from warpmuscle.scene.terrain.surface import surface
from warpmuscle.scene.terrain.tiles import Rough, Stairs
from warpmuscle.view.page import ground_content
from warpmuscle.view.sources import of_scene, page_of_sights

pytestmark = pytest.mark.usefixtures("unoptimized_kernels")

STAIRS = Ground(terrain=Terrain([Stairs(0.2, count=3)], yaw=0.4, z=0.3))
BUMPS = Ground(normal=(0.0, 1.0, -0.1), height=0.2, terrain=Terrain([Rough(seed=3)], scale=2.0))


def on(ground: Ground) -> Scene:
    return msgspec.structs.replace(load("fwalk"), ground=ground, duration=0.1)


@pytest.fixture(scope="module")
def page(browser, tmp_path_factory):
    """A page of a walk on stairs, and what went wrong in it."""
    path = tmp_path_factory.mktemp("page") / "page.html"
    path.write_text(page_of_sights([of_scene(on(STAIRS), "cpu")[0]], "stairs").text)
    context = browser.new_context(viewport={"width": 640, "height": 480}, offline=True)
    opened = context.new_page()
    problems: list[str] = []
    opened.on("pageerror", lambda error: problems.append(str(error)))
    opened.goto(path.as_uri())
    opened.evaluate("warpmuscle.ready")
    opened.evaluate("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")
    yield opened, problems
    context.close()


def test_a_walk_on_stairs_is_drawn_without_an_error(page):
    opened, problems = page
    assert opened.evaluate("warpmuscle.state().pictures") > 0
    assert problems == []


@pytest.mark.parametrize("ground", [STAIRS, BUMPS, Ground(normal=(0.0, 1.0, -0.1), height=0.2)])
def test_the_page_knows_how_high_the_ground_is(page, ground: Ground):
    opened, problems = page
    places = np.random.default_rng(0).uniform(-3.0, 3.0, (200, 2))
    asked = "([ground, places]) => places.map(([x, z]) => groundHeight(ground, x, z))"
    found = np.array(opened.evaluate(asked, [ground_content(on(ground)), places.tolist()]))
    away = np.abs(found - surface(ground).height_at(*places.T))
    assert np.quantile(away, 0.97) < 1e-3  # but on steep risers, whose places are rounded
    assert problems == []


def test_shadows_fall_on_a_plane_that_lies_as_the_ground_does(page):
    opened, _ = page
    inclined = Ground(normal=(0.1, 1.0, -0.2), height=0.3)
    level = msgspec.structs.replace(inclined, terrain=Terrain([Rough()], scale=0.0))
    for ground in (inclined, level):
        plane = opened.evaluate("(ground) => shadowPlane(ground, [0.4, 1, 0.6])", ground_content(on(ground)))
        flat = surface(inclined).plane
        np.testing.assert_allclose(plane, [*flat.normal, flat.height], atol=1e-3)
