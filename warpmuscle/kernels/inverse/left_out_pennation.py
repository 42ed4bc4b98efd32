"""Forces of muscles as OpenSim's static optimisation has them, which misses the angle of some fibres."""

import warp as wp

from warpmuscle.kernels.muscle.muscle import pennation_cosine

wp.set_module_options({"enable_backward": False})


@wp.kernel
def leave_out_pennation(
    l_opt: wp.array[float], width: wp.array[float], taken: wp.array[float], fibre: wp.array3d[float],
    active: wp.array2d[float],
):  # fmt: skip
    """Active forces of muscles as OpenSim's static optimisation has them, at almost no pennation, or at none.

    Of Millard's muscles it takes the fibre's length over its optimal one for metres where it asks for the angle
    (OpenSim 4.6, `Millard2012EquilibriumMuscle::calcActiveFiberForceAlongTendon`). Of De Groote's it takes the force
    along the fibre (`DeGrooteFregly2016Muscle::calcInextensibleTendonActiveFiberForce`).

    Args:
        l_opt: (muscles,) m. width: (muscles,) m, of the fibres across the tendon; 0 where the force is to stay. taken:
            (muscles,) m, for how long OpenSim takes a fibre of optimal length; 0 where it asks for no angle. fibre,
            active: see `fibre_forces_of`.
    """
    i, m = wp.tid()
    if width[m] > 0.0:
        x = fibre[0, i, m]
        cosine = wp.float32(1.0)
        if taken[m] > 0.0:
            cosine = pennation_cosine(x * taken[m], width[m])
        active[i, m] *= cosine / pennation_cosine(x * l_opt[m], width[m])
