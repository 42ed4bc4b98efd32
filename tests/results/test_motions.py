"""Motions of many instances: arrays in a file, read by parts, added to; files of before they were arrays."""

import dataclasses
from pathlib import Path

import h5py
import numpy as np
import pytest

import warpmuscle as wm
from biped import random_recording
from described import assert_described
from same_values import assert_same
from warpmuscle.core.errors import ArgumentError, ResultError
from warpmuscle.plots import draw
from warpmuscle.plots.subject import Subject
from warpmuscle.results.motions import Motions
from warpmuscle.results.partial_motion import demanding, reduced
from warpmuscle.results.recorded_quantities import NAMED, QUANTITIES
from warpmuscle.results.recording import Recording
from warpmuscle.results.records import ParameterTable, Result
from warpmuscle.results.result import read, write
from warpmuscle.scene.topology import coordinate_names, coordinate_units, topology

LENGTHS = (12, 30, 1, 25)


def walker(frames: int, seed: int) -> Recording:
    """A random motion with coordinates and their units; all have the same clock."""
    rng = np.random.default_rng(seed)
    return dataclasses.replace(
        random_recording(frames, seed=seed, muscles=2), time=np.arange(frames) * 0.01,
        coordinate=rng.random((frames, 2)), speed=rng.random((frames, 2)), joint_angle=rng.random((frames, 1)),
        recorded=rng.random((frames, 1)), recorded_names=("own:height",),
        coordinate_names=("root.y", "knee"), speed_names=("root.y", "knee"), joint_angle_names=("knee",),
        coordinate_units=("m", "rad"), speed_units=("m/s", "rad/s"),
    )  # fmt: skip


def result_of(motions: tuple[Recording, ...], names: tuple[str, ...] = ()) -> Result:
    table = ParameterTable((), (), *np.zeros((4, 0)), ())
    return Result('name = "a"\n', "cpu", "simulate", 0, table, replays=motions, replay_names=names)


@pytest.fixture
def several() -> tuple[Recording, ...]:
    return tuple(walker(frames, seed) for seed, frames in enumerate(LENGTHS))


@pytest.fixture
def file(several: tuple[Recording, ...], tmp_path: Path) -> Path:
    write(tmp_path / "a.h5", result_of(several))
    return tmp_path / "a.h5"


def put_old_layout(path: Path, motions: tuple[Recording, ...], names: tuple[str, ...] = ()) -> None:
    """Put motions into a file as version 2 of the format had them: a group each, without units of coordinates."""
    write(path, result_of(()))
    with h5py.File(path, "a") as content:
        content.attrs["format_version"] = 2
        for number, motion in enumerate(motions):
            group = content.create_group(f"replay/{number}")
            if names:
                group.attrs["name"] = names[number]
            for name in NAMED.values():
                if getattr(motion, name):
                    group.create_dataset(name, data=np.array(getattr(motion, name), dtype=h5py.string_dtype()))
            for name in QUANTITIES:
                if motion[name].size:
                    group.create_dataset(name, data=motion[name])


def test_motions_of_one_body_are_arrays_and_are_read_back(file: Path, several):
    with h5py.File(file) as content:
        replay = content["replay"]
        assert not [name for name in replay if isinstance(replay[name], h5py.Group)]
        assert replay["com"].shape == (4, 30, 3)
        assert replay["frames"][()].tolist() == list(LENGTHS)
        assert np.isnan(replay["com"][2, 1:]).all()
        assert (replay["stance"][2, 1:] == -1).all()
        np.testing.assert_array_equal(replay["muscle_force"][1], several[1].muscle_force)
    assert_same(read(file).replays, several)
    assert read(file).replay_names == ()


@pytest.mark.parametrize("count", [1, 2])
def test_motions_of_a_body_without_joints_are_read_back(count: int, tmp_path: Path):
    def falling(frames: int) -> Recording:
        sizes = dict.fromkeys(NAMED, 0) | {"body": 1, "frame": frames}
        arrays = {
            name: np.ones([sizes.get(axis, len(axis.split())) for axis in about.axes])
            for name, about in QUANTITIES.items()
        }
        return Recording.of(arrays | {"time": np.arange(frames) * 0.01}, (), ("ball",))

    motions = tuple(falling(frames) for frames in (5, 3)[:count])
    write(tmp_path / "ball.h5", result_of(motions))
    for before, after in zip(motions, read(tmp_path / "ball.h5").replays, strict=True):
        assert after.body_names == ("ball",)
        for name in QUANTITIES:
            assert after[name].shape == before[name].shape, name
            assert np.array_equal(after[name], before[name]), name
        assert after.window(0.0, 0.015).frames == 2


def test_names_of_motions_are_kept(several, tmp_path: Path):
    write(tmp_path / "a.h5", result_of(several, ("a", "b", "ü", "d")))
    assert read(tmp_path / "a.h5").replay_names == ("a", "b", "ü", "d")
    assert wm.read_motions(tmp_path / "a.h5", ["com"], slice(1, 3)).names == ("b", "ü")


def test_motions_of_different_bodies_or_clocks_are_a_group_each(several, tmp_path: Path):
    later = dataclasses.replace(several[0], time=several[0].time + 0.5)
    for other in (random_recording(5), later):
        write(tmp_path / "a.h5", result_of((several[0], other)))
        with h5py.File(tmp_path / "a.h5") as content:
            assert set(content["replay"]) == {"0", "1"}
        assert_same(read(tmp_path / "a.h5").replays, (several[0], other))


@pytest.mark.parametrize("names", [(), ("a", "b", "c", "d")])
def test_files_of_before_there_were_arrays_are_read(names, several, tmp_path: Path):
    path = tmp_path / "a.h5"
    put_old_layout(path, several, names)
    plain = tuple(dataclasses.replace(one, coordinate_units=(), speed_units=()) for one in several)
    assert_same(read(path).replays, plain)
    assert read(path).replay_names == names
    found = wm.read_motions(path, ["com", "stance"])
    assert (found["com"].shape, found.names) == ((4, 30, 3), names)
    wm.append_motions(path, [plain[1]], ["e"] if names else ())
    assert_same(read(path).replays, (*plain, plain[1]))
    with h5py.File(path) as content:
        assert content["replay/com"].shape == (5, 30, 3)
        assert content.attrs["format_version"] == 3


def test_every_dataset_says_its_unit_axes_and_what_it_is(file: Path):
    assert_described(file)
    with h5py.File(file) as content:
        assert content["replay/coordinate_units"].asstr()[:].tolist() == ["m", "rad"]
        assert content["replay/com"].attrs["axes"] == "instance, frame, x y z"
        assert content["replay/muscle_force"].attrs["at"].startswith("start of the step, ")


def test_arrays_are_extendable_and_packed_by_instance(file: Path, several):
    with h5py.File(file, "a") as content:
        for name in ("com", "muscle_force", "stance"):
            dataset = content[f"replay/{name}"]
            assert dataset.maxshape[:2] == (None, None)
            assert dataset.chunks[0] == 1
        assert content["replay/time"].maxshape == content["replay/instance"].maxshape == (2**31 - 1,)
        content["replay/com"].resize((5, 30, 3))
        assert np.isnan(content["replay/com"][4]).all()


def test_added_motions_stand_behind_the_others(file: Path, several):
    longer = walker(40, 9)
    wm.append_motions(file, [longer, several[0]])
    assert_same(read(file).replays, (*several, longer, several[0]))
    with h5py.File(file) as content:
        assert np.isnan(content["replay/com"][0, 12:]).all()
        assert [axis.keys() for axis in content["replay/com"].dims] == [["instance"], ["time"], ["xyz"]]
        assert len(content["replay/time"]) == 40


def test_motions_that_do_not_fit_are_not_added(file: Path, several):
    before = file.read_bytes()
    wrong = dataclasses.replace(several[0], com=np.full((12, 3), np.nan))
    for motion, names, error, why in [
        (random_recording(5), (), ArgumentError, "another body"),
        (dataclasses.replace(several[0], time=several[0].time + 1), (), ArgumentError, "other times"),
        (several[0], ("one",), ArgumentError, "either all motions"),
        (wrong, (), ResultError, "motion 0: com holds nan"),
    ]:
        with pytest.raises(error, match=why):
            wm.append_motions(file, [motion], names)
    with pytest.raises(ResultError, match="no such file"):
        wm.append_motions(file.with_name("b.h5"), several)
    assert file.read_bytes() == before


def test_single_precision_is_kept_so(several, tmp_path: Path):
    write(tmp_path / "a.h5", result_of(several), single=True)
    with h5py.File(tmp_path / "a.h5") as content:
        assert content["replay/com"].dtype == np.float32
        assert content["replay/time"].dtype == np.float64
    for one, other in zip(read(tmp_path / "a.h5").replays, several, strict=True):
        np.testing.assert_allclose(one.com, other.com, rtol=6e-8)
        np.testing.assert_array_equal(one.time, other.time)
    write(tmp_path / "b.h5", result_of(several[:1]), single=True)
    with h5py.File(tmp_path / "b.h5") as content:
        assert content["replay/0/com"].dtype == np.float32


@pytest.mark.parametrize("count", [1, 4])
def test_some_quantities_are_kept_and_the_others_read_as_empty_arrays(count: int, several, tmp_path: Path):
    path = tmp_path / "a.h5"
    write(path, result_of(several[:count]), quantities=["muscle_force", "com"])
    for one, other in zip(read(path).replays, several[:count], strict=True):
        np.testing.assert_array_equal(one.com, other.com)
        np.testing.assert_array_equal(one.muscle_force, other.muscle_force)
        assert one.phase.shape == (0,)
        assert one.body_position.shape == (0, len(other.body_names), 3)
        without_width = {"controller_value"}
        assert set(one.missing) == set(QUANTITIES) - {"time", "muscle_force", "com"} - without_width
    again = read(path)
    write(tmp_path / "b.h5", again)
    assert_same(read(tmp_path / "b.h5").replays, again.replays)
    with pytest.raises(ArgumentError, match="the motion has no phase"):
        write(path, again, quantities=["phase"])
    with pytest.raises(ArgumentError, match="no quantity is called 'con'; did you mean 'com'"):
        write(path, result_of(several), quantities=["con"])
    assert_same(read(path), again)
    found = wm.read_motions(path)
    assert list(found.arrays) == ["com", "muscle_force"]
    np.testing.assert_array_equal(found["com"][count - 1, : LENGTHS[count - 1]], several[count - 1].com)
    with pytest.raises(ResultError, match="its motions have no phase; there are com, muscle_force"):
        wm.read_motions(path, ["phase"])


def test_motions_of_different_bodies_are_written_with_some_quantities(several, tmp_path: Path):
    other = random_recording(4)
    write(tmp_path / "a.h5", result_of((several[0], other)), quantities=["com"])
    found = read(tmp_path / "a.h5").replays
    np.testing.assert_array_equal(found[1].com, other.com)
    assert "phase" in found[0].missing


@pytest.mark.parametrize("count", [1, 4])
def test_a_quantity_that_was_lost_is_damage_though_others_were_not_kept(count: int, several, tmp_path: Path):
    for quantities in (None, ["com", "phase"]):
        write(tmp_path / "a.h5", result_of(several[:count]), quantities=quantities)
        with h5py.File(tmp_path / "a.h5", "a") as content:
            del content["replay/com" if count > 1 else "replay/0/com"]
        with pytest.raises(ResultError, match=r"damaged result file: .*com.* missing|lack com"):
            read(tmp_path / "a.h5")


def test_using_a_missing_quantity_says_which_and_where(several):
    motion = demanding(reduced(several[1], ["com", "body_position"]), "a.h5")
    assert motion.window(0.1, 0.2).com.shape == (11, 3)
    assert motion.position_of(motion.body_names[0]).shape == (30, 3)
    for use in (lambda: motion.phase, lambda: motion["phase"], lambda: motion.window(0.1).phase):
        with pytest.raises(ResultError, match=r"a.h5: the motion has no phase: it was written without, or its"):
            use()
    assert demanding(several[0], "a.h5") is several[0]


def test_tables_have_the_quantities_that_there_are_and_say_when_they_are_taken(several):
    xarray = pytest.importorskip("xarray", reason="no xarray: pip install 'warpmuscle[data]'")
    found = reduced(several[1], ["com", "foot_force_left"]).to_xarray()
    assert set(found.data_vars) == {"com", "foot_force_left", "coordinate_units", "speed_units"}
    assert found.com.attrs["at"] == "start of the step"
    assert found.foot_force_left.attrs["at"] == "over the step before"
    both = Motions.of(several).to_xarray()
    assert isinstance(both, xarray.Dataset)
    assert {name: both[name].attrs["at"] for name in ("com", "joint_torque")} == {
        "com": "start of the step", "joint_torque": "over the step"}  # fmt: skip
    pytest.importorskip("pandas", reason="no pandas: pip install 'warpmuscle[data]'")
    assert list(reduced(several[1], ["com"]).to_dataframe()) == ["com.x", "com.y", "com.z"]


@pytest.mark.parametrize("old", [False, True])
def test_one_of_many_is_read_without_the_frames_of_the_others(old: bool, several, tmp_path: Path, monkeypatch):
    path = tmp_path / "a.h5"
    if old:
        put_old_layout(path, several)
    else:
        write(path, result_of(several))
    rows = []
    get = h5py.Dataset.__getitem__

    def counted(dataset: h5py.Dataset, key: object, **further: object) -> object:
        values = get(dataset, key, **further)
        if dataset.name.endswith("/com"):
            rows.append(np.size(values) // 3)
        return values

    monkeypatch.setattr(h5py.Dataset, "__getitem__", counted)
    found = read(path, replay=3).replays
    assert sum(rows) == (25 if old else 30)
    monkeypatch.undo()
    np.testing.assert_array_equal(found[3].com, several[3].com)
    assert [one.frames for one in found] == [0, 0, 0, 25]
    assert found[0].muscle_names == several[0].muscle_names
    assert [one.frames for one in read(path, replay=9).replays] == [0, 0, 0, 0]


def test_motions_of_very_different_lengths_do_not_fill_the_file_with_nothing(tmp_path: Path):
    motions = (walker(3000, 0), *(walker(2, k) for k in range(1, 20)))
    write(tmp_path / "a.h5", result_of(motions))
    with h5py.File(tmp_path / "a.h5") as content:
        assert len(content["replay"]) == 20
        assert content["replay/1/com"].shape == (2, 3)
    assert_same(read(tmp_path / "a.h5").replays, motions)


def test_parts_of_a_file_are_read(file: Path, several):
    found = wm.read_motions(file, ["com"], slice(1, 3))
    assert (len(found), found["com"].shape) == (2, (2, 30, 3))
    np.testing.assert_array_equal(found["com"][0], several[1].com)
    assert_same(wm.read_motions(file).recording(3), several[3])
    for wrong in (slice(None, None, -1), 3):
        with pytest.raises(ArgumentError, match="instances must"):
            wm.read_motions(file, instances=wrong)


def test_xarray_opens_all_motions_at_once(file: Path, several):
    xarray = pytest.importorskip("xarray", reason="no xarray: pip install 'warpmuscle[data]'")
    pytest.importorskip("h5netcdf", reason="no h5netcdf: pip install 'warpmuscle[data]'")
    with xarray.open_dataset(file, group="replay", engine="h5netcdf") as found:
        xarray.testing.assert_equal(found.load(), Motions.of(several).to_xarray())
        np.testing.assert_array_equal(found.com.sel(instance=1, xyz="y").values, several[1].com[:, 1])


@pytest.mark.parametrize(
    ("name", "values"),
    [
        ("frames", [-1, 1, 1, 1]),
        ("frames", [1, 1, 1, 99]),
        ("frames", [1.5, 1.0, 1.0, 1.0]),
        ("frames", np.full((4, 1), 3)),
        ("com", np.zeros((3, 30, 3))),
        ("com", np.zeros(4)),
        ("time", np.zeros(30)),
        ("instance", ["a"]),
    ],
)
def test_damaged_arrays_are_refused_in_one_line(name: str, values, file: Path):
    with h5py.File(file, "a") as content:
        del content[f"replay/{name}"]
        content[f"replay/{name}"] = values
    with pytest.raises(ResultError, match=r"a.h5: damaged") as caught:
        read(file)
    assert "\n" not in str(caught.value)


def test_a_motion_among_arrays_is_drawn(tmp_path: Path):
    from small_result import march, walk_result

    whole = walk_result()
    short = march(wm.load("walk56").character, 1.1, 1.0, 26, len(whole.replays[0].muscle_names))
    clock = np.arange(401) * 0.04
    motions = (dataclasses.replace(whole.replays[0], time=clock), dataclasses.replace(short, time=clock[:26]))
    write(tmp_path / "a.h5", dataclasses.replace(whole, replays=motions))
    figure = draw(Subject(read(tmp_path / "a.h5"), path=tmp_path / "a.h5"), "dataset:/replay/1/com")
    assert figure.axes[0].get_xlabel() == "time (s)"
    assert len(figure.axes[0].lines[0].get_xdata()) == 26


def test_each_coordinate_of_a_scene_has_its_unit():
    for scene, expected in {
        "walk56": {"root.y": "m", "root.qw": "1", "lKnee": "rad", "pelvis_torso.qx": "1"},
        "throw18": {"root.z": "m", "root.turn": "rad", "elbow": "rad"},
    }.items():
        character = wm.load(scene).character
        numbered = topology(character)
        (names, speeds), (units, rates) = coordinate_names(numbered, character), coordinate_units(numbered, character)
        found = dict(zip(names, units, strict=True))
        assert {name: found[name] for name in expected} == expected
        of_root = [rate for name, rate in zip(speeds, rates, strict=True) if name in ("root.y", "root.z")]
        assert of_root == ["m/s", "m/s"]
        assert dict(zip(speeds, rates, strict=True)).get("root.wx", "rad/s") == "rad/s"
