"""What is answered before the commands are imported, which takes longer: completion in a shell, the list of scenes.

The first time that Python imports a fresh installation it compiles it, which takes some seconds: that is told.
"""

from __future__ import annotations

import os
import sys
import threading
import time

# Commands that work for a while, and say on the error stream what they do.
WORKING = frozenset({
    "adaptation", "compile", "fit-muscles", "fit-paths", "gait", "inverse", "judge", "learn", "optimize", "patient",
    "report", "robustness", "simulate", "study", "sweep", "throw", "video", "view",
})  # fmt: skip
FIRST, AGAIN = 0.7, 1.4  # s, until it is said that the program starts, and until it is said again
started = threading.Event()  # whether a command has printed something itself


def answered() -> bool:
    """Answer if it is one of these; whether it was."""
    request = os.environ.get("_WARPMUSCLE_COMPLETE", "")
    if request:
        from warpmuscle.cli.completion import complete

        return complete(request)
    if sys.argv[1:] == ["scenes"]:
        from warpmuscle.cli.ending import run_to_end
        from warpmuscle.cli.scene_list import scenes

        run_to_end(scenes)
    return False


def tell_of_start() -> None:
    """Say that a command that works for a while is being imported, until it prints something itself, if that takes long.

    It is said by a thread of its own, and only where `optimize` or the like is called.
    """
    if WORKING.isdisjoint(sys.argv[1:2]):
        return
    begin = time.monotonic()

    def tell() -> None:
        pause = FIRST
        while not started.wait(pause):
            try:
                os.write(2, f"starting warpmuscle, {time.monotonic() - begin:.0f} s\n".encode())
            except OSError:  # such as of a stream that nobody reads any more
                return
            pause = AGAIN

    threading.Thread(target=tell, name="starting", daemon=True).start()
