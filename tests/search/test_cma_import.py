"""What the package of CMA-ES is imported with."""

import subprocess
import sys


def test_the_package_is_imported_without_what_only_its_plots_need():
    code = (
        "import sys; import warpmuscle.search.cma as own; assert own.cma.CMAEvolutionStrategy; "
        "print('matplotlib' in sys.modules, 'scipy.stats' in sys.modules); import matplotlib.pyplot, scipy.stats"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["False", "False"]
