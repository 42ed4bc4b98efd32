"""A file of a user of the package, for type checkers; `reveal_type` has them tell what they know."""

USER_FILE = """import warpmuscle as wm
from warpmuscle.kernels.muscle.muscle import fibre_force
scene = wm.load("walk56")
reveal_type(scene)
reveal_type(scene.duration)
print(fibre_force)
one, both = wm.inverse_dynamics("m.osim", "a.mot"), wm.inverse_dynamics("m.osim", ["a.mot", "b.mot"])
print(one.of("knee"), both[1].values, wm.joint_reactions("m.osim", "a.mot").columns())
print(wm.static_optimization("m.osim", "a.mot", power=3).activation, wm.track("m.osim", "a.mot", ground=True).rms)
print([run.rms for run in wm.track("m.osim", ("a.mot", "b.mot"))])
found = wm.read("effort.h5")
print(found.to_xarray().best_cost, found.to_dataframe(candidates=True), found.run("a").replays[0].com)
print(found.replays[0].to_xarray(), found.evaluations, found.best.cost)
wm.best_scene(found), wm.show(found), print(found.run(found.best), wm.read("effort.h5", "a").plot("angles"))
"""

KNOWN = r"mine\.py:4\b.*\bScene\b", r"mine\.py:5\b.*\bfloat\b"  # what they tell
