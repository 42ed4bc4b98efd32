"""Scenes with objects, water, treadmills, terrain, devices, impairments, commands over time and tasks of learning."""

from __future__ import annotations

import copy
import tomllib
from random import Random

from fuzzing.setting import SEARCH, SHORT, Command, Setting, scene_commands
from fuzzing.tables import changed, paths
from fuzzing.texts import mutated
from fuzzing.values import NUMBERS, toml_text

TABLES = """\
[objects.ball]
type = "ball"
radius = 0.12
mass = { value = 1, per = { load = 1 } }
position = [4.0, 1.0, 0.9]
velocity = [-4.0, 5.3, 0.0]
angular_velocity = [0, 0, 10]
restitution = 0.5
friction = 0.6
[objects.seat]
type = "box"
size = [0.5, 0.45, 0.4]
position = [0.0, 0.225, -0.3]
fixed = true
bodies = ["pelvis", "lUpperleg", "rUpperleg"]
[objects.bar]
type = "capsule"
radius = 0.06
length = 0.1
mass = { value = 4, min = 1, max = 12 }
held = { body = "rLowerarm", position = [-0.28, 0.0, 0.0], until = 2.0 }
[objects.plank]
type = "box"
size = [0.4, 0.04, 2.0]
mass = 8.0
position = [1.5, 0.4, 1.5]
restitution = 0.1
touches = ["ball", "parcel"]
hinge = { axis = [1, 0, 0], position = [0, 0, 0], damping = 0.5 }
[objects.parcel]
type = "box"
size = [0.2, 0.2, 0.2]
position = [1.5, 0.52, 0.7]

[water]
level = 0.1
density = 1000
body_density = { value = 1000, min = 800, max = 1200 }
volume = "shapes"
drag = 1.0
axial_drag = 0.3
added_mass = 1.0
current = 0.1

[treadmill.ground.treadmill]
speed = { value = 0.5, per = { load = 0.1 } }
left = 0.1
right = -0.1
sideways = 0.0
split = 0.0
profile = [[0, 0], [4, 1]]
start = 0.01

[terrain.ground.terrain]
scale = { value = 1, min = 0.5, max = 1 }
tiles = [
    { type = "flat", patches = [{ x = [-1, 1], z = [0, 2], friction = 0.5, stiffness = 0.5, damping = 2 }] },
    { type = "slope", angle = 0.1, start = 1.0, length = 2.0 },
    { type = "stairs", rise = 0.1, tread = 0.3, count = 3, start = 1, landing = 1, returns = true, riser = 0.02 },
    { type = "steps", height = 0.05, length = 0.5, count = 10, start = 1, seed = 1, riser = 0.02 },
    { type = "stones", size = [0.3, 0.4], gap = 0.1, depth = 0.3, height = 0.01, count = [3, 4], start = 1, seed = 2 },
    { type = "gaps", width = 0.2, depth = 0.5, spacing = 1.5, count = 3, start = 1.5, riser = 0.02 },
    { type = "waves", height = 0.05, length = 1.0, across = 2.0, points = 12 },
    { type = "rough", height = 0.05, spacing = 0.25, count = [8, 8], seed = 3 },
    { type = "profile", corners = [[0, 0], [1, 0.1], [2, 0]] },
]

[forces.brace]
type = "bilinear_spring"
joint = "lAnkle"
parameters = { rest_angle = 0.0, stiffness_above = 0.0, stiffness_below = 30.0, damping = 0.0 }
[forces.motor]
type = "cycle_torque"
joint = "rAnkle"
[forces.motor.parameters]
torque_0 = 0
torque_1 = 1
torque_2 = 0
torque_3 = 0
torque_4 = 1
torque_5 = 6
torque_6 = 3
torque_7 = 0
torque_8 = 0
torque_9 = 0
[forces.cord]
type = "point_spring"
body = "lLowerleg"
other_body = "rLowerleg"
[forces.cord.parameters]
first_x = 0.0
first_y = 0.1
first_z = 0.0
second_x = 0.0
second_y = 0.1
second_z = 0.0
rest_length = 0.2
stiffness_above = 100.0
stiffness_below = 0.0
damping = 1.0
[forces.harness]
type = "weight_support"
body = "torso"
parameters = { share = 0.02 }

[weakness.character.muscles.HIP]
path = [{ body = "pelvis", position = [0.1, 0.05, 0.06] }, { body = "lUpperleg", position = [0.03, 0.1, 0.05] }]
f_max = 1000
l_opt = 0.1
l_slack = 0.05
delay = 0.01
[weakness.impairments.weak]
muscles = ["HIP", "?IP"]
f_max = 0.8
l_opt = 0.9
delay = 1.2

[commands.load]
unit = "kg"
reference = 0
value = 1
min = 0
max = 20
[commands.heading]
unit = "rad"
reference = 0
min = -3
max = 3
over = [[0, 0], [0.01, 1.571]]

[learning]
speed = [0.7, 1.8]
command_time = 5
episode_time = 10
actions = "joint_targets"
rewards = { speed = 20, imitation = 30, imitation_width = 0.12, force = 30, overload = 2, objective = 1, alive = 1 }
observations = { joints = { noise = 0.01 }, root = {} }
goals = { reach = { low = [0.0], high = [1.0] } }
[learning.imitation]
norm = "key points"
moving = true
cycle_time = 1.03
step_width = 0.1
weights = { lHip = 4, root = 1 }
[learning.variation]
velocity_noise = 0.05
mass = 0.1
slope = 0.05
push = 5
start_states = 4
joint_noise = 0.01
commands = ["load"]

[objective]
norm_moments = 1
norms = 1
speed = 10
target_speed = { value = 1, per = { load = 0.1 } }
"""
WITHIN = ("treadmill", "terrain", "weakness")  # names of several tables


def world(rng: Random, at: Setting) -> list[Command]:
    """A scene on `fwalk` with some of the tables, one or several of whose values, names or parts are others."""
    at.copy("fwalk.toml")
    every = tomllib.loads(TABLES)
    chosen = rng.sample(sorted(every), rng.choice([1, 1, 1, 2, 3]))
    tables: dict[str, object] = {}
    for name in chosen:
        tables |= copy.deepcopy(every[name] if name in WITHIN else {name: every[name]})
    tables.setdefault("commands", copy.deepcopy({"load": every["commands"]["load"]}))
    named = rng.random() < 0.15
    scene = {"name": "mine", "base": "fwalk.toml", "duration": 0.02} | (tables if named else changed(tables, rng))
    text = toml_text(scene)
    (at.folder / "scene.toml").write_bytes(mutated(text, rng) if rng.random() < 0.15 else text.encode())
    words = ["--set", f"{rng.choice(paths(tables))}={rng.choice(NUMBERS)}"] if named else []
    if "learning" in chosen and rng.random() < 0.3:
        run = ["--iterations", "1", "--instances", "4", "--option", "steps=2", "-o", "out.h5", "--device", "cpu"]
        return [["learn", "scene.toml", *run, *words]]
    more: list[Command] = [
        ["judge", "scene.toml", *SHORT, "--json", "out.json"], ["gait", "scene.toml", *SHORT],
        ["scale", "scene.toml", "-o", "out.toml", "--height", str(rng.choice(NUMBERS))],
        ["scale", "scene.toml", "-o", "out.toml", "--mass", "50", "--length", f"*leg={rng.choice(NUMBERS)}"],
        ["simulate", "scene.toml", *SHORT, "--command", f"load={rng.choice(NUMBERS)}", "-o", "out.h5"],
        ["optimize", "scene.toml", *SEARCH, "-o", "out.h5"], ["convert", "scene.toml", "-o", "out.osim"],
        ["video", "scene.toml", *SHORT, "-o", "out.gif", "--size", "96x64"],
    ]  # fmt: skip
    commands = [rng.choice(more)] if rng.random() < 0.3 else scene_commands("scene.toml", rng)
    return [command + words for command in commands[:1]] + commands[1:]
