"""Bipeds drawn together are drawn as each of them alone."""

import numpy as np
import pytest

from small_result import walk_result, walk_scene
from warpmuscle.scene.parameters import start_values, substitute
from warpmuscle.view import instances
from warpmuscle.view.instances import moments_of
from warpmuscle.view.lanes import lanes
from warpmuscle.view.sources import Sight, tracks_of

DRAWS = {
    "spheres": lambda moment: instances.solids(moment, "sphere", bones=False),
    "boxes": lambda moment: instances.solids(moment, "box", bones=False),
    "bones": lambda moment: instances.solids(moment, "cylinder", bones=True),
    "muscles": instances.muscles,
    "shafts": lambda moment: instances.arrows(moment)[0],
    "heads": lambda moment: instances.arrows(moment)[1],
    "centres": instances.mass_center,
    "desired": lambda moment: instances.desired(moment, "sphere"),
}


@pytest.fixture(scope="module")
def tracks():
    """Two of one doll, and one of another that has no muscles."""
    walk, plain = (substitute(scene, start_values(scene)) for scene in (walk_scene(), walk_scene("fwalk")))
    motion, other = walk_result().replays[0], walk_result("fwalk").replays[0]
    sights = [Sight("a", motion, walk), Sight("b", motion.window(0.5), walk), Sight("c", other, plain)]
    return tracks_of(sights)


@pytest.mark.parametrize("name", DRAWS)
def test_bipeds_together_are_each_as_alone(name: str, tracks):
    draw, frames, offsets = DRAWS[name], [3, 40, 17], lanes(3)
    together = moments_of(tracks, frames, offsets)
    assert [len(moment.com) for moment in together] == [2, 1]
    every = instances.joined([draw(moment) for moment in together])
    alone = [moments_of([tracks[k]], [frames[k]], offsets[k : k + 1])[0] for k in range(3)]
    expected = instances.joined([draw(moment) for moment in alone])
    assert len(every) > 0
    for field in ("position", "orientation", "size", "color"):
        np.testing.assert_allclose(getattr(every, field), getattr(expected, field), atol=1e-12)
