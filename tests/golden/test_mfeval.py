"""Results of MFeval for MF5.2, MF6.1, MF6.2 and turn slip: every column, in every language, and from the .tir."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pandas as pd
import pytest

import tirefmu
from tirefmu.symbolic.models import MODELS
from tirefmu.tires import Tire

#: Columns of MFeval and names of tirefmu.
COLUMNS = {
    "Fx": "Fx", "Fy": "Fy", "Mz": "Mz", "Mx": "Mx", "My": "My", "Re": "R_e", "omega": "omega", "rho": "rho",
    "Rl": "R_l", "Cz": "c_z", "2a": "a", "2b": "b", "t": "trail", "Mzr": "M_zr", "mux": "mu_x", "muy": "mu_y",
    "Kxk": "K_xkappa", "Kya": "K_yalpha", "Cx": "c_x", "Cy": "c_y", "sigmax": "sigma_x", "sigmay": "sigma_y",
}  # fmt: skip
#: The inputs as MFeval read them, and as it prints them.
INPUTS = {"kappa": "kappa", "alpha": "alpha", "gamma": "gamma", "Fz": "Fz", "p": "P", "V": "Vx", "phit": "phit"}
#: For results of the loaded radius of MF6.2: the secant method of MFeval stops at 1e-6 nominal loads.
SECANT = {"rho": 1e-7, "Rl": 1e-7, "Cz": 1e-5}
TOLERANCE = 1e-10


@dataclass(frozen=True)
class Case:
    """A golden file: results and coefficients."""

    model: str
    table: str
    tir: str


CASES = {
    "mf52": Case("mf52", "mf52_MagicFormula52.csv.xz", "MagicFormula52_Parameters.tir"),
    "mf61": Case("mf61", "mf61_MagicFormula61.csv.xz", "MagicFormula61_Parameters.tir"),
    "mf61-turnslip": Case("mf61", "mf61_MagicFormula61_turnslip.csv.xz", "MagicFormula61_Parameters.tir"),
    "mf62": Case("mf62", "mf62_MagicFormula62.csv.xz", "MagicFormula62_Parameters.tir"),
}


@pytest.fixture(params=CASES.values(), ids=CASES)
def case(request) -> Case:
    return request.param


@pytest.fixture
def rows(case, golden) -> pd.DataFrame:
    return pd.read_csv(golden / case.table)


@pytest.fixture
def values(case, parameters_of) -> dict[str, float]:
    return parameters_of(case.model)


@pytest.fixture
def tire(case, values) -> Tire:
    return Tire(case.model, {name: values[name] for name in MODELS[case.model].coefficients if name in values})


def inputs(rows: pd.DataFrame) -> pd.DataFrame:
    return pd.DataFrame({name: rows[f"{name}_in"] for name in INPUTS})


def unloadable(rows: pd.DataFrame, values: dict[str, float]) -> pd.Series:
    """Return the rows in which MFeval found no loaded radius: it then prints its last trial."""
    wheel = rows["omega"] * values["UNLOADED_RADIUS"] / values["LONGVL"]
    free = values["UNLOADED_RADIUS"] * (values["Q_RE0"] + values["Q_V1"] * wheel**2)
    return (rows["rho"] < 1e-4) | (rows["Rl"] > free)


def rounding(rows: pd.DataFrame, values: dict[str, float]) -> dict[str, float]:
    """Return the accuracy of rho, Rl and Cz in double precision in (-q + sqrt(q^2 + 4 Q_FZ2 c)) / (2 Q_FZ2).

    MFeval's form cancels where Q_FZ2 is small: an error of a few ulp of q is multiplied by 1 / (2 Q_FZ2).
    """
    linear = values["VERTICAL_STIFFNESS"] * values["UNLOADED_RADIUS"] / values["FNOMIN"]
    length = 4 * np.finfo(float).eps * linear / (2 * values["Q_FZ2"]) * values["UNLOADED_RADIUS"]
    return {"rho": length, "Rl": length, "Cz": length / rows["rho"].min()}


def errors(answer: pd.DataFrame, rows: pd.DataFrame, case: Case, values: dict[str, float]) -> dict[str, float]:
    """Return each column's largest |error| / (1 + |reference|) in units of its tolerance; NaN if any number is NaN."""
    allowed = dict.fromkeys(COLUMNS, TOLERANCE)
    if case.model == "mf62":
        allowed |= SECANT
    else:
        allowed |= {name: TOLERANCE + more for name, more in rounding(rows, values).items()}
    found = {}
    for theirs, ours in COLUMNS.items():
        compared = ~unloadable(rows, values) if theirs in ("rho", "Rl", "Cz") else rows.index >= 0
        column = answer.loc[compared, ours].to_numpy() * (2 if theirs in ("2a", "2b") else 1)
        reference = rows.loc[compared, theirs].to_numpy()
        found[theirs] = float(np.max(np.abs(column - reference) / (1 + np.abs(reference)))) / allowed[theirs]
    return found


def disagreeing(answer, rows, case, values) -> dict[str, float]:
    """Return the columns whose error exceeds the tolerance."""
    return {name: error for name, error in errors(answer, rows, case, values).items() if not error < 1}


def test_every_column_and_almost_every_row_is_compared(rows, case, values):
    columns = {"kind", "iKya_rowdiff_ignore", *COLUMNS, *INPUTS.values(), *(f"{name}_in" for name in INPUTS)}
    assert set(rows.columns) == columns
    assert len(rows) == {"mf52": 600, "mf61": 600, "mf62": 300}[case.model] or "turnslip" in case.table
    assert unloadable(rows, values).sum() <= (case.model == "mf62")
    assert not rows[list(COLUMNS)].isna().any(axis=None)


def test_inputs_are_returned_unchanged(rows):
    for ours, theirs in INPUTS.items():
        assert (rows[f"{ours}_in"] == rows[theirs]).all()


@pytest.mark.parametrize("code", ["numpy", "c", "casadi"])
def test_every_column_from_every_language(rows, case, values, tire, code):
    assert disagreeing(tire.evaluate(inputs(rows), code=code), rows, case, values) == {}


def test_the_file_itself(rows, case, values, golden):
    """The defaults for missing keys of the .tir are those of MFeval."""
    tire = tirefmu.load(golden / case.tir)
    assert tire.model == case.model
    assert disagreeing(tire.evaluate(inputs(rows)), rows, case, values) == {}


def test_nan_is_a_difference(rows, case, values, tire):
    answer = tire.evaluate(inputs(rows))
    answer.loc[7, "B_t"] = np.nan
    assert disagreeing(answer, rows, case, values) == {}
    answer.loc[7, ["trail", "rho"]] = np.nan
    assert disagreeing(answer, rows, case, values).keys() == {"t", "rho"}


@pytest.mark.parametrize("column", COLUMNS)
def test_a_small_error_in_a_column_is_detected(rows, case, values, tire, column):
    answer = tire.evaluate(inputs(rows))
    answer[COLUMNS[column]] *= 1 + 1e-3
    assert column in disagreeing(answer, rows, case, values)


def test_the_transcription_gives_the_same(rows, case, values, sheet):
    columns = {name: column.to_numpy() for name, column in inputs(rows).items()}
    answer = pd.DataFrame(sheet.evaluate(values, columns, model=case.model))
    assert disagreeing(answer, rows, case, values) == {}
