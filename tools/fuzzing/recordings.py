"""Recordings of a leg: coordinates, markers, ground forces, EMG and a set-up, and what `inverse` makes of them."""

from __future__ import annotations

import math
from random import Random

from fuzzing.models import MODELS, mutated_model
from fuzzing.setting import Command, Setting
from fuzzing.texts import mutated
from fuzzing.values import NAMES, NUMBERS

FRAMES, RATE = 40, 100.0  # Hz
COORDINATES = ("tilt", "tx", "ty", "flexion", "adduction", "bend", "ankle_angle")
MARKERS = {"toe": ("foot", "0.15 0 0"), "heel": ("foot", "-0.05 0 0.02"), "knee": ("thigh", "0.05 -0.38 0.05"),
           "hip": ("pelvis", "0 0 0.2"),
           "back": ("pelvis", "-0.1 0.2 0"), "shin": ("shank", "0.03 -0.2 0.04")}  # fmt: skip
LOADS = """<?xml version="1.0"?>
<OpenSimDocument Version="40000"><ExternalLoads name="loads"><objects><ExternalForce name="sole">
<applied_to_body>foot</applied_to_body><force_expressed_in_body>ground</force_expressed_in_body>
<point_expressed_in_body>ground</point_expressed_in_body><force_identifier>ground_force_v</force_identifier>
<point_identifier>ground_force_p</point_identifier><torque_identifier>ground_torque_</torque_identifier></ExternalForce></objects>
<datafile>grf.mot</datafile></ExternalLoads></OpenSimDocument>
"""
SETUP = """<?xml version="1.0"?>
<OpenSimDocument Version="40000"><InverseKinematicsTool name="ik"><IKTaskSet><objects>
<IKMarkerTask name="toe"><apply>true</apply><weight>2</weight></IKMarkerTask>
<IKMarkerTask name="hip"><apply>true</apply><weight>1</weight></IKMarkerTask>
<IKCoordinateTask name="bend"><apply>true</apply><weight>1</weight><value_type>manual_value</value_type>
<value>-0.2</value></IKCoordinateTask></objects></IKTaskSet><constraint_weight>Inf</constraint_weight>
</InverseKinematicsTool></OpenSimDocument>
"""
STEPS = ("id", "id", "id,so", "id,so,jr", "id,track")


def recording(rng: Random, at: Setting) -> list[Command]:
    """One of the files of a recording, or an option, is another."""
    model = MODELS["leg.osim"]
    for name, (body, place) in MARKERS.items():
        if name != "toe":
            one = f'<Marker name="{name}"><socket_parent_frame>/bodyset/{body}</socket_parent_frame>'
            model = model.replace(
                "</Marker></objects>", f"</Marker>{one}<location>{place}</location></Marker></objects>"
            )
    texts = {"walk.mot": _walk(), "grf.mot": _forces(), "loads.xml": LOADS, "markers.trc": _markers(),
             "setup.xml": SETUP, "emg.csv": _emg(), "leg.osim": model}  # fmt: skip
    changed = rng.choice([*texts, "walk.mot", "markers.trc", "grf.mot", ""])
    for name, text in texts.items():
        data = text.encode()
        if name == changed:
            data = mutated_model(text, rng) if name == "leg.osim" else mutated(text, rng)
        (at.folder / name).write_bytes(data)
    if changed in ("markers.trc", "setup.xml"):
        words = ["markers.trc", "--steps", rng.choice(["ik", "ik", "ik,id"])]
        words += ["--setup", "setup.xml"] if changed == "setup.xml" else []
    else:
        words = ["walk.mot", "--loads", rng.choice(["loads.xml", "loads.xml", "grf.mot"])]
        words += ["--emg", "emg.csv", "--steps", "id,so"] if changed == "emg.csv" else ["--steps", rng.choice(STEPS)]
    words += _option(rng) if not changed or rng.random() < 0.1 else []
    return [["inverse", "leg.osim", *words, "--reserve", "50", "-o", "out.h5", "--device", "cpu"]]


def _option(rng: Random) -> list[str]:
    number, name = str(rng.choice(NUMBERS)), rng.choice(NAMES).replace("\0", "")
    flags = [["--filter", number], ["--begin", number], ["--end", number], ["--every", number], ["--window", number],
             ["--power", number], ["--emg-weight", number], ["--reserve", f"bend={number}"], ["--reserve", name],
             ["--steps", name], ["--weight", name], ["--on", name], ["--frame", name], ["--no-plates"], ["--ground"],
             ["--elastic", "--rates", "--passive"], ["--sto", "out"], ["--sto", "walk.mot"], ["--report", "out.html"],
             ["--report", name.replace("/", "_").lstrip(".") + ".html"]]  # fmt: skip
    return rng.choice(flags)


def _storage(names: list[str], rows: list[list[float]], degrees: bool) -> str:
    head = f"walk\nversion=1\nnRows={len(rows)}\nnColumns={len(names) + 1}\ninDegrees={'yes' if degrees else 'no'}\n"
    lines = ["\t".join(["time", *names])]
    lines += ["\t".join(f"{x:.6g}" for x in (k / RATE, *row)) for k, row in enumerate(rows)]
    return head + "endheader\n" + "\n".join(lines) + "\n"


def _phase(frame: int) -> float:
    return 2.0 * math.pi * frame / FRAMES


def _walk() -> str:
    rows = [[1.0, 0.01 * k, 1.0, 20 * math.sin(_phase(k)), 2.0, -20 + 10 * math.cos(_phase(k)), 5 * math.sin(_phase(k))]
            for k in range(FRAMES)]  # fmt: skip
    return _storage(list(COORDINATES), rows, degrees=True)


def _forces() -> str:
    names = [kind + axis for kind in ("ground_force_v", "ground_force_p", "ground_torque_") for axis in "xyz"]
    rows = [[5.0, 200.0 * math.sin(_phase(k) / 2), 1.0, 0.01 * k, 0.0, 0.1, 0.0, 1.0, 0.0] for k in range(FRAMES)]
    return _storage(names, rows, degrees=False)


def _markers() -> str:
    places = {"hip": (0, 950, 200), "back": (-100, 1150, 0), "knee": (50, 570, 150), "shin": (30, 350, 140),
              "toe": (150, 150, 100), "heel": (-50, 150, 120)}  # fmt: skip
    lines = ["PathFileType\t4\t(X/Y/Z)\tmarkers.trc",
             "DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\tOrigDataStartFrame\tOrigNumFrames",
             f"{RATE:g}\t{RATE:g}\t{FRAMES}\t{len(places)}\tmm\t{RATE:g}\t1\t{FRAMES}",
             "Frame#\tTime\t" + "\t\t\t".join(places) + "\t\t",
             "\t\t" + "\t".join(f"X{k}\tY{k}\tZ{k}" for k in range(1, len(places) + 1)), ""]  # fmt: skip
    for frame in range(FRAMES):
        shifted = [x + (10 * frame if axis == 0 else 0) for place in places.values() for axis, x in enumerate(place)]
        lines.append("\t".join([str(frame + 1), f"{frame / RATE:.3f}", *(f"{x:g}" for x in shifted)]))
    return "\n".join(lines) + "\n"


def _emg() -> str:
    rows = [f"{k / RATE:.3f},{0.5 + 0.4 * math.sin(_phase(k)):.4f},0.1" for k in range(FRAMES)]
    return "\n".join(["time,quad,calf", *rows]) + "\n"
