"""Muscle models: sets of normalised curves, by the name that a scene has for them. Without Warp, for scenes to know.

The functions of a set are in a file of its name, `lee_curves.py` for lee.

- lee: Lee 2014 as in Bergmann 2017, eq. 4-6. That source treats the tendon as rigid; Thelen's curve stands in.
- thelen: Thelen 2003 with the constants of OpenSim 4.6.
- millard: Millard 2013 with the default curves of OpenSim 4.6's Millard2012EquilibriumMuscle.
- de_groote: De Groote 2016 with the constants of OpenSim 4.6, which corrected them so that f_l(1) = f_v(0) = 1,
  f_v(-1) = 0, and the tendon is slack at strain 0.
- thelen_explicit: Thelen's with a force-velocity curve that does not depend on the activation: (1 + v)/(1 - 4 v)
  shortening, (1 + 35 v)/(1 + 25 v) lengthening (Thelen 2003, eq. 6 and 7 at full activation, solved for the force).
- sarshari: Sarshari 2018 (thesis, EPFL), as the CusToM toolbox (Muller 2019) has them: a bell of width 0.0955, and a
  force-velocity curve that is 0.955 at rest. Thelen's tendon.
- mujoco: those of MuJoCo's muscle actuators with their default numbers; a rigid tendon.
- hyfydy: the polynomials of Hyfydy's muscle_force_m2012fast, near those of Millard 2013 (Hyfydy User Manual 1.0.2).
"""

from typing import Literal, get_args

CurveSet = Literal["lee", "thelen", "millard", "de_groote", "thelen_explicit", "sarshari", "mujoco", "hyfydy"]
CURVES: dict[str, int] = {name: number for number, name in enumerate(get_args(CurveSet))}  # as kernels number them
PATH_ACTUATOR, LIGAMENT, BLANKEVOORT = (len(CURVES) + k for k in range(3))  # in the place of curves, see `cables.py`
SPLINE = len(CURVES) + 3  # curves through knots, which muscles have only as a shape of their own, see `splines.py`
LEE, THELEN, MILLARD = CURVES["lee"], CURVES["thelen"], CURVES["millard"]
DE_GROOTE, THELEN_EXPLICIT, SARSHARI = CURVES["de_groote"], CURVES["thelen_explicit"], CURVES["sarshari"]
