# %% [markdown]
# # From recordings to muscles
# Given the joint angles of a recorded motion, from a laboratory or from inverse kinematics: which moments moved the
# joints, and which muscles may have made them? Needs `pip install "warpmuscle[plot,data]"`.
#
# A small arm and a reach of one second stand for your model and your recording:

# %%
import numpy as np

import warpmuscle as wm
from warpmuscle.examples import write

write("model")  # arm.osim
time = np.linspace(0.0, 1.0, 101)
bent = 60.0 * (10 * time**3 - 15 * time**4 + 6 * time**5)  # degrees: the smoothest reach (Flash and Hogan 1985)
rows = "\n".join(f"{t:.2f}\t{0.3 * b:.6f}\t{b:.6f}" for t, b in zip(time, bent, strict=True))
with open("reach.mot", "w") as file:
    file.write(f"reach\nnRows=101\nnColumns=3\ninDegrees=yes\nendheader\ntime\tshoulder\telbow\n{rows}\n")

# %% [markdown]
# ## Moments
# Inverse dynamics gives a moment for each joint and frame:

# %%
moments = wm.inverse_dynamics("arm.osim", "reach.mot")
moments

# %%
_ = moments.to_dataframe().plot(ylabel="moment (N m)", figsize=(7, 2.5))

# %% [markdown]
# ## Muscles
# Static optimization shares each moment among the muscles so that the sum of their squared activations is as small as
# possible:

# %%
muscles = wm.static_optimization("arm.osim", "reach.mot")
muscles

# %%
_ = muscles.to_dataframe().plot(ylabel="activation", figsize=(7, 2.5))

# %% [markdown]
# What the muscles cannot give is left as a `reserve`, in N m:

# %%
float(abs(muscles.reserve).max())
