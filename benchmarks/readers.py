"""Other programs that evaluate property files: each reader returns forces and moments of a file at the rows of a table.

Whoever runs this fetches the programs; the path of each is a variable of the environment, and a program without one
takes no part.

TIREFMU_MFEVAL
    The folder above `+mfeval` of MFeval (MATLAB, run in Octave).
TIREFMU_OPENTIRE
    The folder `code` of OpenTirePython.
TIREFMU_MFPY
    The folder above `mfpy` of MFPy.
TIREFMU_CHRONO
    The folder `src` of Project Chrono. Its ChPac02Tire is compiled alone, with `chrono_reader.cpp`.
TIREFMU_MAGIC_FORMULA
    The folder `src` of teasit's magic-formula-tyre-library (MATLAB; the functions of its MF6.1 run in Octave).
TIREFMU_TYREDYN
    The folder above `src` of TyreDyn.
TIREFMU_PACEJKA_MODEL
    The folder of BrianN92's Pacejka-tire-model.
TIREFMU_PACEJKA
    The folder of evan-el's pacejka (C++), compiled with `pacejka_reader.cpp`.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import tempfile
import warnings
from collections.abc import Callable, Mapping
from functools import cache
from importlib import import_module
from pathlib import Path
from types import ModuleType

import numpy as np
import pandas as pd

#: Forces by name; a reader without one of them leaves it out.
Forces = Mapping[str, np.ndarray]
Reader = Callable[[Path, pd.DataFrame], Forces]
HERE = Path(__file__).parent
#: Functions of MATLAB that MFeval calls and Octave lacks, by file.
MATLAB_FUNCTIONS = {
    "contains.m": "function found = contains(text, part)\n  found = ! isempty(strfind(text, part));\nend\n",
    "+coder/extrinsic.m": "function extrinsic(name)\nend\n",
}
#: The headers of Chrono that ChPac02Tire includes; `chrono_reader.cpp` has what it uses of them.
CHRONO_HEADERS = (
    "chrono/core/ChDataPath.h", "chrono/functions/ChFunctionSineStep.h", "chrono/physics/ChBody.h",
    "chrono/assets/ChVisualShapeCylinder.h", "chrono_vehicle/ChConfigVehicle.h", "chrono_vehicle/ChVehicleDataPath.h",
    "chrono_vehicle/ChTerrain.h", "chrono_vehicle/wheeled_vehicle/tire/ChForceElementTire.h",
)  # fmt: skip


def octave(script: str, package: Path, files: Mapping[str, str], names: tuple[str, ...]) -> Forces:
    """Run a script in a folder with a package and some files, and return the columns that it prints.

    The package is copied: a function file of its name beside it, which both programs have, hides it in Octave.
    """
    with tempfile.TemporaryDirectory() as folder:
        shutil.copytree(package, Path(folder) / package.name)
        for file, text in {**files, "evaluate_rows.m": script}.items():
            path = Path(folder) / file
            path.parent.mkdir(exist_ok=True)
            path.write_bytes(text.encode("latin-1"))
        done = subprocess.run(
            ["octave-cli", "--norc", "--no-history", "--quiet", "evaluate_rows.m"],
            cwd=folder, capture_output=True, text=True, timeout=300, check=False,
        )  # fmt: skip
    if done.returncode:
        raise ValueError(done.stderr)
    return columns_of(done.stdout, names)


def columns_of(text: str, names: tuple[str, ...]) -> Forces:
    """Return columns of printed numbers by name."""
    table = np.array([line.split() for line in text.splitlines()], dtype=float).T
    return dict(zip(names, table, strict=True))


def rows_of(table: pd.DataFrame, *names: str) -> str:
    """Return columns of a table as text, every number with all its digits."""
    return "\n".join(" ".join(f"{value:.17g}" for value in row) for row in table[list(names)].to_numpy()) + "\n"


def text_of(path: Path) -> str:
    """Return a file as it is, byte by byte."""
    return path.read_bytes().decode("latin-1")


def mfeval(path: Path, table: pd.DataFrame, mode: int = 221) -> Forces:
    """Evaluate with MFeval; mode 221: combined slip, alpha* = tan(alpha), no limits."""
    script = (
        "warning('off', 'all'); solver = mfeval.Solver();\n"
        f"found = solver.fullSteadyState(mfeval.readTIR('tire.tir'), dlmread('rows.txt'), {mode});\n"
        "printf('%.17g %.17g %.17g %.17g %.17g\\n', found(:, [1 2 6 4 5])');\n"
    )
    rows = rows_of(table.assign(phit=0.0), "Fz", "kappa", "alpha", "gamma", "phit", "V")
    files = {**MATLAB_FUNCTIONS, "tire.tir": text_of(path), "rows.txt": rows}
    return octave(script, Path(os.environ["TIREFMU_MFEVAL"], "+mfeval"), files, ("Fx", "Fy", "Mz", "Mx", "My"))


def mfeval_with_crlf(path: Path, table: pd.DataFrame) -> Forces:
    """Evaluate with MFeval a copy of the file that has the line ends which its older readers expect."""
    with tempfile.TemporaryDirectory() as name:
        copy = Path(name) / path.name
        copy.write_bytes(b"\r\n".join(path.read_bytes().splitlines()) + b"\r\n")
        return mfeval(copy, table)


def magic_formula(path: Path, table: pd.DataFrame) -> Forces:
    """Evaluate with the functions of magic-formula-tyre-library, with its defaults for keys that the file lacks.

    Its classes, and so its reader, need MATLAB: the numbers are read here.
    """
    script = (
        "warning('off', 'all');\n"
        "names = textread('names.txt', '%s'); known = load('values.txt'); p = struct();\n"
        "for i = 1:numel(names) p.(names{i}) = known(i); end\n"
        "x = dlmread('rows.txt'); VX = x(:, 5); SX = x(:, 2); SA = x(:, 3); FZ = x(:, 1); IA = x(:, 4);\n"
        "IP = p.INFLPRES * ones(size(FZ)); FX = magicformula.v61.Fx(p, SX, SA, FZ, IP, IA, VX);\n"
        "FY = magicformula.v61.Fy(p, SX, SA, FZ, IP, IA, VX);\n"
        "MZ = magicformula.v61.Mz(p, SX, SA, FZ, IP, IA, VX, FX, FY);\n"
        "printf('%.17g %.17g %.17g\\n', [FX FY MZ]');\n"
    )
    values = _defaults_of_magic_formula() | numbers_of(path)
    if "INFLPRES" not in numbers_of(path):
        values["INFLPRES"] = values["NOMPRES"]  # an input there
    files = {
        "names.txt": "\n".join(values) + "\n", "values.txt": "\n".join(f"{v:.17g}" for v in values.values()) + "\n",
        "rows.txt": rows_of(table, "Fz", "kappa", "alpha", "gamma", "V"),
    }  # fmt: skip
    return octave(script, Path(os.environ["TIREFMU_MAGIC_FORMULA"], "+magicformula"), files, ("Fx", "Fy", "Mz"))


def _defaults_of_magic_formula() -> dict[str, float]:
    """Return the coefficients that its MF6.1 declares, with their defaults; those without a number are 0."""
    folder = Path(os.environ["TIREFMU_MAGIC_FORMULA"]) / "+magicformula" / "+v61"
    declared = re.findall(
        r"Parameter\w*\('(\w+)'(?:, *([-+.\d][-+.\w]*))?", (folder / "Parameters.m").read_text("utf-8")
    )
    return {name: float(default or 0.0) for name, default in declared}


def numbers_of(path: Path) -> dict[str, float]:
    """Return the numbers of a property file by key, as they are written."""
    found = {}
    for line in text_of(path).splitlines():
        key, equals, rest = line.partition("$")[0].partition("=")
        if equals and not key.startswith(("!", "[")):
            try:
                found[key.strip()] = float(rest)
            except ValueError:
                continue  # a text
    return found


def opentire(path: Path, table: pd.DataFrame) -> Forces:
    """Evaluate with OpenTirePython."""
    reader, state = (_foreign("TIREFMU_OPENTIRE", f"opentire.Core.{name}") for name in ("TIRFile", "tirestate"))
    model = reader.TIRFile().load(str(path))
    columns: dict[str, list[float]] = {"Fx": [], "Fy": [], "Mz": []}
    for row in table.to_dict("records"):
        now = state.TireState()
        names = {"SR": "kappa", "SA": "alpha", "IA": "gamma", "FZ": "Fz", "V": "V"}
        now.update({theirs: float(row[ours]) for theirs, ours in names.items()})
        for name, forces in columns.items():
            now[name.upper()] = getattr(model, f"calculate_{name.lower()}")(now)  # Mz reads Fx and Fy
            forces.append(now[name.upper()])
    return {name: np.array(forces) for name, forces in columns.items()}


def mfpy(path: Path, table: pd.DataFrame) -> Forces:
    """Evaluate with MFPy, with the tangent of the slip angle as in the book."""
    tire = _foreign("TIREFMU_MFPY", "mfpy.preprocess").preprocessing.read_tir(str(path))
    rows = [table[name].to_numpy() for name in ("alpha", "kappa", "gamma", "Fz", "V")]
    found = _foreign("TIREFMU_MFPY", "mfpy.solve").solve(rows, tire, star_correction=True)
    return {"Fx": np.asarray(found.FX), "Fy": np.asarray(found.FY), "Mz": np.asarray(found.MZ)}


def tyredyn(path: Path, table: pd.DataFrame) -> Forces:
    """Evaluate with TyreDyn, and with what it lacks: a name to import, a module, and the factor of no turn slip."""
    vars(sys.modules.setdefault("jedi", ModuleType("jedi")))["settings"] = None
    tire = _foreign("TIREFMU_TYREDYN", "src.initialize_tyre").Tyre(
        str(path.resolve()), validate=False, print_status=False, check_limits=False, use_turn_slip=False
    )
    vars(tire)["zeta_default"] = 1.0
    for module in [module for name, module in sys.modules.items() if name.startswith("src.")]:
        vars(module).setdefault("warnings", warnings)
    names = {"SA": "alpha", "SL": "kappa", "FZ": "Fz", "IA": "gamma", "VX": "V"}
    given = {theirs: table[ours].to_numpy() for theirs, ours in names.items()}
    forces = tire.find_forces(**given)
    return {"Fx": forces[0], "Fy": forces[1], "Mz": tire.find_mz_combined(**given)}


def pacejka_model(path: Path, table: pd.DataFrame) -> Forces:
    """Evaluate with Pacejka-tire-model; mode 121: alpha* = tan(alpha), no limits. It has no moments."""
    source = os.environ["TIREFMU_PACEJKA_MODEL"]
    with tempfile.TemporaryDirectory() as folder:
        shutil.copy(path, f"{folder}/tire.tir")
        where = ["-f", "tire", "-d", f"{folder}/", "-s", f"{folder}/"]
        command = [sys.executable, "-W", "ignore", f"{source}/readTIR.py", *where]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        if done.returncode:
            raise ValueError(done.stderr)
        Path(folder, "tire.tir").unlink()
        model = _foreign("TIREFMU_PACEJKA_MODEL", "MagicFormula").MagicFormula(["tire"], f"{folder}/", 121)
    pressure = model.param_tires["tire"]["INFLPRES"]
    columns: dict[str, list[float]] = {"Fx": [], "Fy": []}
    for row in table.to_dict("records"):
        model.online_params(row["Fz"], pressure, row["gamma"], row["kappa"], row["alpha"], row["V"], "tire")
        for name, forces in columns.items():
            forces.append(np.ravel(np.asarray(getattr(model, f"calculate{name}")(), dtype=object))[0])
    return {name: np.array(forces, dtype=float) for name, forces in columns.items()}


def chrono(path: Path, table: pd.DataFrame) -> Forces:
    """Evaluate with Chrono's ChPac02Tire: CalcFxyMz, in the signs of the file, of a tire on its own side."""
    return _compiled(chrono_program(), path, table)


def pacejka(path: Path, table: pd.DataFrame) -> Forces:
    """Evaluate with evan-el's pacejka."""
    source = Path(os.environ["TIREFMU_PACEJKA"])
    program = _program(HERE / "pacejka_reader.cpp", (source / "pacejka.cpp",), (source,), ())
    return _compiled(program, path, table)


def chrono_program() -> Path:
    """Return the compiled program around ChPac02Tire."""
    source = Path(os.environ["TIREFMU_CHRONO"])
    file = source / "chrono_vehicle" / "wheeled_vehicle" / "tire" / "ChPac02Tire.cpp"
    return _program(HERE / "chrono_reader.cpp", (), (source, file.parent), CHRONO_HEADERS)


@cache
def _program(driver: Path, sources: tuple[Path, ...], folders: tuple[Path, ...], empty: tuple[str, ...]) -> Path:
    """Compile a program into a temporary folder that stays until the end; headers that are left out are empty."""
    folder = Path(tempfile.mkdtemp(prefix="tirefmu-reader-"))
    for header in empty:
        path = folder / "headers" / header
        path.parent.mkdir(parents=True, exist_ok=True)
        path.touch()
    program = folder / driver.stem
    include = [f"-I{path}" for path in (folder / "headers", *folders)]
    command = ["g++", "-std=c++17", "-O1", "-w", *include, str(driver), *map(str, sources), "-o", str(program)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        raise ValueError(done.stderr)
    return program


def _compiled(program: Path, path: Path, table: pd.DataFrame) -> Forces:
    """Return what a compiled reader prints for the rows of its standard input, behind a line of dashes."""
    given = rows_of(table, "kappa", "alpha", "gamma", "Fz", "V")
    done = subprocess.run(
        [str(program), str(path)], input=given, capture_output=True, text=True, timeout=60, check=False
    )
    if done.returncode:
        raise ValueError(done.stderr or f"status {done.returncode}")
    text = done.stdout.rpartition("-----\n")[2]
    names = ("Fx", "Fy", "Mz")
    return columns_of(text, names[: len(text.splitlines()[0].split())])


def _foreign(variable: str, name: str) -> ModuleType:
    """Import a module from the folder that a variable of the environment names."""
    folder = os.environ[variable]
    if folder not in sys.path:
        sys.path.append(folder)
    return import_module(name)


READERS: dict[str, tuple[str, Reader]] = {
    "MFeval": ("TIREFMU_MFEVAL", mfeval),
    "MFeval, CRLF": ("TIREFMU_MFEVAL", mfeval_with_crlf),
    "magic-formula-tyre-library": ("TIREFMU_MAGIC_FORMULA", magic_formula),
    "TyreDyn": ("TIREFMU_TYREDYN", tyredyn),
    "OpenTirePython": ("TIREFMU_OPENTIRE", opentire),
    "MFPy": ("TIREFMU_MFPY", mfpy),
    "Chrono": ("TIREFMU_CHRONO", chrono),
    "Pacejka-tire-model": ("TIREFMU_PACEJKA_MODEL", pacejka_model),
    "pacejka": ("TIREFMU_PACEJKA", pacejka),
}
