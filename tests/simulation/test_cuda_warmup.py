"""The driver of a GPU starts in the background, and only for a GPU."""

import ctypes

import pytest

from warpmuscle.simulation import cuda_warmup


class Library:
    """Stands for the driver of a machine with two GPUs, and notes what it is asked."""

    def __init__(self) -> None:
        self.asked: list[object] = []

    def cuInit(self, flags: int) -> int:
        self.asked.append("init")
        return 0

    def cuDeviceGet(self, device: object, ordinal: int) -> int:
        self.asked.append(ordinal)
        return 0 if ordinal < 2 else 101

    def cuDevicePrimaryCtxRetain(self, context: object, device: object) -> int:
        self.asked.append("context")
        return 0


@pytest.fixture
def library(monkeypatch: pytest.MonkeyPatch) -> Library:
    """The driver that is found."""
    found = Library()
    monkeypatch.setattr(ctypes, "CDLL", lambda name: found)
    return found


@pytest.mark.parametrize(
    ("device", "asked"),
    [
        (None, ["init", 0, "context"]),
        ("cuda:1", ["init", 1, "context"]),
        ("cuda:all", ["init", 0, "context"]),
        ("cuda:1,cuda:0", ["init", 1, "context"]),
        ("cuda:7", ["init", 7]),
        ("cpu", []),
        ("nonsense", []),
    ],
)
def test_the_first_of_the_named_gpus_is_made_ready(library: Library, device: str | None, asked: list[object]):
    thread = cuda_warmup.start_driver(device)
    if thread is not None:
        thread.join()
    assert library.asked == asked


def test_without_a_driver_nothing_happens(monkeypatch: pytest.MonkeyPatch):
    def missing(name: str) -> None:
        raise OSError(f"{name}: cannot open shared object file")

    monkeypatch.setattr(ctypes, "CDLL", missing)
    thread = cuda_warmup.start_driver(None)
    assert thread is not None
    thread.join()
