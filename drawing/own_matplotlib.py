"""What figures use of matplotlib, and its own settings for them: no file and no program changes a figure of tirefmu.

Importing matplotlib reads the file ``matplotlibrc`` of the working folder, which may come with the data: it can make
each text run LaTeX. It is therefore imported only here, from this folder.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import chdir, contextmanager
from pathlib import Path

with chdir(Path(__file__).parent):
    from matplotlib import colormaps as colormaps
    from matplotlib import rc_context, rcParamsDefault
    from matplotlib.axes import Axes as Axes
    from matplotlib.backends.backend_agg import FigureCanvasAgg as FigureCanvasAgg
    from matplotlib.cm import ScalarMappable as ScalarMappable
    from matplotlib.colors import LinearSegmentedColormap as LinearSegmentedColormap
    from matplotlib.colors import Normalize as Normalize
    from matplotlib.figure import Figure
    from matplotlib.patheffects import Normal as Normal
    from matplotlib.patheffects import Stroke as Stroke
    from matplotlib.ticker import MaxNLocator as MaxNLocator

#: Not the figure that is data.
MatplotlibFigure = Figure
#: The default settings of matplotlib, except for the program that shows windows; an SVG file is the same each time.
SETTINGS = {name: value for name, value in rcParamsDefault.items() if "backend" not in name}
SETTINGS["svg.hashsalt"] = "tirefmu"


@contextmanager
def own_settings() -> Iterator[None]:
    """Use the default settings of matplotlib: around each function that creates or renders a figure.

    >>> from matplotlib import rcParams
    >>> with rc_context({"font.size": 30.0}):
    ...     with own_settings():
    ...         rcParams["font.size"]
    10.0
    """
    with rc_context(SETTINGS):
        yield
