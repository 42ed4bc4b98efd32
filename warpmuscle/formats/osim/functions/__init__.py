"""Functions of one coordinate: lines, polynomials and splines, read, evaluated and put into each other.

May import: core, scene, formats.osim.
To add: a class of OpenSim's functions to `read.read_function`.
"""

from warpmuscle.formats.osim.functions.composed import BEYOND as BEYOND
from warpmuscle.formats.osim.functions.composed import composed as composed
from warpmuscle.formats.osim.functions.composed import resampled as resampled
from warpmuscle.formats.osim.functions.function import IDENTITY as IDENTITY
from warpmuscle.formats.osim.functions.function import ZERO as ZERO
from warpmuscle.formats.osim.functions.function import Function as Function
from warpmuscle.formats.osim.functions.read import owned_function as owned_function
from warpmuscle.formats.osim.functions.read import read_function as read_function
from warpmuscle.formats.osim.functions.within import ENDLESS as ENDLESS
from warpmuscle.formats.osim.functions.within import span_within as span_within
from warpmuscle.formats.osim.functions.within import spans_within as spans_within
