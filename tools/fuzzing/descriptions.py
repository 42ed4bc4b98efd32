"""Descriptions from which scenes and searches are made: creatures, studies, measured conditions, SCONE's scenarios."""

from __future__ import annotations

import json
import tomllib
from random import Random
from typing import Any

from fuzzing import scone_texts
from fuzzing.setting import Command, Setting, scene_commands
from fuzzing.tables import changed
from fuzzing.texts import mutated
from fuzzing.values import NAMES, NUMBERS, toml_text

CREATURES = ("kangaroo.toml", "ostrich.toml", "pony.toml", "walker.toml")
STUDY = """\
scene = "fwalk.toml"
[search]
strategy = "cma"
candidates = 2
sigma = 0.03
[set]
duration = 0.02
[grid]
seed = [1, 2]
weight = { keys = ["character.bodies.torso.mass", "character.bodies.head.mass"], factors = [1, 0.5] }
[study]
title = "Light heads"
text = "With less of the head."
condition = "weight"
reference = 1
measures = ["cost"]
[[study.expected]]
measure = "cost"
change = "stays"
at = 0.5
within = 0.1
source = "nobody"
"""


def creature(rng: Random, at: Setting) -> list[Command]:
    """Descriptions of creatures."""
    name = rng.choice(CREATURES)
    at.copy(name)
    path = at.folder / name
    if rng.random() < 0.25:
        path.write_bytes(mutated(path.read_text(), rng))
    else:
        path.write_text(toml_text(changed(tomllib.loads(path.read_text()), rng)))
    build = ["creature", "build", name, "-o", "out.toml"]
    return [build, rng.choice([["info", "out.toml"], ["convert", "out.toml", "-o", "again.toml"]])]


def study(rng: Random, at: Setting) -> list[Command]:
    """Sweep files with a study."""
    at.copy("fwalk.toml")
    path = at.folder / "study.toml"
    if rng.random() < 0.3:
        path.write_bytes(mutated(STUDY, rng))
    else:
        data = tomllib.loads(STUDY)
        part = data if rng.random() < 0.4 else data["study"]
        changed(part, rng)
        path.write_text(toml_text(data))
    words = ["--seeds", str(rng.choice([1, 2, 10**9]))] if rng.random() < 0.05 else []
    return [["study", "study.toml", "-o", "out.h5", "--device", "cpu", *words]]


def adaptation(rng: Random, at: Setting) -> list[Command]:
    """Measured conditions."""
    common = {"study": "a", "subject_mass_kg": 70, "leg_length_m": 0.9, "added_mass_kg": 0, "added_mass_where": None}
    records: list[dict[str, Any]] = [
        common | {"identifier": "level", "speed_m_s": 1.25, "slope_pct": 0, "metabolic_power_nd": 0.08},
        common | {"identifier": "up", "speed_m_s": 1.2, "slope_pct": 8, "metabolic_power_nd": 0.2},
        common
        | {"identifier": "load", "speed_m_s": 1.2, "slope_pct": 0, "added_mass_kg": 4, "added_mass_where": "foot"},
    ]
    records[1] |= {"stride_frequency_nd": 0.27, "curves_right": {"knee_angle_deg": [0.0, 10.0, 60.0, 5.0]}}
    path = at.folder / "adaptation.json"
    if rng.random() < 0.3:
        path.write_bytes(mutated(json.dumps(records, indent=1), rng))
    else:
        path.write_text(json.dumps(changed({"all": records}, rng).get("all")))
    small = ["--seeds", "1", "--candidates", "1", "--duration", "1", "--device", "cpu"]
    return [["adaptation", "adaptation.json", "--conditions", rng.choice(["a*", "*", *NAMES[:10]]), *small]]


def scone(rng: Random, at: Setting) -> list[Command]:
    """A scenario, its model, controller, start, or tuned parameters."""
    texts = {
        "pair.scone": scone_texts.SCENARIO, "data/controller.scone": scone_texts.CONTROLLER,
        "data/pair.hfd": scone_texts.MODEL, "data/start.zml": scone_texts.START, "best.par": scone_texts.PARAMETERS,
    }  # fmt: skip
    (at.folder / "data").mkdir()
    target = rng.choice(list(texts))
    for name, text in texts.items():
        (at.folder / name).write_bytes(mutated(text, rng) if name == target else text.encode())
    if rng.random() < 0.1:
        where = rng.choice(["../../secret.h5", "/etc/passwd", "pair.scone", "controller.scone", ".", "data", *NAMES])
        (at.folder / "data/controller.scone").write_text(f"{scone_texts.CONTROLLER}\n<< {where} >>\n", errors="replace")
    files = ["pair.scone", "best.par"] if target == "best.par" or rng.random() < 0.2 else ["pair.scone"]
    if target.endswith(".hfd") and rng.random() < 0.5:
        files = [target]
    command = rng.choice(scene_commands(files[0], rng, simulated=False))
    out = [["convert", *files, "-o", "out.par"]] if rng.random() < 0.2 else []
    number = str(rng.choice(NUMBERS))
    shown = [["info", *files, "--set", f"gait_states.stance_load={number}"]] if rng.random() < 0.1 else []
    whole = [part for word in command for part in (files if word == files[0] else [word])]
    return out or shown or [whole]
