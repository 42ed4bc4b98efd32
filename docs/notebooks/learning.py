# %% [markdown]
# # Learning
# A policy learns to move a body, here for two iterations only; a walk takes minutes on a GPU. Needs
# `pip install "warpmuscle[learn]"`.

# %%
import warpmuscle as wm

options = {"instances": 16, "steps": 8, "minibatches": 1, "hidden": [16]}
learnt = wm.learn("walk56", "policy.h5", options=options, iterations=2, device="cpu")
learnt.evaluation

# %%
wm.simulate("walk56", duration=1, policy="policy.h5").show()
