"""The gait that a task imitates: of the scene's own controller, of a recorded motion, or of people by a norm alone.

May import: core, kernels, scene, results, gait, simulation, learning.
To add: another origin of a gait to a file of its own, and to `choice`, which chooses.
"""

from warpmuscle.learning.imitation.gait import BINS as BINS
from warpmuscle.learning.imitation.gait import CARRYING as CARRYING
from warpmuscle.learning.imitation.gait import Gait as Gait
from warpmuscle.learning.imitation.gait import imitated as imitated
from warpmuscle.learning.imitation.gait import measured_gait as measured_gait
from warpmuscle.learning.imitation.gait import recorded_gait as recorded_gait
from warpmuscle.learning.imitation.gait import seen_time as seen_time
from warpmuscle.learning.imitation.gait import with_norm as with_norm
from warpmuscle.learning.imitation.gait import with_step_width as with_step_width
from warpmuscle.learning.imitation.kept_gaits import gait_kept as gait_kept
from warpmuscle.learning.imitation.kept_gaits import kept as kept
from warpmuscle.learning.imitation.table import SPEEDS as SPEEDS
from warpmuscle.learning.imitation.table import gait_table as gait_table
from warpmuscle.learning.imitation.table import run_from as run_from
from warpmuscle.learning.imitation.table import smoothed_over_cycle as smoothed_over_cycle
