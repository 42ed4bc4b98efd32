"""Commands with values of options that nobody means, and commands that read what is no file."""

from __future__ import annotations

import os
from pathlib import Path
from random import Random

from fuzzing.values import NAMES, NUMBERS, WORDS

OPTIONS = """
simulate fwalk --time-step=0.01 --duration=NUMBER
simulate fwalk --duration=0.02 --time-step=NUMBER
simulate fwalk --duration=0.02 -o out.h5 --rate=NUMBER
simulate fwalk --duration=0.02 --device=NAME
simulate fwalk --duration=0.02 -o NAME.h5
optimize fwalk --duration=0.02 -o out.h5 --until=1s --candidates=NUMBER
optimize fwalk --duration=0.02 -o out.h5 --candidates=3 --seed=NUMBER
optimize fwalk --duration=0.02 -o out.h5 --candidates=3 --search=NAME
optimize fwalk --duration=0.02 -o out.h5 --candidates=3 --search=cma --searches=NUMBER
optimize fwalk --duration=0.02 -o out.h5 --candidates=3 --population=NUMBER
optimize fwalk --duration=0.02 -o out.h5 --candidates=3 --search=cma --sigma=NUMBER
optimize fwalk --duration=0.02 -o out.h5 --candidates=3 --until=NUMBER
optimize fwalk --duration=0.02 -o out.h5 --candidates=3 --target=NUMBER
optimize fwalk --duration=0.02 -o out.h5 --candidates=3 --threads=NUMBER
optimize fwalk --duration=0.02 -o out.h5 --candidates=3 --search=cma --restarts=NAME
apply search.h5 -o out.toml --most-robust=NUMBER
apply search.h5 -o out.toml --settle=NUMBER
apply search.h5 -o out.toml --description=NAME --fix=NAME
apply search.h5 -o out.toml --on=NAME
report search.h5 --run=NAME
export fwalk.h5 -o walk.csv --replay=NUMBER
plot fwalk.h5 -o a.png --what=NAME
plot fwalk.h5 -o a.png --what=dataset:NAME
plot fwalk.h5 -o a.png --what=angles --start=NUMBER
plot fwalk.h5 -o a.png --what=angles --end=NUMBER --joint=NAME
video fwalk.h5 -o a.gif --size=NUMBERx64
video fwalk.h5 -o a.gif --size=96x64 --rate=NUMBER
video fwalk.h5 -o a.gif --size=96x64 --speed=NUMBER
video fwalk.h5 -o a.gif --size=96x64 --azimuth=NUMBER --elevation=NUMBER
video fwalk.h5 -o a.gif --size=96x64 --strides=NUMBER
view search.h5 --export out.html --candidates=NUMBER
synergies extract emg.csv --restarts=1 -n 2 --low-pass=NUMBER
synergies extract emg.csv --restarts=1 -n 2 --order=NUMBER
synergies extract emg.csv --restarts=1 -n 2 --band NUMBER 90
synergies extract emg.csv --restarts=1 -n 2 --band 10 NUMBER
synergies extract emg.csv --restarts=1 -n 2 --rate=NUMBER
synergies extract emg.csv --restarts=1 -n 2 --sampling-rate=NUMBER
synergies extract emg.csv --restarts=1 -n 2 --time-window 0 NUMBER
synergies extract emg.csv --restarts=1 --vaf=NUMBER
synergies extract emg.csv --restarts=1 --number=NUMBER
synergies extract emg.csv -n 2 --restarts=NUMBER
synergies extract emg.csv --restarts=1 -n 2 --seed=NUMBER
synergies extract emg.csv --restarts=1 -n 2 --channels=NAME
synergies extract emg.csv --restarts=1 -n 2 --ecg=NAME
throw goal throw.csv -n 1 --device=cpu --adapt=1 --target=NUMBER
throw goal throw.csv -n 1 --device=cpu --target=2 --height=NUMBER
throw goal throw.csv -n 1 --device=cpu --speed=NUMBER
throw goal throw.csv -n 1 --device=cpu --angle=NUMBER
throw goal throw.csv -n 1 --device=cpu --target=2 --release=NUMBER
throw goal throw.csv -n 1 --device=cpu --target=2 --scene=NAME
fit-muscles elbow_open_loop -o out.toml --duration=0.02 --strength=NUMBER
fit-muscles elbow_open_loop -o out.toml --duration=0.02 --mean-length=NUMBER
fit-muscles elbow_open_loop -o out.toml --duration=0.02 --fibre-per-arm=NUMBER
info NAME
convert fwalk -o NAME.toml
"""
READING = """
info in.toml
info in.rbs fwalk.sbc
info fwalk.rbs in.sbc
info fwalk.rbs fwalk.sbc in.rs
info scene.toml
report in.h5
view in.h5 --export out.html
plot in.h5
export in.h5 -o a.csv
apply in.h5 -o a.toml
video in.h5 -o a.gif
optimize --resume in.h5
optimize --resume killed.h5
sweep in.toml
sweep --status in.h5
synergies extract in.csv
synergies extract in.sto
synergies extract in.h5
synergies extract in.c3d
synergies extract emg.csv --cycles in.csv
synergies extract emg.csv --like in.h5
throw fit in.csv
throw fit in.npz
throw fit throw.csv --emg in.h5
simulate tracked_npz.toml
simulate tracked_h5.toml
"""
INDIRECT = {  # what the command reads besides
    "tracked_npz.toml": "gait.npz", "tracked_h5.toml": "gait.h5", "scene.toml": "in.toml",
    "killed.h5": "killed.h5.journal",
}  # fmt: skip


def option_command(rng: Random) -> list[str]:
    """A command with an extreme value or a strange name for one of its options."""
    name = rng.choice(NAMES).replace("\0", "")
    scales = [str(10 ** rng.randrange(3, 20)), f"1e-{rng.randrange(3, 20)}", str(rng.randrange(1, 200))]
    number = rng.choice([str(rng.choice(NUMBERS)), rng.choice(WORDS), *scales])
    words = rng.choice(OPTIONS.strip().split("\n")).split()
    file = name.replace("/", "_").lstrip(".")  # elsewhere or hidden, a user gets it as named
    given = {"NUMBER": number, "NAME.": f"{file}.", "NAME": name}
    for key, value in given.items():
        words = [word.replace(key, value) for word in words]
    return words


def reading_command(rng: Random) -> tuple[list[str], str]:
    """A command, and the name of a file that it reads."""
    command = rng.choice(READING.strip().split("\n")).split()
    named = [word for word in command if word.startswith("in.")]
    return command, (named or [INDIRECT[word] for word in command if word in INDIRECT])[0]


def put_no_file(path: Path, rng: Random) -> None:
    """A pipe, a device, a folder, a link to itself, or a file of nothing or without end."""
    match rng.randrange(6):
        case 0:
            os.mkfifo(path)
        case 1:
            path.symlink_to("/dev/zero")
        case 2:
            path.mkdir()
        case 3:
            path.symlink_to(path.name)
        case 4:
            path.touch()
        case 5:
            path.touch()
            os.truncate(path, 2**42)
