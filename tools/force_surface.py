"""Force of a muscle over fibre length and speed: a million points with the package's Warp functions.

python tools/force_surface.py              time and largest force
python tools/force_surface.py --plot       also force_surface.png
"""

import sys
import time

import numpy as np
import warp as wp

from warpmuscle.kernels.curve.curves import MILLARD
from warpmuscle.kernels.muscle.muscle import FIBRE_DAMPING, fibre_force

side = 1000
lengths, speeds = np.meshgrid(np.linspace(0.4, 1.7, side), np.linspace(-1.0, 1.0, side))  # over l_opt, over v_max
length = wp.array(lengths.ravel(), dtype=float)
speed = wp.array(speeds.ravel(), dtype=float)
force = wp.map(fibre_force, MILLARD, 1.0, length, speed, FIBRE_DAMPING)  # the first call compiles
start = time.perf_counter()
wp.map(fibre_force, MILLARD, 1.0, length, speed, FIBRE_DAMPING, out=force)
surface = force.numpy().reshape(side, side)
print(f"{surface.size:.0e} forces in {time.perf_counter() - start:.3f} s, largest {surface.max():.3f} f_max")

if "--plot" in sys.argv:
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(subplot_kw={"projection": "3d"}, figsize=(7, 6), layout="constrained")
    axes.plot_surface(lengths, speeds, surface, cmap="viridis", rcount=60, ccount=60)
    axes.set(xlabel="fibre length / l_opt", ylabel="speed / v_max", zlabel="force / f_max")
    axes.view_init(25.0, -125.0)
    figure.savefig("force_surface.png", dpi=150)
