"""Inverse kinematics on arrays and files, against known motions, published results and OpenSim."""

import warnings
from dataclasses import replace

import numpy as np
import pytest

import warpmuscle as wm
from leg_model import chain_of, leg, markers_of, walk
from recorded_markers import trc_text
from warpmuscle.core.errors import ArgumentError, SignalError
from warpmuscle.formats.external_loads import TO_OPENSIM
from warpmuscle.inverse import kinematics, recorded_markers
from warpmuscle.inverse.files import angle_names, read_coordinates
from warpmuscle.inverse.marker_checks import Doubts, doubts
from warpmuscle.inverse.trial import Markers, TrialWarning


@pytest.fixture(scope="module")
def scene(tmp_path_factory):
    return leg(tmp_path_factory.mktemp("leg"))


@pytest.fixture(scope="module")
def chain(scene):
    return chain_of(scene)


def test_a_motion_comes_back_with_all_coordinates_and_its_times(scene, chain):
    values = walk(chain)
    found = wm.inverse_kinematics(scene, markers_of(chain, values), device="cpu")
    assert found.coordinates.names == (*chain.coordinates, "beta")
    assert found.coordinates.times[0] == 2.0
    assert np.abs(found.coordinates.values[:, :-1] - values).max() < 2e-5
    assert found.rms.max() < 1e-5
    assert found.notes == ()


def test_errors_are_in_ground_axes(scene, chain):
    markers = markers_of(chain, walk(chain))
    markers.positions[:, 0] += [0.0, 0.0, 0.05]
    found = wm.inverse_kinematics(scene, markers, {name: 1e-6 if name == "pelvis0" else 1.0 for name in markers.names})
    assert np.abs(found.errors[:, 0] - [0.0, 0.0, 0.05]).max() < 1e-4
    assert found.marker_rms["pelvis0"] == pytest.approx(0.05, abs=1e-4)


def test_several_recordings_at_once_are_as_each_alone(scene, chain):
    trials = [markers_of(chain, walk(chain, n, seed=n), noise=0.01) for n in (5, 33, 50, 21, 8)]
    trials[1] = Markers(trials[1].names[:-2], trials[1].times, trials[1].positions[:, :-2])  # with others
    trials[3].positions[:, 2] = np.nan  # never seen
    trials[4].positions[0, 2] = np.nan  # seen later
    together = wm.inverse_kinematics(scene, trials, device="cpu")
    for one, trial in zip(together, trials, strict=True):
        alone = wm.inverse_kinematics(scene, trial, device="cpu")
        assert one.coordinates.values.tobytes() == alone.coordinates.values.tobytes()


def test_gaps_are_bridged_and_told(scene, chain):
    values = walk(chain, 60)
    markers = markers_of(chain, values)
    markers.positions[20:24] = np.nan
    markers.positions[:3] = np.nan
    markers.positions[40:45, [k for k, name in enumerate(markers.names) if name.startswith("foot")]] = np.nan
    with pytest.warns(TrialWarning, match="markers that tell ankle are missing in 5 frames, the first is number 41"):
        found = wm.inverse_kinematics(scene, markers)
    off = np.abs(found.coordinates.values[:, :-1] - values)
    assert off[3:20].max() < 1e-4
    assert off[24:40].max() < 1e-4
    assert off[20:24].max() < 0.1
    assert np.isfinite(found.coordinates.values).all()
    assert np.isnan(found.rms[:3]).all()
    every = np.arange(60)
    places = chain.places(chain.poses(found.coordinates.values[:, :-1]), list(chain.markers.values()))
    assert np.abs(found.modelled(every) - places @ TO_OPENSIM.T).max() < 1e-5


def test_a_marker_that_jumps_in_some_frames_is_named(scene, chain):
    markers = markers_of(chain, walk(chain, 60), noise=0.005)
    one = markers.names.index("tibia0")
    markers.positions[[31, 44], one, 1] += 0.4
    with pytest.warns(TrialWarning, match="tibia0: off by .* cm in 2 frames, the first is number 32"):
        found = wm.inverse_kinematics(scene, markers)
    assert len(found.notes) == 1


def test_a_closer_look_finds_no_more_than_where_sums_leave_doubt(scene, chain, monkeypatch):
    random, trials = np.random.default_rng(3), []
    for k in range(40):
        markers = markers_of(chain, walk(chain, 30 + k % 2, seed=k), noise=0.01)
        rows = random.choice(30, random.integers(1, 30), replace=False)
        one = random.integers(len(markers.names))
        markers.positions[rows, one] += random.normal(size=3) * random.uniform(0.1, 0.6)
        markers.positions[random.choice(30, 3), random.integers(len(markers.names))] = np.nan
        trials.append(markers)
    trials[7] = replace(trials[7], positions=trials[7].positions * [1.0, -1.0, -1.0])
    trials[9].positions[4:6] = np.nan
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", TrialWarning)
        found = wm.inverse_kinematics(scene, trials, device="cpu")
        looked = []

        def every(*given):
            found = doubts(*given)
            looked.append(found.any)
            return Doubts(*(np.ones_like(each) for each in found))

        monkeypatch.setattr(kinematics, "doubts", every)
        closer = wm.inverse_kinematics(scene, trials, device="cpu")
    assert [one.notes for one in found] == [one.notes for one in closer]
    noted = [bool(one.notes) for one in closer]
    assert 5 < sum(noted) <= looked[0].sum() < 38


def test_sums_over_a_recording_are_the_same_whole_and_in_pieces(scene, chain, monkeypatch):
    trials = [markers_of(chain, walk(chain, frames, seed=frames), noise=0.01) for frames in (4, 12, 17)]
    trials[2].positions[3:9, 1] = np.nan
    trials[1].positions[5, 2] += 0.3
    looked = []

    def looking(chain, names, fit, starts):
        looked.append(fit.sums)
        return doubts(chain, names, fit, starts)

    monkeypatch.setattr(kinematics, "doubts", looking)
    monkeypatch.setattr(recorded_markers, "PIECE", 5)
    with warnings.catch_warnings(action="ignore", category=TrialWarning):
        found = wm.inverse_kinematics(scene, trials, device="cpu")
    order = [trials[0].names.index(name) for name in found[0].markers]
    for k, (one, trial) in enumerate(zip(found, trials, strict=True)):
        squares = np.square(one.errors).sum(axis=2)
        near = ~((recorded_markers.SUDDEN * (1.0 - recorded_markers.NEAR)) ** 2 * squares >= np.nanmax(squares, axis=0))
        seen, height = np.isfinite(squares), np.nansum(trial.positions[:, order, 1], axis=0)
        most, close = np.nanmax(squares, axis=0), (near & seen).sum(axis=0)
        expected = (np.nansum(squares, axis=0), height, seen.sum(axis=0), most, close)
        for sums, wanted in zip(looked[0], expected, strict=True):
            np.testing.assert_allclose(sums[k], wanted, rtol=1e-12)


def test_swapped_labels_are_named(scene, chain):
    markers = markers_of(chain, walk(chain))
    a, b = markers.names.index("tibia0"), markers.names.index("pelvis3")
    markers.positions[:, [a, b]] = markers.positions[:, [b, a]]
    with pytest.warns(TrialWarning, match="swapped") as told:
        wm.inverse_kinematics(scene, markers)
    assert any("tibia0" in str(one.message) and "pelvis3" in str(one.message) for one in told)


def test_coordinates_without_markers_are_named(scene, chain):
    markers = markers_of(chain, walk(chain))
    weights = {name: 1.0 for name in markers.names if not name.startswith("foot")}
    with pytest.warns(TrialWarning, match="no marker tells ankle"):
        wm.inverse_kinematics(scene, markers, weights)


@pytest.mark.parametrize(
    ("factor", "unit"), [(1000.0, "in mm"), (0.001, "rather than in mm"), (100.0, "in cm"), (1 / 0.3048, "in ft")]
)
def test_another_unit_is_one_line(scene, chain, factor, unit):
    markers = markers_of(chain, walk(chain))
    with pytest.raises(SignalError, match=unit):
        wm.inverse_kinematics(scene, replace(markers, positions=factor * markers.positions))


def test_what_cannot_be_fitted_is_one_line(scene, chain):
    markers = markers_of(chain, walk(chain, 5))
    others = Markers(tuple(f"m{k}" for k in range(len(markers.names))), markers.times, markers.positions)
    with pytest.raises(SignalError, match="0 markers of a weight in both the model and the recording"):
        wm.inverse_kinematics(scene, others)
    with pytest.raises(SignalError, match="'nose', which neither"):
        wm.inverse_kinematics(scene, markers, {"nose": 1.0})
    with pytest.raises(SignalError, match="must be 0 or more, not -1"):
        wm.inverse_kinematics(scene, markers, {"pelvis0": -1.0})
    few = replace(markers, positions=np.full_like(markers.positions, np.nan))
    few.positions[:, :2] = 0.1
    with pytest.raises(SignalError, match="2 markers"):
        wm.inverse_kinematics(scene, few)
    with pytest.raises(ArgumentError, match="has no markers"):
        wm.inverse_kinematics("fwalk", markers)
    with pytest.raises(ArgumentError, match="one recording at least"):
        wm.inverse_kinematics(scene, [])


def test_a_file_is_read_fitted_and_written(scene, chain, tmp_path):
    values = walk(chain)
    path = tmp_path / "walk.trc"
    path.write_text(trc_text(markers_of(chain, values)))
    found = wm.inverse_kinematics(scene, path)
    for name in ("ik.mot", "ik.csv", "ik.sto"):
        found.write(tmp_path / name)
        again = read_coordinates(tmp_path / name, scene)
        assert again.names == found.coordinates.names
        assert np.abs(again.values - found.coordinates.values).max() < 1e-7
        assert again.times == pytest.approx(found.coordinates.times)
    found.write_errors(tmp_path / "errors.sto")
    lines = (tmp_path / "errors.sto").read_text().splitlines()
    assert lines[6].split("\t")[:5] == [
        "time",
        "total_squared_error",
        "marker_error_RMS",
        "marker_error_max",
        "pelvis0",
    ]


SETUP = """<?xml version="1.0"?><OpenSimDocument Version="40000"><InverseKinematicsTool><time_range>2.1 2.2</time_range>
<IKTaskSet><objects><IKMarkerTask name="pelvis0"><apply>false</apply><weight>1</weight></IKMarkerTask>{markers}
<IKCoordinateTask name="adduction"><weight>5</weight><value_type>manual_value</value_type><value>0.2</value>
</IKCoordinateTask><IKCoordinateTask name="beta"><weight>5</weight></IKCoordinateTask>
</objects></IKTaskSet></InverseKinematicsTool></OpenSimDocument>"""


def test_a_set_up_gives_weights_tasks_and_times(scene, chain, tmp_path):
    markers = markers_of(chain, walk(chain))
    tasks = "".join(f'<IKMarkerTask name="{n}"><weight>2</weight></IKMarkerTask>' for n in markers.names[1:])
    (tmp_path / "ik.xml").write_text(SETUP.format(markers=tasks))
    found = wm.inverse_kinematics(scene, markers, setup=tmp_path / "ik.xml")
    assert found.markers == markers.names[1:]
    assert found.coordinates.times == pytest.approx(np.linspace(2.1, 2.2, 11))
    assert np.abs(found.coordinates.of("adduction") - 0.2).max() < 0.1
    assert np.abs(walk(chain)[10:21, chain.coordinates.index("adduction")] - 0.2).max() > 0.1
    (tmp_path / "between.xml").write_text(SETUP.format(markers=tasks).replace("2.1 2.2", "2.096 2.204"))
    nearest = wm.inverse_kinematics(scene, markers, setup=tmp_path / "between.xml")  # as OpenSim has it
    assert nearest.coordinates.times == pytest.approx(found.coordinates.times)
    (tmp_path / "late.xml").write_text(SETUP.format(markers=tasks).replace("2.1 2.2", "7 8"))
    with pytest.raises(SignalError, match="no frame lies within the range of times from 7 to 8 s"):
        wm.inverse_kinematics(scene, markers, setup=tmp_path / "late.xml")


def test_the_published_walk_is_fitted_as_by_opensim(reference_data):
    folder = reference_data / "opensim_walk"
    if not folder.is_dir():
        pytest.skip(f"no reference data: {folder}")
    scene = wm.load(folder / "subject01.osim", ignored=[])
    found = wm.inverse_kinematics(scene, folder / "subject01_walk.trc", setup=folder / "ik" / "walk_Setup_IK.xml")
    published = read_coordinates(folder / "ik" / "subject01_walk_IK.mot", scene)
    assert found.coordinates.times == pytest.approx(published.times, abs=1e-7)
    for name in published.names:
        off = np.abs(found.coordinates.of(name) - published.of(name)).max()
        assert off < (np.radians(0.06) if name in angle_names(scene) else 0.003), name  # their accuracy was 1e-5


@pytest.mark.parametrize("subject", ["subject01", "subject02"])
def test_a_known_walk_of_a_known_subject_comes_back(reference_data, subject):
    folder = reference_data / "inverse" / "synthetic_walk" / subject
    if not folder.is_dir():
        pytest.skip(f"no reference data: {folder}")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        scene = wm.load(folder / f"{subject}.osim", ignored=[])
    found = wm.inverse_kinematics(scene, folder / "markers.trc")
    truth = read_coordinates(folder / "coordinates.sto", scene, degrees=False)
    for name in truth.names:
        if name in angle_names(scene):
            assert np.degrees(np.abs(found.coordinates.of(name) - truth.of(name)).max()) < 0.002, name
    assert found.rms.max() < 1e-5


TASKS = """<IKCoordinateTask name="lumbar_extension"><weight>0.01</weight><value_type>manual_value</value_type>
<value>0.2</value></IKCoordinateTask><IKCoordinateTask name="ankle_angle_r"><weight>1e-3</weight>
<value_type>default_value</value_type></IKCoordinateTask>"""


@pytest.mark.parametrize("tasks", ["", TASKS], ids=["markers", "tasks"])
def test_opensim_comes_to_the_same_once_it_is_exact_enough(reference_data, tmp_path, tasks):
    opensim = pytest.importorskip("opensim", reason="OpenSim is not installed")
    folder = reference_data / "opensim_walk"
    if not folder.is_dir():
        pytest.skip(f"no reference data: {folder}")
    opensim.Logger.setLevelString("off")
    scene = wm.load(folder / "subject01.osim", ignored=[])
    text, setup = (folder / "ik" / "walk_Setup_IK.xml").read_text(), tmp_path / "setup.xml"
    setup.write_text(text.replace("<objects>", f"<objects>{tasks}", 1))
    tool = opensim.InverseKinematicsTool(str(setup), False)
    model = opensim.Model(str(folder / "subject01.osim"))  # which the tool does not keep alive
    tool.setModel(model)
    tool.setMarkerDataFileName(str(folder / "subject01_walk.trc"))
    tool.setResultsDir(str(tmp_path))
    tool.setStartTime(0.0)
    tool.setEndTime(0.5)
    tool.setOutputMotionFileName(str(tmp_path / "theirs.mot"))
    tool.set_report_errors(False)
    tool.set_accuracy(1e-9)
    tool.run()
    theirs = read_coordinates(tmp_path / "theirs.mot", scene)
    found = wm.inverse_kinematics(scene, folder / "subject01_walk.trc", setup=setup)
    count = len(theirs.times)
    assert count > 20
    for name in theirs.names:
        assert np.abs(found.coordinates.of(name)[:count] - theirs.of(name)).max() < np.radians(0.01), name
