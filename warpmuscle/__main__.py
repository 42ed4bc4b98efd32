"""`python -m warpmuscle`, and what the installed script calls: the command line."""

import gc
import os
import sys
from typing import Any

import warpmuscle
from warpmuscle.core.interruption import end_at_once_by_ctrl_c

MADE, LATER = 500_000, 50_000  # objects, at which Python looks for garbage: the first time, and after that


def main() -> None:
    """Run the command line, which takes a while to import."""
    collect_late()
    end_at_once_by_ctrl_c()
    from warpmuscle.cli.quick import answered
    from warpmuscle.cli.streams import tell_of_start

    if not answered():
        tell_of_start()
        from warpmuscle.cli.common import begin_process
        from warpmuscle.cli.ending import end_process
        from warpmuscle.cli.program import main as run

        begin_process()
        try:
            run()
        except SystemExit as ended:
            end_process(ended)


def collect_late() -> None:
    """Have Python look for garbage when a program has started: what it makes until then, nearly all of it stays.

    What is there at the first time is not looked through again.
    """

    def collected(phase: str, _: Any) -> None:
        if phase == "stop":
            gc.callbacks.remove(collected)
            gc.freeze()
            gc.set_threshold(LATER)

    gc.callbacks.append(collected)
    gc.set_threshold(MADE)


if __name__ == "__main__":
    # Python looks for modules in the current folder first; what the commands import is not looked for there.
    if sys.path[:1] == [os.getcwd()] != [os.path.dirname(os.path.dirname(os.path.realpath(warpmuscle.__file__)))]:
        del sys.path[0]
    main()
