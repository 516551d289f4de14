"""Run the self-test of a printed Modelica package with rumoca; print the largest difference of each function.

    python run_modelica.py NAME_selftest.mo

Exit code 1: an assertion stopped the simulation.
"""

from __future__ import annotations

import re
import sys
from pathlib import Path

import rumoca

from tirefmu.symbolic.printers.languages.program import FUNCTIONS


def main(path: Path) -> int:
    """Simulate the model: a row of stored results each second."""
    rows = int(re.findall(r"constant Real rows\[(\d+),", path.read_text(encoding="ascii"))[0])
    model = rumoca.Session().load(str(path), model=path.stem)
    try:
        result = model.simulate(t=(0.0, rows - 0.5), dt=1.0)
    except rumoca.RumocaError as error:
        sys.exit(str(error))
    if max(result["row"]) < rows:
        sys.exit("not all rows were compared")
    for name in FUNCTIONS:
        if name in result.names:
            print(name, f"{max(result[name]):.3g}")
    return 0


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1])))
