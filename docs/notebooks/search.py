# %% [markdown]
# # A search
# Free parameters of a scene are found by running many candidates at once. A real search takes thousands of them;
# these few show how it is done.

# %%
import warpmuscle as wm

scene = wm.load("fwalk", set={"duration": 1.0})
found = wm.optimize(scene, candidates=24, search="cma", seed=1)
found

# %%
found.plot("convergence")

# %%
best = wm.best_scene(found)[0]
wm.simulate(best).show()
