"""A notebook shows a figure of the package without pyplot."""

import pickle
import subprocess
import sys

import pytest

from small_result import march, walk_scene
from warpmuscle.core.errors import Error
from warpmuscle.plots import plot
from warpmuscle.plots.inline_figure import InlineFigure

PNG = b"\x89PNG\r\n\x1a\n"


def test_a_figure_draws_itself_for_a_notebook_and_has_no_window():
    figure = plot(march(walk_scene().character, 1.2), "angles", scene=walk_scene())
    assert isinstance(figure, InlineFigure)
    assert figure._repr_png_().startswith(PNG)
    assert pickle.loads(pickle.dumps(figure))._repr_png_().startswith(PNG)
    with pytest.raises(Error, match="a notebook shows a figure"):
        figure.show()


def test_no_window_system_is_asked_for():
    code = (
        "import sys; from warpmuscle.plots.style import page; page(2.0)._repr_png_(); "
        "print('matplotlib.pyplot' in sys.modules)"
    )
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert found.stdout.strip() == "False"
