"""The figures of a tire, written as files."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import pandas as pd

from ...boundary.bounded_file import write_whole
from ...boundary.errors import UnknownName, path_from, writing
from ...boundary.named_options import named
from ...drawing.picture import DPI, picture, rendered
from ..tire_argument import TireLike, tire_from
from .surface_figure import surfaces
from .tire_figures import combined, pure, sketched

FORMATS = ("png", "svg", "pdf")
_DATELESS = {"png": None, "svg": {"Date": None}, "pdf": {"CreationDate": None}}


@named()
def draw(
    tire: TireLike,
    folder: str | Path,
    *,
    loads: Sequence[float] | None = None,
    signs: str = "iso",
    suffix: str = "png",
    points: pd.DataFrame | None = None,
    kappa: Sequence[float] | None = None,
) -> list[Path]:
    """Draw a tire: one file of pure slip curves, one of surfaces per load, one of Fy against Fx.

    Parameters
    ----------
    tire : Tire, path of a .tir file, or name of a published tire
        Upright and, except for load and slips, at its nominal inputs.
    folder : str or Path
        Created if it does not exist.
    loads : sequence of float, N, optional
        `default_loads` if None.
    signs : {"iso", "adapted-sae", "sae"}
        Convention in which the figures are drawn.
    suffix : {"png", "svg", "pdf"}
        Format of the files.
    points : pandas.DataFrame, optional
        Measured rows in SI units and ISO signs, drawn as points.
    kappa : sequence of float, optional
        Lowest and highest longitudinal slip of the figures; by default the range in which the tire is known, at most
        -1 to 1.

    Returns
    -------
    list of Path
        ``pure``, ``surfaces_<load>N`` and ``combined``; the same bytes for the same tire.

    Raises
    ------
    UnknownName
        If the convention or the format does not exist.
    TirefmuError
        If a load is not above 0, the range of kappa is not ascending, the tire has no force or one that is not finite,
        or a file cannot be written. No partial file remains.

    Examples
    --------
    >>> from tempfile import TemporaryDirectory
    >>> with TemporaryDirectory() as folder:
    ...     [path.name for path in draw("unicamp_small_tire", folder, loads=[60.0])]
    ['pure.png', 'surfaces_60N.png', 'combined.png']
    """
    if suffix not in FORMATS:
        raise UnknownName("format of figures", suffix, FORMATS)
    sketch = sketched(tire_from(tire), loads, signs, points, kappa)
    target = path_from(folder, "folder")
    figures = {"pure": picture(pure(sketch))}
    figures |= {f"surfaces_{load:g}N": surfaces(sketch, load) for load in sketch.loads}
    figures["combined"] = picture(combined(sketch))
    # All are rendered before the first is written: after a failure the folder is unchanged.
    images = {
        f"{name}.{suffix}": rendered(figure, suffix, DPI, metadata=_DATELESS[suffix])
        for name, figure in figures.items()
    }
    with writing(target):
        target.mkdir(parents=True, exist_ok=True)
        return [write_whole(target / name, image) for name, image in images.items()]
