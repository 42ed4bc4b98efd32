"""What fells a gait: the disturbances of a judgement, each by itself, with the numbers that the manual names."""

import numpy as np

from warpmuscle.formats import load
from warpmuscle.simulation.perturbations import Perturbations
from warpmuscle.studies.single_disturbances import felled_by
from warpmuscle.studies.walkers import Walks


class Unmoved:
    """A walker that keeps what it was to bear; slopes of 2 degrees upwards fell it, and nothing else."""

    given: Perturbations

    def scene(self):
        return load("fwalk")

    def walk(self, duration: float, perturbations: Perturbations) -> Walks:
        self.given = perturbations
        falls = perturbations.slope > 0.0
        return Walks(np.where(falls, 2, 1), np.full(len(falls), duration), [])


def test_each_disturbance_comes_alone_and_as_strong_as_the_manual_says():
    walker = Unmoved()
    felled = felled_by(walker, 10.0)
    assert list(felled) == [
        "noise of 0.1 m/s", "masses +-10 %", "40 N s from the side", "40 N s from behind or in front",
        "2 degrees up", "2 degrees down",
    ]  # fmt: skip
    assert list(felled.values()) == [0, 0, 0, 0, 20, 0]
    velocity, push, slope, mass = (
        np.asarray(getattr(walker.given, name)).reshape(6, 20, *np.shape(getattr(walker.given, name))[1:])
        for name in ("velocity", "push", "slope", "mass")
    )
    assert 0.06 < velocity[0].std() < 0.14
    np.testing.assert_allclose(velocity[4], 0.2 * velocity[0])
    assert not velocity[1:4].any()
    assert 0.09 < np.abs(mass[1] - 1.0).max() <= 0.1
    assert (np.delete(mass, 1, axis=0) == 1.0).all()
    np.testing.assert_allclose(np.abs(push[2, :, 0]), 40.0)
    np.testing.assert_allclose(np.abs(push[3, :, 2]), 40.0)
    assert not push[[0, 1, 4, 5]].any()
    np.testing.assert_allclose(slope[4:], np.radians([[2.0] * 20, [-2.0] * 20]))
    assert not slope[:4].any()
