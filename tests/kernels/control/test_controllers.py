"""Shipped controllers: what one needs is named by an error."""

import pytest

from warpmuscle.kernels.control.controllers import CONTROLLERS, checked
from warpmuscle.kernels.control.joint_pd import joint_pd


def test_a_controller_that_drives_nothing_is_told():
    assert all(one.shipped for one in CONTROLLERS.values())
    for bare in (joint_pd._replace(effort=None), joint_pd._replace(effort=None, damping=None)):
        with pytest.raises(TypeError, match=r"controller 'mine' in CONTROLLERS needs a Warp function"):
            checked("mine", bare)
    assert checked("mine", joint_pd) is joint_pd
