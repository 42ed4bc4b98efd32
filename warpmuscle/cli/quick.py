"""What is answered before the commands are imported, which takes longer: completion in a shell, the list of scenes."""

from __future__ import annotations

import os
import sys


def answered() -> bool:
    """Answer if it is one of these; whether it was."""
    request = os.environ.get("_WARPMUSCLE_COMPLETE", "")
    if request:
        from warpmuscle.cli.completion import complete
        from warpmuscle.cli.streams import steady_streams

        steady_streams()  # whoever asks may read the first lines only
        return complete(request)
    if sys.argv[1:] == ["scenes"]:
        from warpmuscle.cli.ending import run_to_end
        from warpmuscle.cli.scene_list import print_scenes

        run_to_end(print_scenes)
    return False
