# %% [markdown]
# # A model of yours
# An OpenSim model is simulated by its file; a small arm of our own stands for yours.

# %%
import warpmuscle as wm
from warpmuscle.examples import write

write("model")  # arm.osim
run = wm.simulate("arm.osim", duration=0.5, excitations={"biceps": 0.3})
run

# %% [markdown]
# As a scene it can be edited, searched and learnt with:

# %%
wm.convert("arm.osim", "arm.toml")

# %% [markdown]
# Half the strength of the biceps, in N:

# %%
weak = wm.load("arm.toml", set={"character.muscles.biceps.f_max": {"factor": 0.5}})
weak.character.muscles["biceps"].f_max
