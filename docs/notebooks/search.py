# %% [markdown]
# # A search
# A search finds the free parameters of a scene by running many candidates at once. A real one takes thousands; these
# few show how it is done. Needs `pip install "warpmuscle[plot]"`.

# %%
import warpmuscle as wm

scene = wm.load("fwalk", set={"duration": 1.0})
found = wm.optimize(scene, candidates=24, search="cma", seed=1)
found

# %% [markdown]
# The cost of each candidate, and of the best so far:

# %%
found.plot("convergence")

# %% [markdown]
# The scene with the best parameters is a scene like any other:

# %%
best, _ = wm.best_scene(found)
wm.simulate(best).show()
