"""Forces of muscles as OpenSim's static optimisation has them, which misses the angle of Millard's fibres."""

import warp as wp

from warpmuscle.kernels.muscle.muscle import pennation_cosine

wp.set_module_options({"enable_backward": False})


@wp.kernel
def leave_out_pennation(
    l_opt: wp.array[float], width: wp.array[float], fibre: wp.array3d[float], active: wp.array2d[float]
):  # fmt: skip
    """Active forces of Millard's muscles as OpenSim's static optimisation has them, at almost no pennation.

    It takes the fibre's length over its optimal one for metres where it asks for the angle (OpenSim 4.6,
    `Millard2012EquilibriumMuscle::calcActiveFiberForceAlongTendon`).

    Args:
        l_opt: (muscles,) m. width: (muscles,) m, of the fibres across the tendon; 0 where the force is to stay. fibre,
            active: see `fibre_forces_of`.
    """
    i, m = wp.tid()
    if width[m] > 0.0:
        x = fibre[0, i, m]
        active[i, m] *= pennation_cosine(x, width[m]) / pennation_cosine(x * l_opt[m], width[m])
