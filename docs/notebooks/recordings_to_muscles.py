# %% [markdown]
# # From recordings to muscles
# Angles of joints, as a laboratory or inverse kinematics gives them, tell which moments moved the joints, and which
# muscles may have made them.

# %%
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

# %%
model = BodyModel("arm.osim")
reach = read_coordinates("reach.mot", model.scene)
moments = wm.inverse_dynamics(model, reach)
moments

# %%
muscles = wm.static_optimization(model, reach)
muscles
