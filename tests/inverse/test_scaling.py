"""Scaling by measurements against OpenSim's ScaleTool, and by all frames against known subjects."""

import warnings
from pathlib import Path

import numpy as np
import pytest

import warpmuscle as wm
from leg_model import chain_of, leg, leg_text, markers_of, walk
from opensim_table import table
from recorded_markers import trc_text
from warpmuscle.core.errors import ArgumentError, SceneError, SignalError
from warpmuscle.formats.external_loads import TO_OPENSIM
from warpmuscle.formats.lines import Notes
from warpmuscle.formats.opensim_scale import scaled_model
from warpmuscle.formats.osim.build import build
from warpmuscle.formats.osim.read import read
from warpmuscle.inverse.files import angle_names, read_coordinates
from warpmuscle.inverse.loads import read_loads
from warpmuscle.inverse.size_fit import fit_sizes
from warpmuscle.inverse.sized_chain import SizedChain, Sizes, grouped
from warpmuscle.inverse.trial import Markers, TrialWarning
from warpmuscle.simulation.devices import find_device

TRUE = {"pelvis": (1.1, 0.95, 1.2), "femur": (1.05, 1.15, 0.9), "tibia": (0.95, 1.1, 1.05), "foot": (1.2, 1.0, 1.1)}


@pytest.fixture(scope="module")
def model(tmp_path_factory) -> Path:
    path = tmp_path_factory.mktemp("leg") / "generic.osim"
    path.write_text(leg_text())
    return path


@pytest.fixture(scope="module")
def subject(model):
    """The chain of a subject whose size is known."""
    record = scaled_model(read(model, Notes()), {name: np.array(factor) for name, factor in TRUE.items()})
    return chain_of(build(record, Notes()))


def test_derivatives_by_sizes_and_places_are_differences(model):
    record = read(model, Notes())
    chain = SizedChain(record, [marker.name for marker in record.markers], symmetric=False)
    random = np.random.default_rng(0)
    sizes = Sizes(random.uniform(0.8, 1.2, (5, 3)), random.uniform(-0.02, 0.02, (14, 3)))
    own = chain.chain(sizes)
    q = walk(own, 4)
    places = [own.markers[name] for name in chain.markers]
    at = own.places(own.poses(q), places)
    by_size, by_place = chain.by_factor(own.poses(q), q), chain.by_offset(own.poses(q))
    for group, axis in ((0, 0), (1, 1), (2, 2), (4, 0)):
        moved = Sizes(sizes.factors.copy(), sizes.offsets)
        moved.factors[group, axis] += 0.1
        other = chain.chain(moved)
        change = other.places(other.poses(q), [other.markers[name] for name in chain.markers]) - at
        assert np.abs(change - 0.1 * by_size[..., 3 * group + axis]).max() < 1e-12
    moved = Sizes(sizes.factors, sizes.offsets.copy())
    moved.offsets[3, 1] += 0.1
    other = chain.chain(moved)
    change = other.places(other.poses(q), [other.markers[name] for name in chain.markers]) - at
    assert np.abs(change[:, 3] - 0.1 * by_place[:, 3, :, 1]).max() < 1e-12


def test_left_and_right_share_factors():
    assert grouped(["pelvis", "femur_r", "femur_l", "torso"], True) == [["pelvis"], ["femur_r", "femur_l"], ["torso"]]
    assert len(grouped(["femur_r", "femur_l"], False)) == 2


def test_sizes_come_back_from_the_markers_of_a_walk(model, subject):
    values = walk(subject, 60)
    found = wm.scale(model, markers_of(subject, values), device="cpu")
    for body in ("femur", "tibia"):
        assert found.factors[body] == pytest.approx(TRUE[body], abs=0.05)
    assert found.rms < 1e-4
    kinematics = wm.inverse_kinematics(found.scene, markers_of(subject, values), device="cpu")
    off = np.abs(kinematics.coordinates.values[:, :-1] - values)
    assert np.degrees(np.delete(off, [3, 4, 5], axis=1)).max() < 1.0


def test_markers_are_found_where_the_subject_wears_them(model, subject):
    markers = markers_of(subject, walk(subject, 60))
    k = markers.names.index("tibia2")
    record = read(model, Notes())
    chain = SizedChain(record, list(markers.names), symmetric=True)
    turned = chain.by_offset(subject.poses(walk(subject, 60)))[:, k] @ [0.0, 0.0, 0.02]
    markers.positions[:, k] += turned @ TO_OPENSIM.T
    found = fit_sizes(chain, markers.positions @ TO_OPENSIM, np.ones(14), np.ones(14, bool), find_device("cpu"))
    assert found.sizes.offsets[k] == pytest.approx([0.0, 0.0, 0.02], abs=0.008)
    assert np.sqrt(np.mean(found.fit.errors**2)) < 1e-3
    still = fit_sizes(chain, markers.positions @ TO_OPENSIM, np.ones(14), np.zeros(14, bool), find_device("cpu"))
    assert np.abs(still.sizes.offsets).max() < 1e-6


SETUP = """<?xml version="1.0"?>
<OpenSimDocument Version="40000"><ScaleTool name="s"><mass>60</mass><age>30</age>
<GenericModelMaker><model_file>generic.osim</model_file></GenericModelMaker>
<ModelScaler><apply>true</apply><scaling_order>measurements manualScale</scaling_order>
<MeasurementSet><objects>
<Measurement name="pelvis_width"><apply>true</apply><MarkerPairSet><objects>
<MarkerPair><markers>pelvis0 pelvis1</markers></MarkerPair><MarkerPair><markers>pelvis1 pelvis2</markers></MarkerPair>
</objects></MarkerPairSet><BodyScaleSet><objects><BodyScale name="pelvis"><axes>X Z</axes></BodyScale></objects>
</BodyScaleSet></Measurement>
<Measurement name="thigh"><apply>true</apply><MarkerPairSet><objects><MarkerPair><markers>femur0 femur2</markers>
</MarkerPair></objects></MarkerPairSet><BodyScaleSet><objects><BodyScale name="femur"><axes>X Y Z</axes></BodyScale>
<BodyScale name="patella"><axes>Y</axes></BodyScale></objects></BodyScaleSet></Measurement>
</objects></MeasurementSet>
<ScaleSet><objects><Scale><scales>1.1 1.05 0.95</scales><segment>tibia</segment><apply>true</apply></Scale></objects>
</ScaleSet><marker_file>static.trc</marker_file><time_range>1.996 2.193</time_range>
<preserve_mass_distribution>true</preserve_mass_distribution><output_model_file>scaled.osim</output_model_file>
</ModelScaler>
<MarkerPlacer><apply>true</apply><IKTaskSet><objects>{tasks}
<IKCoordinateTask name="adduction"><apply>true</apply><weight>1</weight><value_type>manual_value</value_type>
<value>0.1</value></IKCoordinateTask>
</objects></IKTaskSet><marker_file>static.trc</marker_file><time_range>1.996 2.193</time_range>
<output_model_file>placed.osim</output_model_file><output_motion_file>pose.mot</output_motion_file>
<max_marker_movement>-1</max_marker_movement></MarkerPlacer></ScaleTool></OpenSimDocument>"""


@pytest.fixture(scope="module")
def setup(model, subject):
    """A set-up beside the model, with a static trial."""
    still = np.repeat(0.3 * walk(subject, 2)[:1], 21, axis=0)
    still[:, subject.coordinates.index("turn")] = 0.2
    markers = markers_of(subject, still, noise=0.002)
    (model.parent / "static.trc").write_text(trc_text(markers))
    tasks = "".join(
        f'<IKMarkerTask name="{name}"><apply>true</apply><weight>{1 + k % 3}</weight></IKMarkerTask>'
        for k, name in enumerate(markers.names)
    )
    path = model.parent / "scale.xml"
    path.write_text(SETUP.format(tasks=tasks))
    return path, markers


def test_a_set_up_scales_as_opensims_scale_tool(model, setup, monkeypatch):
    opensim = pytest.importorskip("opensim", reason="OpenSim is not installed")
    opensim.Logger.setLevelString("off")
    path, _ = setup
    monkeypatch.chdir(model.parent)
    tool = opensim.ScaleTool(str(path))
    tool.getGenericModelMaker().setModelFileName("generic.osim")
    assert tool.run()
    theirs = read(model.parent / "placed.osim", Notes())
    found = wm.scale(model, model.parent / "static.trc", setup=path)
    assert found.mass == pytest.approx(60.0)
    expected = build(theirs, Notes())
    for name, body in expected.character.bodies.items():
        own = found.scene.character.bodies[name]
        assert own.mass == pytest.approx(body.mass, rel=1e-9)
        assert own.inertia == pytest.approx(body.inertia, rel=1e-6, abs=1e-9)
    for name, joint in expected.character.joints.items():
        own = found.scene.character.joints[name]
        assert own.position_in_parent == pytest.approx(joint.position_in_parent, abs=1e-7)
    for name, marker in expected.opensim.markers.items():  # as exact as their fit of the pose, which costs 1.4 % more
        assert found.scene.opensim.markers[name].position == pytest.approx(marker.position, abs=2e-3), name


def test_two_recordings_of_a_set_up_are_told_of(model, setup):
    path, markers = setup
    text = path.read_text()
    other = path.with_name("two.xml")
    first = text.index("static.trc")
    other.write_text(text[: first + 10] + text[first + 10 :].replace("static.trc", "second.trc"))
    with pytest.warns(
        TrialWarning, match=r"the scaler has static\.trc, the placer second\.trc; here one recording serves both"
    ):
        wm.scale(model, markers, setup=other)


def test_a_scaled_model_can_be_saved_and_loaded(model, setup, tmp_path):
    path, markers = setup
    found = wm.scale(model, markers, setup=path, mass=70.0, keep_mass_distribution=False)
    assert found.mass == pytest.approx(70.0)
    wm.save(found.scene, tmp_path / "subject.osim")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        again = wm.load(tmp_path / "subject.osim", ignored=[])
    own, other = (wm.inverse_kinematics(scene, markers).coordinates for scene in (found.scene, again))
    for name in ("flexion", "adduction", "rotation", "knee", "ankle"):
        assert np.abs(own.of(name) - other.of(name)).max() < 1e-4


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("pelvis0 pelvis1", "pelvis0 nose"), "marker 'nose', which the model does not have"),
        (("pelvis0 pelvis1", "pelvis0 pelvis0"), "at the same place"),
        (("pelvis0 pelvis1", "pelvis0"), "needs the names of two markers, has 1"),
        (('BodyScale name="femur"', 'BodyScale name="arm"'), "body 'arm', which the model does not have"),
        (("<axes>Y", "<axes>W"), "its axes are some of X Y Z, not 'W'"),
        (("1.1 1.05 0.95", "1.1 0 0.95"), "positive factors"),
        (("measurements manualScale", "guess"), "scaling_order knows measurements and manualScale, not 'guess'"),
        (("1.996 2.193", "5 6"), "no frame lies within the range of times from 5 to 6 s"),
        (("1.996 2.193", "3 2"), "runs from 3 back to 2 s"),
        (("<ScaleTool", "<OtherTool"), "sound XML"),
        (("<mass>60", "<mass>sixty"), "'sixty' is not a number"),
    ],
)
def test_a_damaged_set_up_is_one_line(model, setup, tmp_path, change, message):
    path, markers = setup
    other = tmp_path / "scale.xml"
    other.write_text(path.read_text().replace(*change))
    with pytest.raises((SceneError, SignalError), match=message) as error:
        wm.scale(model, markers, setup=other)
    assert str(other) in str(error.value)


def test_what_cannot_be_scaled_is_one_line(model, setup, tmp_path):
    _, markers = setup
    with pytest.raises(ArgumentError, match=r"an OpenSim model, \.osim"):
        wm.scale("fwalk", markers)
    with pytest.raises(ArgumentError, match="greater than 0 kg"):
        wm.scale(model, markers, mass=-1.0)
    with pytest.raises(ArgumentError, match="one recording at least"):
        wm.scale(model, [])
    with pytest.raises(SceneError, match="no such file"):
        wm.scale(tmp_path / "none.osim", markers)
    with pytest.raises(SignalError, match="0 markers of a weight"):
        wm.scale(model, Markers(("a", "b"), np.zeros(1), np.zeros((1, 2, 3))))
    with pytest.raises(SignalError, match="in mm"):
        wm.scale(model, Markers(markers.names, markers.times, 1000.0 * markers.positions))


def test_a_leg_is_read_as_it_was_written(tmp_path):
    assert len(leg(tmp_path).opensim.markers) == 14


@pytest.mark.parametrize(("subject", "mass"), [("subject01", 72.84), ("subject02", 76.48)])
def test_a_generic_model_and_a_walk_give_the_angles_and_moments_of_the_subject(reference_data, subject, mass):
    folder = reference_data / "inverse" / "synthetic_walk"
    if not folder.is_dir():
        pytest.skip(f"no reference data: {folder}")
    found = wm.scale(folder / "unscaled_generic.osim", folder / subject / "markers.trc", mass=mass)
    kinematics = wm.inverse_kinematics(found.scene, folder / subject / "markers.trc").coordinates
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        truth = read_coordinates(folder / subject / "coordinates.sto", found.scene, degrees=False)
        moments = wm.inverse_dynamics(found.scene, kinematics, read_loads(folder / subject / "grf.mot"))
    assert found.mass == pytest.approx(mass)
    for name in set(chain_of(found.scene).coordinates) & angle_names(found.scene):
        assert np.degrees(np.abs(kinematics.of(name) - truth.of(name)).max()) < 1.0, name
    _, names, rows = table(folder / subject / "id.sto")
    legs = [name for name in moments.names if name.startswith(("hip_", "knee_angle", "ankle_")) and "beta" not in name]
    assert len(legs) == 10
    for name in legs:
        wanted = rows[:, names.index(f"{name}_moment")]
        away = np.interp(rows[:, 0], moments.times, moments.of(name)) - wanted
        assert np.sqrt(np.mean(away**2)) < 0.05 * np.abs(wanted).max(), name


def test_bodies_keep_their_parts_of_a_mass_that_is_told_and_else_go_with_their_volumes(model, subject):
    markers = markers_of(subject, walk(subject, 20))
    told, untold = wm.scale(model, markers, mass=70.0, device="cpu"), wm.scale(model, markers, device="cpu")
    usual = {body.name: body.mass for body in read(model, Notes()).bodies}
    for name, mass in usual.items():
        assert told.scene.character.bodies[name].mass == pytest.approx(70.0 * mass / sum(usual.values()), rel=1e-6)
        volume = float(np.prod(untold.factors[name]))
        assert untold.scene.character.bodies[name].mass == pytest.approx(volume * mass, rel=1e-6)
