"""A tire: evaluated, saved, drawn."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy.typing as npt

from ..boundary.errors import UnknownName
from .definition import TireDefinition
from .evaluation import Conventions, evaluate, forces
from .forces import Forces
from .input_check import SignedTable, checked_inputs, checked_table
from .property_file.names import not_given
from .property_file.writing import write_tir
from .summary import tire_html, tire_text

if TYPE_CHECKING:
    import pandas as pd

    from ..drawing.own_matplotlib import MatplotlibFigure


class Tire(TireDefinition):
    """A tire with values for every coefficient of its model.

    Parameters
    ----------
    model : str
        Name of the model, such as "mf96".
    values : mapping of str to float
        Coefficients by .tir name in SI units; missing ones take the model's default in these signs
        (`defaulted` lists them). FNOMIN and UNLOADED_RADIUS are required.
    effects : collection of str, optional
        The effects that the tire has; all of the model if None. Coefficients that only an absent effect reads are set
        to neutral.
    signs : str
        The convention in which the coefficients are written: "iso" (default) or "adapted-sae".
    name : str
        For texts and files.
    about : mapping of str to str
        Origin of the tire: source, fit, remarks; the keys are lower-case words.
    ranges : mapping of str to (float, float)
        The range of each input in which the tire is known, by input name. If the model has coefficients for a range
        (KPUMIN, KPUMAX, ...), they have the same values.
    side : str
        The side of the vehicle to which the coefficients apply, TYRESIDE of the file: "left", "right", "symmetric"
        or "". It has no influence by itself; see `mirror` of `evaluate`. The coefficients that differ between left
        and right are 0 if a file with 'SYMMETRIC' is read.
    added : tuple of AddedEffect
        Effects beyond the book. Those of the library are added by their names in `effects`.
    other_entries : tuple of (str, str, str)
        Section, key and text of a file's entries that the model does not use, written again when the tire is saved.

    Raises
    ------
    UnknownName
        If the model, an effect, a coefficient or an input does not exist.
    TireError
        If a value is not a finite number, an indispensable one is missing, or a range is crossed.

    Examples
    --------
    >>> from tirefmu.tires import published
    >>> tire = published("trento_hoosier")
    >>> round(float(tire.forces(alpha=0.1, Fz=1000.0)["Fy"]))
    1886
    """

    def __getitem__(self, name: str) -> float:
        """Return the value of a coefficient.

        Parameters
        ----------
        name : str
            Its .tir name.

        Returns
        -------
        float
            In the unit of its declaration.

        Raises
        ------
        UnknownName
            If the model has no such coefficient.

        Examples
        --------
        >>> from tirefmu.tires import published
        >>> published("trento_hoosier")["FNOMIN"]
        220.0
        """
        if name not in self.values:
            raise UnknownName(f"coefficient of {self.model}", name, self.values)
        return float(self.values[name])

    def forces(self, *, code: str = "auto", **inputs: npt.ArrayLike) -> Forces:
        """Return forces and moments in the tire's own signs, in steady state.

        Parameters
        ----------
        code : {"auto", "numpy", "c", "casadi", "batch"}
            Which generated code evaluates; "auto": NumPy for few rows, the batch kernel for many where there is
            a compiler.
        **inputs : array_like
            kappa (fraction), alpha, gamma (rad), Fz (N), p (Pa), V (m/s), phit (1/m), of shapes that
            broadcast; a missing one takes its nominal value, one that the model does not read has no
            influence. The conventions of `evaluate` are at their defaults.

        Returns
        -------
        Forces
            Arrays of the broadcast shape, N and N m. Zero where Fz <= 0; NaN where an input is NaN.

        Raises
        ------
        UnknownName
            If an input is none of the public tables.
        WrongType
            If an input is not numeric.
        TirefmuError
            If a value is outside the range of its input in SI units, such as alpha = 5 (degrees), slip in percent or a
            negative Fz; if a load is far beyond those of the tire (above five times FZMAX, or 25 times FNOMIN without
            it); or if the shapes do not broadcast. The formula itself has values beyond 90 deg: a table of
            `tirefmu.evaluate` that declares ``alpha [deg]`` may have such rows, and so may inputs of an FMU.

        Warns
        -----
        TirefmuWarning
            If |kappa| of most values is 2 or more: right for a wheel that spins, and probable for slip in percent.
        """
        return forces(self, checked_inputs(self, inputs), code)

    def evaluate(
        self,
        table: pd.DataFrame | SignedTable,
        *,
        signs: str | None = None,
        convention: str = "tno",
        slip_angle: str = "tan",
        limits: bool = False,
        mirror: bool = False,
        steady: bool = False,
        hold: bool = False,
        code: str = "auto",
    ) -> pd.DataFrame:
        """Evaluate forces and every named quantity for each row of a table.

        Parameters
        ----------
        table : pandas.DataFrame or Recording
            Input columns in SI units, with the names of the public tables; an absent one takes the nominal
            value. An input under another name (``SA``, ``Alpha``) is refused, other columns are ignored.
            `tirefmu.evaluate` also takes the path of a file.
        signs : {"iso", "adapted-sae", "sae"}, optional
            The table's convention; the result comes back in it. Where None: "iso" for a DataFrame, a recording's
            own. Named quantities are those of the formula written in it ("sae": in adapted SAE).
        convention : {"tno", "book"}
            As in the industry's solvers, or as printed in Pacejka (2012), section 4.E. MF96 has one form.
        slip_angle : {"tan", "angle"}
            alpha* and gamma*: tangent and sine, or the angles themselves. MF96 has the angles.
        limits : bool
            Keep the inputs within the ranges in which the tire is known; in MF5.2 to 6.2 slips also fade out
            below VXLOW and curvature factors are 1 at most.
        mirror : bool
            Evaluate the tire as mounted on the other side of the vehicle than the one it was measured for.
            Named quantities are those of the tire as measured, at mirrored inputs.
        steady : bool
            Evaluate each row independently. Otherwise, if the table has a column t and the tire a relax_* effect, slips
            lag behind the inputs from row to row; the columns ``kappa_lagged`` and ``alpha_lagged`` are the acting
            slips.
        hold : bool
            Inputs are held over each step, as in a co-simulation; otherwise they are linear between rows.
        code : {"auto", "numpy", "c", "casadi", "batch"}
            Which generated code evaluates; "auto": NumPy for few rows, the batch kernel for many where there is
            a compiler.

        Returns
        -------
        pandas.DataFrame
            The input columns, the model's forces, the named quantities; the table's index.

        Raises
        ------
        DataError
            If an input is NaN or infinite, in another unit than SI or of the wrong sign (a channel whose unit its file
            declares is not checked; up to half of the loads may be negative, those of a lifted wheel with noise), or
            a load is far beyond those of the tire (above five times FZMAX, or 25 times FNOMIN without it).
        UnknownName
            If a convention does not exist.
        WrongType
            If it is not a table.

        Examples
        --------
        >>> from tirefmu.tires import published
        >>> import pandas as pd
        >>> table = pd.DataFrame({"alpha": [0.0, -0.1], "Fz": 1000.0})
        >>> published("trento_hoosier").evaluate(table)["Fy"].round().tolist()
        [-89.0, 1948.0]
        """
        rows, written = checked_table(self, table, signs, limited=limits)
        conventions = Conventions(written, convention, slip_angle, limits, mirror, steady, hold)
        return evaluate(self, rows, conventions, code)

    def save(self, path: str | Path) -> None:
        """Write the tire as a .tir file, in ISO-W.

        Parameters
        ----------
        path : str or Path
            A .tir file; an existing one is replaced.
        """
        write_tir(self, path)

    def plot(
        self,
        data: pd.DataFrame | SignedTable | str | None = None,
        kind: str = "pure",
        *,
        loads: Sequence[float] | None = None,
        signs: str = "iso",
    ) -> MatplotlibFigure:
        r"""Draw the tire, and measured rows with it.

        Parameters
        ----------
        data : pandas.DataFrame (SI units, ISO signs) or Recording, optional
            Rows that are drawn as points at the loads at which they were measured. A str is taken as `kind`:
            ``plot("combined")``.
        kind : {"pure", "surfaces", "combined"}
            Fx over kappa, Fy and Mz over alpha in pure slip; Fx and Fy over both slips; Fy against Fx.
        loads : sequence of float, N, optional
            By default those of the data, or three over the tire's range. Surfaces are drawn at the middle one.
        signs : {"iso", "adapted-sae", "sae"}
            Convention in which the figure is drawn.

        Returns
        -------
        matplotlib.figure.Figure
            Not registered in pyplot: ``figure.savefig("tire.png")`` writes it.

        Raises
        ------
        UnknownName
            If the kind or the convention does not exist.
        TirefmuError
            If a load is not positive, or the tire has no force or one that is not finite.
        DataError, WrongType
            If the data are in another unit or sign, or no table.

        Examples
        --------
        >>> from tirefmu.tires import published
        >>> figure = published("unicamp_small_tire").plot(loads=[110.0])
        >>> [ax.get_title() for ax in figure.axes][1]
        'Fy over α at κ = 0'
        """
        from .drawing.surface_figure import plot  # imports matplotlib, which is slow
        from .drawing.tire_figures import points_of

        table: Any = data  # a path is refused as no table
        if isinstance(data, str) and not Path(data).suffix:
            table, kind = None, data
        points = None if table is None else points_of(self, table)
        return plot(self, kind, loads=loads, signs=signs, points=points)

    def __repr__(self) -> str:
        """Return a few lines: model, signs, nominal inputs, ranges, effects."""
        return tire_text(self, not_given(self))

    def _repr_html_(self) -> str:
        """Return the same as a table, the coefficients, and the curves in pure slip, for a notebook."""
        from .drawing.surface_figure import notebook_figure  # imports matplotlib, which is slow

        return tire_html(self, not_given(self)) + notebook_figure(self)
