"""Damages of markers, in `.trc` and `.c3d`."""

from __future__ import annotations

from random import Random

import numpy as np

from damaging.damage import Damage, beheaded, changed_line, cut, some, spliced
from damaging.trial import Trial

MISS = r"miss|swapped|to and fro|jump of"
SIZE = r"times as large|unit"
FEW = r"markers? of a weight"


def gap_of_one(trial: Trial, rng: Random) -> None:
    frames = some(len(trial.marker_times), rng)
    trial.positions[frames, rng.randrange(len(trial.marker_names))] = np.nan


def gap_of_all(trial: Trial, rng: Random) -> None:
    trial.positions[some(len(trial.marker_times), rng)] = np.nan


def only_one_body(trial: Trial, rng: Random) -> None:
    body = max(set(trial.marker_bodies), key=trial.marker_bodies.count)
    away = [k for k, own in enumerate(trial.marker_bodies) if own != body]
    trial.positions[np.ix_(some(len(trial.marker_times), rng), away)] = np.nan


def zeros_where_hidden(trial: Trial, rng: Random) -> None:
    trial.positions[some(len(trial.marker_times), rng), rng.randrange(len(trial.marker_names))] = 0.0


def _far_pair(trial: Trial, rng: Random) -> tuple[int, int]:
    """Two markers on different bodies, 30 cm from each other at least."""
    mean = np.nanmean(trial.positions, axis=0)
    pairs = [(i, j) for i in range(len(mean)) for j in range(i) if np.linalg.norm(mean[i] - mean[j]) > 300.0]
    return rng.choice(pairs)


def swapped_labels(trial: Trial, rng: Random) -> None:
    a, b = _far_pair(trial, rng)
    trial.marker_names[a], trial.marker_names[b] = trial.marker_names[b], trial.marker_names[a]


def swapped_half_way(trial: Trial, rng: Random) -> None:
    a, b = _far_pair(trial, rng)
    half = len(trial.marker_times) // 2
    trial.positions[half:, [a, b]] = trial.positions[half:, [b, a]]


def shifted_labels(trial: Trial, rng: Random) -> None:
    trial.marker_names = [*trial.marker_names[3:], *trial.marker_names[:3]]


def of_a_subject(trial: Trial, rng: Random) -> None:
    trial.marker_names = [f"Anna:{name}" for name in trial.marker_names]


def label_twice(trial: Trial, rng: Random) -> None:
    trial.marker_names[1] = trial.marker_names[0]


def no_labels(trial: Trial, rng: Random) -> None:
    trial.marker_names = [f"*{k}" for k in range(len(trial.marker_names))]


def unit_is_not(unit: str) -> Damage:
    def change(trial: Trial, rng: Random) -> None:
        trial.unit = unit

    return Damage(f"said to be in {unit or 'nothing'}", change, SIZE)


def turned(name: str, axes: tuple[int, int, int], signs: tuple[int, int, int]) -> Damage:
    def change(trial: Trial, rng: Random) -> None:
        trial.positions = trial.positions[..., list(axes)] * signs

    return Damage(name, change, MISS)


def frozen(trial: Trial, rng: Random) -> None:
    one = rng.randrange(len(trial.marker_names))
    trial.positions[:, one] = trial.positions[0, one] + [0.0, 300.0, 0.0]


def spike(trial: Trial, rng: Random) -> None:
    trial.positions[rng.randrange(2, len(trial.marker_times) - 2), rng.randrange(len(trial.marker_names))] += 900.0


def noise(trial: Trial, rng: Random) -> None:
    trial.positions += np.random.default_rng(rng.randrange(99)).normal(0.0, 250.0, trial.positions.shape)


def shuffled_frames(trial: Trial, rng: Random) -> None:
    order = list(range(len(trial.marker_times)))
    rng.shuffle(order)
    trial.positions = trial.positions[order]


def shuffled_times(trial: Trial, rng: Random) -> None:
    times = list(trial.marker_times)
    rng.shuffle(times)
    trial.marker_times = np.array(times)


def time_twice(trial: Trial, rng: Random) -> None:
    k = rng.randrange(1, len(trial.marker_times))
    trial.marker_times[k] = trial.marker_times[k - 1]


def time_is_none(trial: Trial, rng: Random) -> None:
    trial.marker_times[rng.randrange(len(trial.marker_times))] = rng.choice([np.nan, np.inf, -np.inf])


def milliseconds(trial: Trial, rng: Random) -> None:
    trial.marker_times = 1000.0 * trial.marker_times


def missing_frames(trial: Trial, rng: Random) -> None:
    n = len(trial.marker_times)
    trial.keep_markers([k for k in range(n) if not 0.35 * n < k < 0.7 * n])


def no_frames(trial: Trial, rng: Random) -> None:
    trial.keep_markers([])


def one_frame(trial: Trial, rng: Random) -> None:
    trial.keep_markers([0])


def infinite(trial: Trial, rng: Random) -> None:
    trial.positions[rng.randrange(len(trial.marker_times)), rng.randrange(len(trial.marker_names)), 0] = np.inf


def enormous(trial: Trial, rng: Random) -> None:
    trial.positions[rng.randrange(len(trial.marker_times)), rng.randrange(len(trial.marker_names))] = 1e30


def promised(frames: str | None, markers: str | None) -> Damage:
    def change(trial: Trial, rng: Random) -> None:
        trial.counts = (frames or str(len(trial.marker_times)), markers or str(len(trial.marker_names)))

    what = f"NumFrames={frames}" if frames else f"NumMarkers={markers}"
    return Damage(f"promises {what}", change, r"promises|is not a number|is no")


def many_markers(trial: Trial, rng: Random) -> None:
    trial.edit("markers", changed_line(3, lambda line: line + b"\t\t\tx" * 300_000))


def word(trial: Trial, rng: Random) -> None:
    trial.edit("markers", changed_line(rng.randrange(7, 12), lambda line: line.replace(b".", b"x.", 4)))


def blanks_for_tabs(trial: Trial, rng: Random) -> None:
    trial.edit("markers", lambda data: data.replace(b"\t", b" "))


TRC: list[Damage] = [
    Damage("gap of one", gap_of_one, None),
    Damage("gap of all", gap_of_all, r"no marker is seen"),
    Damage("gap of all bodies but one", only_one_body, r"markers that tell .* are missing"),
    Damage("zeros where hidden", zeros_where_hidden, None),
    Damage("two labels swapped", swapped_labels, MISS),
    Damage("two labels swapped half-way", swapped_half_way, MISS),
    Damage("labels shifted by three", shifted_labels, MISS),
    Damage("labels of a subject", of_a_subject, FEW),
    Damage("no labels", no_labels, FEW),
    Damage("label twice", label_twice, r"two markers are called"),
    *map(unit_is_not, ("m", "cm", "in", "furlong", "")),
    turned("z up", (0, 2, 1), (1, -1, 1)),
    Damage("upside down", turned("", (0, 1, 2), (1, -1, 1)).change, r"upside down"),
    turned("mirrored", (0, 1, 2), (1, 1, -1)),
    turned("axes in a ring", (1, 2, 0), (1, 1, 1)),
    Damage("frozen marker", frozen, MISS),
    Damage("spike", spike, MISS),
    Damage("noise", noise, MISS),
    Damage("frames shuffled", shuffled_frames, r"to and fro|jump of"),
    Damage("times shuffled", shuffled_times, r"times must be numbers that increase"),
    Damage("time twice", time_twice, r"times must be numbers that increase"),
    Damage("time is no number", time_is_none, r"times must be numbers that increase"),
    Damage("milliseconds", milliseconds, r"apart|reach from"),
    Damage("missing frames", missing_frames, r"no frames? between"),
    Damage("no frames", no_frames, r"has no frames"),
    Damage("one frame", one_frame, r"there must be two frames"),
    Damage("infinitely far", infinite, r"infinitely far"),
    Damage("far beyond the Earth", enormous, r"away|large"),
    promised("12", None), promised("1000000000000", None), promised("-5", None), promised("x", None),
    promised(None, "3"), promised(None, "4000000000"),
    Damage("300 000 more labels", many_markers, r"two markers are called|promises|longer"),
    Damage("cell is a word", word, r"not a number"),
    Damage("blanks for tabs", blanks_for_tabs, r"Units"),
    cut("markers", r"promises|head|cells|empty|head as"),
    spliced("markers"),
    beheaded("markers"),
]  # fmt: skip


def parameter_bytes(trial: Trial, rng: Random) -> None:
    """Random bytes within the blocks of parameters."""

    def change(data: bytes) -> bytes:
        content = bytearray(data)
        for _ in range(rng.choice([1, 3, 20])):
            content[rng.randrange(512, min(512 * 6, len(content)))] = rng.randrange(256)
        return bytes(content)

    trial.edit("c3d", change)


def header_bytes(trial: Trial, rng: Random) -> None:
    def change(data: bytes) -> bytes:
        content = bytearray(data)
        for _ in range(rng.choice([1, 2, 6])):
            content[rng.randrange(0, 24)] = rng.randrange(256)
        return bytes(content)

    trial.edit("c3d", change)


def data_bytes(trial: Trial, rng: Random) -> None:
    def change(data: bytes) -> bytes:
        content = bytearray(data)
        at = rng.randrange(len(content) // 2, len(content) - 16)
        content[at : at + 16] = rng.choice([b"\xff" * 16, b"\x00\x00\xc0\x7f" * 4, rng.randbytes(16), b"\x7f" * 16])
        return bytes(content)

    trial.edit("c3d", change)


def no_parameters(trial: Trial, rng: Random) -> None:
    trial.edit("c3d", lambda data: data[:512] + bytes(1024) + data[1536:])


ANY = r""
C3D: list[Damage] = [
    Damage("bytes of parameters", parameter_bytes, ANY), Damage("bytes of parameters", parameter_bytes, ANY),
    Damage("bytes of the header", header_bytes, ANY), Damage("bytes of numbers", data_bytes, ANY),
    Damage("no parameters", no_parameters, r"C3D"),
    Damage("gap of one", gap_of_one, None),
    Damage("two labels swapped", swapped_labels, MISS),
    turned("z up", (0, 2, 1), (1, -1, 1)),
    *map(unit_is_not, ("m", "furlong")),
    cut("c3d", r"C3D|truncated|empty"),
]  # fmt: skip
