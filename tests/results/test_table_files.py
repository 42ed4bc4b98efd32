"""Tables and labelled arrays as files of other programs."""

from pathlib import Path

import numpy as np
import pytest

from warpmuscle.core.errors import Error, ResultError
from warpmuscle.results.table_files import check_ending, write_arrays, write_rows

pandas = pytest.importorskip("pandas", reason="no pandas: pip install 'warpmuscle[tables]'")
xarray = pytest.importorskip("xarray", reason="no xarray: pip install 'warpmuscle[tables]'")


def rows(last: float = 3.0):
    return pandas.DataFrame(
        {"cost": [1.0, last], "status": ["fell", "completed"]}, index=pandas.Index(["a", "b"], name="run")
    )


def arrays(last: float = 3.0):
    status = np.array(["fell", "completed"])
    return xarray.Dataset({"cost": ("run", [1.0, last], {"units": "J/(kg m)"}), "status": ("run", status)})


@pytest.mark.parametrize("ending", [".parquet", ".csv"])
def test_rows_come_back_as_they_were(ending: str, tmp_path: Path):
    if ending == ".parquet":
        pytest.importorskip("pyarrow", reason="no pyarrow: pip install 'warpmuscle[tables]'")
    for last in (3.0, 4.0):  # the second time in place of the first
        write_rows(rows(last), tmp_path / f"a{ending}")
        read = pandas.read_parquet if ending == ".parquet" else lambda path: pandas.read_csv(path, index_col="run")
        pandas.testing.assert_frame_equal(read(tmp_path / f"a{ending}"), rows(last), check_dtype=False)
    assert [path.name for path in tmp_path.iterdir()] == [f"a{ending}"]


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("ending", [".zarr", ".nc"])
def test_arrays_come_back_with_their_units(ending: str, tmp_path: Path):
    pytest.importorskip("zarr" if ending == ".zarr" else "h5netcdf", reason="pip install 'warpmuscle[tables]'")
    engine = "zarr" if ending == ".zarr" else "h5netcdf"
    for last in (3.0, 4.0):
        write_arrays(arrays(last), tmp_path / f"a{ending}")
        with xarray.open_dataset(tmp_path / f"a{ending}", engine=engine) as found:
            xarray.testing.assert_identical(found.load(), arrays(last))
    assert [path.name for path in tmp_path.iterdir()] == [f"a{ending}"]


def test_a_store_takes_the_place_of_another_store_only(tmp_path: Path):
    pytest.importorskip("zarr", reason="no zarr: pip install 'warpmuscle[tables]'")
    mine = tmp_path / "mine.zarr"
    mine.mkdir()
    (mine / "notes.txt").write_text("keep me")
    (tmp_path / "link.zarr").symlink_to(mine, target_is_directory=True)
    (tmp_path / "file.zarr").write_text("a file")
    for name in ("mine.zarr", "link.zarr", "file.zarr"):
        with pytest.raises(ResultError, match="no Zarr store: choose another name"):
            write_arrays(arrays(), tmp_path / name)
    assert (mine / "notes.txt").read_text() == "keep me"


def test_a_store_that_cannot_be_put_back_is_kept_beside(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    pytest.importorskip("zarr", reason="no zarr: pip install 'warpmuscle[tables]'")
    path = tmp_path / "a.zarr"
    write_arrays(arrays(3.0), path)
    rename = Path.rename

    def only_away(self: Path, target: Path) -> Path:
        if target == path:
            raise OSError("refused")
        return rename(self, target)

    monkeypatch.setattr(Path, "rename", only_away)
    with pytest.raises(ResultError, match="refused"):
        write_arrays(arrays(4.0), path)
    (kept,) = tmp_path.iterdir()
    with xarray.open_dataset(kept, engine="zarr") as found:
        xarray.testing.assert_identical(found.load(), arrays(3.0))


def test_where_there_is_no_folder_none_is_made(tmp_path: Path):
    for name, write, what in (("a.zarr", write_arrays, arrays()), ("a.csv", write_rows, rows())):
        with pytest.raises(ResultError, match="folder does not exist"):
            write(what, tmp_path / "nowhere" / name)
    assert not (tmp_path / "nowhere").exists()


def test_other_endings_and_what_is_not_installed_are_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    with pytest.raises(Error, match=r"a table ends in \.parquet, \.csv, \.zarr or \.nc"):
        check_ending(tmp_path / "a.xlsx")
    monkeypatch.setitem(__import__("sys").modules, "pyarrow", None)
    with pytest.raises(Error, match=r"needs pyarrow: pip install 'warpmuscle\[tables\]'"):
        write_rows(rows(), tmp_path / "a.parquet")
    assert not list(tmp_path.iterdir())
