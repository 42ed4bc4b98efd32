"""What a sweep says of when, where and by which commit it began."""

import re
import shutil
import subprocess
from pathlib import Path

import pytest

from warpmuscle.sweep.origin import origin, package_commit

GIT = ["git", "-c", "user.name=a", "-c", "user.email=a@b.c"]


def test_date_is_that_of_the_world_and_the_host_has_a_name():
    found = origin()
    assert re.fullmatch(r"20\d\d-\d\d-\d\dT\d\d:\d\d:\d\dZ", found["began"])
    assert found["host"]


@pytest.mark.skipif(shutil.which("git") is None, reason="no git")
def test_commit_is_that_of_the_checkout_and_says_if_a_file_has_changed(tmp_path: Path):
    def git(*arguments: str) -> str:
        return subprocess.run([*GIT, *arguments], cwd=tmp_path, capture_output=True, text=True, check=True).stdout

    assert package_commit(tmp_path) == ""
    git("init", "-q")
    assert package_commit(tmp_path) == ""  # nothing has been committed
    (tmp_path / "a").write_text("1")
    git("add", "a")
    git("commit", "-qm", "a")
    commit = git("rev-parse", "HEAD").strip()
    assert package_commit(tmp_path) == commit
    (tmp_path / "a").write_text("2")
    assert package_commit(tmp_path) == f"{commit}+"
