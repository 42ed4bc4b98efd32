"""What somebody new types first, in a script that type checkers read as well; `test_first_guesses` runs it."""

import copy
import pickle
from importlib.util import find_spec
from pathlib import Path

import numpy as np

import warpmuscle as wm


def first_guesses(folder: Path) -> list[str]:
    """Some forty guesses; what each gave, as text."""
    said: list[str] = []

    def say(value: object) -> None:
        said.append(repr(value))

    say(wm.scenes()[:2])  # 1
    run = wm.simulate("fwalk", duration=1)  # 2
    say(run)
    page = run.show()  # 3
    page.save(folder / "run.html")
    say(run.plot())  # 4
    say(run.plot("rKnee"))  # 5
    say(run.to_xarray().sizes["time"])  # 6
    say(len(run.to_dataframe()))  # 7
    run.save(folder / "run.h5")  # 8
    run.save(folder / "page.html")  # 9
    say(wm.read(folder / "run.h5"))  # 10
    say(wm.show(folder / "run.h5"))  # 11
    say(wm.show(run))  # 12
    say(wm.show([run, folder / "run.h5"], over=True))
    say(run.plot("Joints"))
    say(run.plot("knee"))
    say(wm.plot(run, "joints"))
    say(run.plot(["hip flexion", "knee flexion"]))
    say(run.plot("com y"))
    say(run["joint_angle"].dims)
    say(run["hip flexion"].sel(side="left"))
    say(run["centre of mass y"].max())
    say(run.recording.window(0.2, 0.4).frames)
    say(wm.plot([run, run], "hip flexion"))
    say(wm.plot([run, folder / "run.h5"], "rKnee", folder / "knees.png"))
    say(wm.plot(run.recording, "hip flexion"))
    say(np.asarray(run["joint_angle"]).shape)
    say(pickle.loads(pickle.dumps(run)).time[-1])
    say(copy.deepcopy(run).scene == run.scene)
    say(run.to_xarray().sel(time=0.5, method="nearest")["com"].shape)
    say(run.to_dataframe().describe().shape)
    say(run.plot("joint angles"))
    say(wm.scenes("stairs").names)
    say(wm.scenes()["fwalk"].muscles)
    say(len(wm.scenes().to_dataframe()))
    say(list(run)[:3])
    say(sorted(dict(run)))
    say(wm.read(folder / "run.h5"))
    say(run["knee flexion"].mean("time").to_pandas())
    say(run.to_dataframe().iloc[3])
    run.save(folder / "run.mot")
    run.save(folder / "run.csv")
    say(run["knee_angle_r"].mean())
    say(run["grf"].sel(side="left", xyz="y").max())
    say(run.plot("hip flexion", norms=False, start=0.2))
    say(run.plot("kinematics"))
    say(wm.plot(run))
    scene = wm.load("fwalk", duration=0.5)  # 13
    say(scene["controller.states.0.time"])
    say(wm.load(scene, set={"gravity": 9.81}).gravity)
    say(scene._repr_html_()[:4])  # 14
    say(wm.show(scene))  # 15
    with wm.Rollout(scene, instances=4, record=[3]) as rollout:  # 16
        name = rollout.parameter_names[0]  # 17
        rollout.set_parameters({name: 0.65})  # 18
        rollout.set_parameters({name: np.linspace(0.6, 0.7, 4)})  # 19
        rollout.run()
        say(rollout.cost().shape)  # 20
        say(len(rollout))
        recording = rollout.recording(3)
        say(rollout[-1].frames)
        say(wm.Rollout(scene, 2, record=range(2)).names.bodies[:2])
        say(wm.plot(rollout, "hip flexion"))
        say(rollout._repr_html_()[:4])
        say(wm.show(rollout))
    say(wm.show(recording))  # 21
    say(recording._repr_html_()[:7])  # 22
    wm.save(run.scene, folder / "scene.toml")
    say(wm.simulate(folder / "scene.toml", 0.2))  # 23
    found = wm.optimize(scene, candidates=8)  # 24
    say(found.show())  # 25
    say(found.plot())
    say(found.plot("convergence"))
    found.save(folder / "found.h5")
    say(found._repr_html_()[:7])
    swept = wm.sweep(
        "fwalk", folder / "swept.h5", grid={"seed": [1, 2]}, search={"candidates": 2}, set={"duration": 0.1}
    )  # 26
    say(swept)
    say(swept._repr_html_()[:4])
    if find_spec("torch") and find_spec("rsl_rl"):
        learnt = wm.learn(
            "walk56", options={"instances": 8, "steps": 4, "minibatches": 1, "hidden": [4]}, iterations=1, device="cpu"
        )  # 27
        say(learnt.show())
    return said
