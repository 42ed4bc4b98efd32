"""When and where a sweep begins, and by which commit of this program."""

from __future__ import annotations

import socket
import subprocess
from datetime import UTC, datetime
from pathlib import Path

PATIENCE = 60.0  # s, on a slow disk


def origin() -> dict[str, str]:
    """Date, host, and commit if this program runs from a checkout."""
    now = datetime.now(UTC).strftime("%Y-%m-%dT%H:%M:%SZ")
    return {"began": now, "host": socket.gethostname()} | ({"commit": commit} if (commit := package_commit()) else {})


def package_commit(root: Path = Path(__file__).parents[2]) -> str:
    """Hash of the commit, with `+` behind it if tracked files have changed since; empty where there is no checkout."""
    if not (root / ".git").exists():
        return ""
    found = _git(root, "rev-parse", "HEAD")
    return f"{found}+" if found and _git(root, "status", "--porcelain", "--untracked-files=no") else found


def _git(root: Path, *arguments: str) -> str:
    """What git says in a line or more; empty if it fails or is not installed."""
    try:
        done = subprocess.run(
            ["git", "-C", str(root), *arguments], capture_output=True, text=True, timeout=PATIENCE, check=False
        )
    except (OSError, subprocess.TimeoutExpired):
        return ""
    return done.stdout.strip() if done.returncode == 0 else ""
