"""Optimisations in threads of their own, each of which runs only while the main thread waits for it."""

import signal
import threading
from types import SimpleNamespace
from typing import Any

import pytest

from warpmuscle.sweep import shared_batches


def test_an_interruption_while_an_optimisation_starts_waits_until_it_is_back(
    monkeypatch: pytest.MonkeyPatch, hears_ctrl_c: None
):
    done = []

    def start(thread: threading.Thread) -> None:
        threading.Thread.start(thread)
        signal.raise_signal(signal.SIGINT)

    monkeypatch.setattr(shared_batches._Worker, "start", start)
    shared: Any = SimpleNamespace(device="cpu", largest=1, term_names=())
    worker = shared_batches._Worker(lambda batches: done.append(True), 0, 0, shared)
    with pytest.raises(KeyboardInterrupt):
        worker.advance()
    assert done == [True]
    assert worker.error is None
