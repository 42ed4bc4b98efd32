# %% [markdown]
# # Learning
# A policy learns to move a body, here for two iterations only, to show how; a walk takes minutes on a GPU and
# hundreds of iterations. Needs `pip install "warpmuscle[learn]"`.

# %%
import warpmuscle as wm

options = {"instances": 16, "steps": 8, "minibatches": 1, "hidden": [16]}
learnt = wm.learn("walk56", "policy.h5", options=options, iterations=2, device="cpu")

# %% [markdown]
# How well it does: `completed` is the share of bodies that stay up for the whole time. So early it is none.

# %%
learnt.evaluation

# %% [markdown]
# The file holds the policy, which moves the scene without PyTorch:

# %%
wm.simulate("walk56", duration=1, policy="policy.h5").show()
