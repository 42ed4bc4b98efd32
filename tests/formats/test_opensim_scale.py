"""Scaled models against OpenSim's own, factor by factor."""

import numpy as np
import pytest

import osim_models as small
from warpmuscle.core.errors import SceneError
from warpmuscle.formats.lines import Notes
from warpmuscle.formats.opensim_scale import scaled_model
from warpmuscle.formats.osim.read import read

MODELS = (
    "opensim_walk/subject01.osim",
    "inverse/synthetic_walk/unscaled_generic.osim",
    "inverse/static_optimization_92/subject01_simbody_adjusted_StaticOp.osim",
)


def off(one, other) -> float:
    return float(np.abs(np.asarray(one) - np.asarray(other)).max(initial=0.0))


@pytest.mark.parametrize("keep", [False, True])
@pytest.mark.parametrize("name", MODELS)
def test_everything_is_scaled_as_opensim_does(reference_data, tmp_path, name, keep):
    opensim = pytest.importorskip("opensim", reason="OpenSim is not installed")
    path = reference_data / name
    if not path.is_file():
        pytest.skip(f"no reference data: {path}")
    opensim.Logger.setLevelString("off")
    theirs = opensim.Model(str(path))
    random, factors, scales = np.random.default_rng(1), {}, opensim.ScaleSet()
    for k in range(theirs.getBodySet().getSize()):
        body = theirs.getBodySet().get(k).getName()
        factors[body] = random.uniform(0.8, 1.25, 3) if k % 4 else np.full(3, random.uniform(0.8, 1.25))
        scale = opensim.Scale()
        scale.setSegmentName(body)
        scale.setScaleFactors(opensim.Vec3(*factors[body]))
        scale.setApply(True)
        scales.cloneAndAppend(scale)
    theirs.scale(theirs.initSystem(), scales, keep, 70.0)
    theirs.printToXML(str(tmp_path / "theirs.osim"))
    expected = read(tmp_path / "theirs.osim", Notes())
    found = scaled_model(read(path, Notes()), factors, 70.0, keep)
    for key, frame in found.frames.items():
        assert off(frame.translation, expected.frames[key].translation) < 1e-9, key
    for one, other in zip(found.bodies, expected.bodies, strict=True):
        assert off(one.center, other.center) < 1e-9, one.name
        assert one.mass == pytest.approx(other.mass)
        assert off(one.inertia, other.inertia) < 1e-9 * max(np.abs(other.inertia).max(), 1e-9), one.name
    q = np.linspace(-0.5, 0.5, 7)
    for one, other in zip(found.joints, expected.joints, strict=True):
        for axis, their in zip(one.translations, other.translations, strict=True):
            assert off(axis.function.values(q), their.function.values(q)) < 1e-9, one.name
    for key, surface in found.surfaces.items():
        assert off(surface.sizes, expected.surfaces[key].sizes) < 1e-9, key
        assert off(surface.translation, expected.surfaces[key].translation) < 1e-9, key
    for one, other in zip(found.muscles, expected.muscles, strict=True):
        for point, their in zip(one.points, other.points, strict=True):
            assert off(point.location, their.location) < 1e-9, one.name
            for (_, own), (_, function) in zip(point.motion, their.motion, strict=True):
                assert off(own.values(q), function.values(q)) < 1e-9, one.name
    for one, other in zip(found.markers, expected.markers, strict=True):
        assert off(one.location, other.location) < 1e-9, one.name


def test_a_body_of_one_size_keeps_its_shape(tmp_path):
    model = read(small.written(tmp_path, small.pendulum()), Notes())
    found = scaled_model(model, {"rod": np.full(3, 2.0)})
    assert found.bodies[0].mass == pytest.approx(8.0 * model.bodies[0].mass)
    assert found.bodies[0].inertia == pytest.approx(32.0 * model.bodies[0].inertia)
    assert model.bodies[0].mass == 1.0


@pytest.mark.parametrize(
    ("factors", "message"),
    [({"arm": np.ones(3)}, "'arm', which the model does not have"), ({"rod": np.zeros(3)}, "positive factors"),
     ({"rod": np.array([1.0, np.nan, 1.0])}, "positive factors")],
)  # fmt: skip
def test_factors_that_no_body_can_have_are_refused(tmp_path, factors, message):
    model = read(small.written(tmp_path, small.pendulum()), Notes())
    with pytest.raises(SceneError, match=message):
        scaled_model(model, factors)
