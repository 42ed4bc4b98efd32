"""`python -m warpmuscle`, and what the installed script calls: the command line."""

import os
import sys

import warpmuscle
from warpmuscle.core.interruption import end_at_once_by_ctrl_c


def main() -> None:
    """Run the command line, which takes a while to import."""
    end_at_once_by_ctrl_c()
    from warpmuscle.cli.quick import answered
    from warpmuscle.cli.streams import tell_of_start

    if not answered():
        tell_of_start()
        from warpmuscle.cli.ending import end_process
        from warpmuscle.cli.program import main as run

        try:
            run()
        except SystemExit as ended:
            end_process(ended)


if __name__ == "__main__":
    # Python looks for modules in the current folder first; what the commands import is not looked for there.
    if sys.path[:1] == [os.getcwd()] != [os.path.dirname(os.path.dirname(os.path.realpath(warpmuscle.__file__)))]:
        del sys.path[0]
    main()
