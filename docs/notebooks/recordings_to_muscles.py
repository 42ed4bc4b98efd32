# %% [markdown]
# # From recordings to muscles
# Given the joint angles of a recorded motion, from a laboratory or from inverse kinematics: which moments moved the
# joints, and which muscles may have made them? Needs `pip install "warpmuscle[plot]"`.
#
# A small arm and a reach of one second stand for your model and your recording:

# %%
import matplotlib.pyplot as plt
import numpy as np

import warpmuscle as wm
from warpmuscle.examples import write
from warpmuscle.inverse.body_model import BodyModel
from warpmuscle.inverse.files import read_coordinates

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
model = BodyModel("arm.osim")
reach = read_coordinates("reach.mot", model.scene)
moments = wm.inverse_dynamics(model, reach)
moments

# %%
plt.figure(figsize=(7, 2.5))
plt.plot(moments.times, moments.values, label=moments.names)
plt.xlabel("time (s)")
plt.ylabel("moment (N m)")
_ = plt.legend()

# %% [markdown]
# ## Muscles
# Static optimization shares each moment among the muscles so that their squared activations are smallest. What they
# cannot give is left as a `reserve`, here next to nothing:

# %%
muscles = wm.static_optimization(model, reach)
muscles

# %%
plt.figure(figsize=(7, 2.5))
plt.plot(muscles.times, muscles.activation, label=muscles.muscles)
plt.xlabel("time (s)")
plt.ylabel("activation")
_ = plt.legend()

# %%
float(abs(muscles.reserve).max())  # N m
