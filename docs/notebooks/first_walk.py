# %% [markdown]
# # A first walk
# A biped of 15 bodies walks on 56 muscles. Needs `pip install "warpmuscle[plot]"`.

# %%
import warpmuscle as wm

run = wm.simulate("walk56_person", duration=2)
run

# %% [markdown]
# Its hip flexion beside people's, over one stride where there are strides:

# %%
run.plot("hip flexion")

# %% [markdown]
# The motion itself, to be turned, and kept for `warpmuscle view`:

# %%
run.save("walk.h5")
run.show()
