"""A made recording and its truth: what a suite gives to the benchmark of the diagnosis."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import pandas as pd

from tirefmu.tires import Tire


@dataclass(frozen=True)
class Case:
    """A recording and its hidden effects.

    Attributes
    ----------
    name : str
    hidden : tuple of str
    effects : tuple of str
        Effects of the baseline model.
    nominal : mapping of str to float
    table, truth : pandas.DataFrame
        The recording, and the same without disturbances.
    test : pandas.DataFrame
        Other manoeuvres without disturbances.
    operating : pandas.DataFrame
        Operating conditions over the operating range and their steady forces, without disturbances.
    true_tire : callable
        Returns the true tire, without structure outside the library.
    same_form : frozenset of str
        Hidden effects whose true coefficients are those of `tire`.
    signs : str
        Sign convention of the tables.
    unknown : str
        Name of the structure that is not in the library, or "".
    """

    name: str
    hidden: tuple[str, ...]
    effects: tuple[str, ...]
    nominal: Mapping[str, float]
    table: pd.DataFrame
    truth: pd.DataFrame
    test: pd.DataFrame
    operating: pd.DataFrame
    true_tire: Callable[[], Tire]
    same_form: frozenset[str]
    signs: str = "adapted-sae"
    unknown: str = ""

    @property
    def tire(self) -> Tire:
        """The true tire, without structure outside the library."""
        return self.true_tire()
