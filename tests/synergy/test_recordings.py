"""Recordings are read alike from every kind of file; what is wrong is said with file, channel and line."""

import ezc3d
import h5py
import numpy as np
import pytest
from synthetic_emg import NAMES, raw_emg, write_csv

from warpmuscle.core.errors import SignalError
from warpmuscle.synergy.recordings import read_signals

EMG = raw_emg(0.5)


def write_storage(path, rows=3, promised=3):
    path.write_text(
        f"subject\nversion=1\nnRows={promised}\nnColumns=3\ninDegrees=no\nendheader\ntime\tBIC\tTRI\n"
        + "".join(f"{0.01 * k:.2f}\t{k}\t{k * k}\n" for k in range(rows))
    )
    return path


def write_hdf5(path, **datasets):
    with h5py.File(path, "w") as file:
        for name, data in datasets.items():
            file[name] = data
    return path


def read_error(path, text=None, **options):
    if text is not None:
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
    with pytest.raises(SignalError) as caught:
        read_signals(path, **options)
    assert "\n" not in str(caught.value)
    return str(caught.value).removeprefix(str(path))


@pytest.mark.parametrize("separator", [",", ";", "\t", " "])
def test_text_gives_names_rate_start_and_values(tmp_path, separator):
    text = "time,BIC,TRI\n0.5,1,-2\n0.502,3,4\n0.504,-1,5\n".replace(",", separator)
    path = tmp_path / "emg.csv"
    path.write_text(f"# made by hand\n{text}")
    found = read_signals(path)
    assert (found.names, found.start) == (("BIC", "TRI"), 0.5)
    assert found.rate == pytest.approx(500.0)
    np.testing.assert_array_equal(found.values, [[1, -2], [3, 4], [-1, 5]])


def test_decimal_commas_are_read_where_other_characters_separate_cells(tmp_path):
    (tmp_path / "emg.csv").write_text("time;BIC\n0;0,5\n1;0,25\n")
    np.testing.assert_array_equal(read_signals(tmp_path / "emg.csv").values[:, 0], [0.5, 0.25])


def test_storage_file_is_read(tmp_path):
    assert len(read_signals(write_storage(tmp_path / "long.sto", rows=5, promised=5)).values) == 5
    found = read_signals(write_storage(tmp_path / "emg.sto"))
    assert found.names == ("BIC", "TRI")
    assert found.rate == pytest.approx(100.0)
    np.testing.assert_array_equal(found.values[:, 1], [0, 1, 4])


def test_hdf5_is_read_as_a_matrix_and_as_a_dataset_a_channel(tmp_path):
    matrix = write_hdf5(tmp_path / "a.h5", values=EMG.values, names=list(NAMES), rate=1000.0)
    channels = dict(zip(NAMES, EMG.values.T, strict=True))
    single = write_hdf5(tmp_path / "b.hdf5", time=EMG.time, **channels)
    for path in (matrix, single):
        found = read_signals(path, ["TRI", "BIC"])
        assert found.names == ("TRI", "BIC")
        assert found.rate == pytest.approx(1000.0)
        np.testing.assert_array_equal(found.values, EMG.values[:, [3, 2]])


def write_c3d(path):
    content = ezc3d.c3d()
    content["parameters"]["POINT"]["RATE"]["value"] = [100]
    content["parameters"]["POINT"]["LABELS"]["value"] = ["marker"]
    content["data"]["points"] = np.zeros((4, 1, len(EMG.values) // 10))
    content["parameters"]["ANALOG"]["RATE"]["value"] = [1000]
    content["parameters"]["ANALOG"]["LABELS"]["value"] = list(NAMES)
    content["data"]["analogs"] = EMG.values.T[None]
    content.write(str(path))
    return path


def test_c3d_gives_its_analog_channels(tmp_path):
    found = read_signals(write_c3d(tmp_path / "emg.c3d"), ["BIC"])
    assert (found.names, found.rate) == (("BIC",), 1000.0)
    np.testing.assert_allclose(found.values[:, 0], EMG.values[:, 2], rtol=1e-6)


def test_c3d_that_is_cut_off_or_damaged_is_said(tmp_path):
    whole = write_c3d(tmp_path / "emg.c3d").read_bytes()
    assert read_error(tmp_path / "cut.c3d", whole[:-5000]) == ": is truncated: holds 33 of 50 frames"
    early = read_error(tmp_path / "early.c3d", whole[:784])  # ezc3d would take minutes
    assert early == ": is truncated: ends after 784 bytes, its data begin after 1536"
    assert "cannot be read as C3D" in read_error(tmp_path / "damaged.c3d", whole[:512] + bytes(512) + whole[1024:])


def test_c3d_that_asks_for_more_memory_than_it_may_have_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr("warpmuscle.synergy.c3d.MEMORY", 2**25)
    assert "cannot be read as C3D" in read_error(write_c3d(tmp_path / "emg.c3d"))


def test_patterns_choose_channels_in_their_order(tmp_path):
    path = write_csv(tmp_path / "emg.csv", EMG)
    assert read_signals(path, ["T*", "D?"]).names == ("TRI", "DA", "DP")


def test_given_rate_makes_times_needless(tmp_path):
    path = tmp_path / "emg.csv"
    path.write_text("time,BIC\n1,0.1\n2,0.2\n1,0.3\n")
    found = read_signals(path, rate=200.0)
    assert (found.rate, found.start, found.names) == (200.0, 0.0, ("BIC",))


def test_channels_that_are_not_wanted_may_hold_anything(tmp_path):
    path = tmp_path / "emg.csv"
    path.write_text("time,label,BIC\n0,go,1\n0.1,,2\n0.2,stop,3\n")
    np.testing.assert_array_equal(read_signals(path, ["BIC"]).values[:, 0], [1, 2, 3])


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("", ": is empty"),
        ("  \n \n", ": is empty"),
        ("time,BIC\n", ": holds 0 samples; two are the least"),
        ("0,1\n2,3\n", ":1: the first row must name the columns, it holds numbers"),
        ("time,BIC\n0,1\n0.1,nan\n0.2,1\n", ":3: channel 'BIC': the value is nan, not a finite number"),
        ("time,BIC\n0,1\n0.1,-inf\n", ":3: channel 'BIC': the value is -inf, not a finite number"),
        ("time,BIC\n0,1\n0.1,high\n", ":3: channel 'BIC': 'high' is not a number"),
        ("time,BIC\n0,1\n\n0.1,\n", ":4: channel 'BIC': the cell is empty"),
        ("time;BIC\n0;1,500\n1;2,250\n", ":2: channel 'BIC': '1,500' is not a number"),
        ("time,BIC\n0,1\n0.1,1_0\n", ":3: channel 'BIC': '1_0' is not a number"),
        ("time,BIC,TRI\n0,1,2\n0.1,1\n", ":3: has 2 cells where the header names 3 columns"),
        ("time,BIC,TRI\n0,1,2\n0.1,1,2,3\n", ":3: has 4 cells where the header names 3 columns"),
        ("time,BIC\n0,1\n0.1,2\n0.05,3\n", ":4: channel 'time': times must increase, but 0.05 s follows 0.1 s"),
        (
            "time,BIC\n0,1\n0.1,2\n0.1,3\n",
            ":4: channel 'time': times must increase, but 0.1 s follows 0.1 s; if times are rounded, give",
        ),
        ("time,BIC\n0,1\n0.1,2\n0.2,3\n0.4,1\n", ":5: channel 'time': samples are missing: 0.2 s since the one before"),
        ("time,BIC\n0,1\nnan,2\n0.2,3\n", ":3: channel 'time': the value is nan"),
        ("time,BIC,TRI\n0,1,5\n0.1,2,5\n", ": channel 'TRI': is 5 throughout; leave it out by naming the others"),
        ("time,BIC,BIC\n0,1,5\n0.1,2,6\n", ": channel 'BIC': this name stands for two channels"),
        ("sample,BIC\n0,1\n1,2\n", ":1: has no column `time`; give the sampling rate"),
        ("time\n0\n1\n", ": holds no channels"),
        (b"\x89HDF\r\n\0\0junk", ": is not a text file"),
        (bytes(range(128, 256)), ": is not a text file"),
    ],
)
def test_bad_text_is_one_line_with_its_place(tmp_path, text, says):
    assert read_error(tmp_path / "bad.csv", text).startswith(says)


def test_missing_channel_lists_those_there_are(tmp_path):
    text = "time,BIC,TRI\n0,1,2\n0.1,2,3\n"
    assert (
        read_error(tmp_path / "a.csv", text, channels=["DELT"]) == ": no channel is called 'DELT'; there are BIC, TRI"
    )


def test_file_that_cannot_be_read_is_said(tmp_path):
    assert read_error(tmp_path / "none.csv") == ": there is no such file"
    assert read_error(tmp_path / "none.h5") == ": there is no such file"
    assert read_error(tmp_path / "none.c3d") == ": there is no such file"
    folder = tmp_path / "folder.csv"
    folder.mkdir()
    assert read_error(folder) == ": this is a folder, not a file"
    assert "signals are read from .csv" in read_error(tmp_path / "emg.mat", "x")


@pytest.mark.parametrize("suffix", ["h5", "c3d"])
@pytest.mark.parametrize("content", [b"", b"garbage" * 100, b"\x02\x50" + bytes(range(256)) * 4])
def test_garbage_with_a_binary_suffix_is_said(tmp_path, suffix, content):
    assert "\n" not in read_error(tmp_path / f"bad.{suffix}", content)


def test_storage_file_must_hold_what_it_promises(tmp_path):
    said = read_error(write_storage(tmp_path / "emg.mot", promised=7))
    assert said == ": the header promises nRows=7, but there are 3"
    assert read_error(tmp_path / "no.mot", "time BIC\n0 1\n") == (
        ": has no line `endheader`, as OpenSim's storage files have"
    )


@pytest.mark.parametrize("promised", ["-3", "3.5", "1" + 19 * "0", "three", "", "nan"])
def test_what_a_header_promises_must_be_a_count(tmp_path, promised):
    said = read_error(write_storage(tmp_path / "emg.mot", promised=promised))
    assert said == f":3: nRows={promised!r} is not a count"


def test_words_about_rows_in_a_header_are_no_count(tmp_path):
    file = write_storage(tmp_path / "emg.sto", promised=" 3 ")
    file.write_text(file.read_text().replace("subject\n", "nRows are those of the trial\n"))
    assert read_signals(file).names == ("BIC", "TRI")


@pytest.mark.parametrize(
    ("datasets", "says"),
    [
        ({"BIC": [1.0, 2.0, 3.0], "TRI": [1.0, 2.0], "rate": 10.0},
         ": channel 'TRI': has 2 samples, but 'BIC' has 3"),
        ({"BIC": [1.0, 2.0]}, ": has neither `time` nor `rate`; give the sampling rate"),
        ({"BIC": [1.0, 2.0, 0.0], "time": [0.0, 1.0]}, ": has 3 samples, but `time` has shape (2,)"),
        ({"BIC": [1.0, 2.0, 0.0], "time": [0.0, 1.0, 0.5]},
         ": channel 'time': times must increase, but 0.5 s follows 1 s, in sample 3"),
        ({"BIC": [1.0, np.nan], "rate": 10.0}, ": channel 'BIC': the value is nan, not a finite number, at 0.1 s"),
        ({"values": np.eye(3), "names": ["a", "b"], "rate": 1.0},
         ": `names` must name the columns of `values`, which has shape (3, 3)"),
        ({"rate": 10.0}, ": holds neither `values` nor a dataset a channel"),
    ],
)  # fmt: skip
def test_bad_hdf5_is_one_line(tmp_path, datasets, says):
    assert read_error(write_hdf5(tmp_path / "bad.h5", **datasets)) == says


def test_rate_must_be_a_positive_number(tmp_path):
    assert "a sampling rate must be greater than 0, not -5" in read_error(tmp_path / "a.csv", "a\n1\n2\n", rate=-5.0)
