"""`python -m warpmuscle`: the command line."""

import os
import sys
from pathlib import Path

import warpmuscle

# Python looks for modules in the current folder first; what the commands import is not looked for there.
if sys.path[:1] == [os.getcwd()] != [str(Path(warpmuscle.__file__).resolve().parents[1])]:
    del sys.path[0]

from warpmuscle.cli import main

if __name__ == "__main__":
    main()
