"""The JAX and PyTorch printouts of MF6.1 on an accelerator: agreement with NumPy, points per second, memory a point.

    python benchmarks/gpu.py --prepare build/gpu        # prints the code and the reference: needs tirefmu
    python benchmarks/gpu.py --folder build/gpu         # measures: needs NumPy, and JAX or PyTorch
    python benchmarks/gpu.py [--points 10000000]        # both

Each library computes forces, and the gradient of Fy by all inputs, in double and in single precision. CasADi's C code,
compiled here and run on one core, is the measure beside them. Parts that begin after `--limit` seconds, and libraries
that are not installed, are named as not run. The table and the device are printed; `--json FILE` writes them.
"""

from __future__ import annotations

import argparse
import ctypes
import importlib.util
import json
import os
import platform
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

LIBRARIES = ("casadi C", "jax", "torch")
KINDS = ("forces", "gradient")
#: Rows of the reference.
ROWS = 2000
#: Calls the function that CasADi printed for each row of a table.
LOOP = """
void every_point(const double *inputs, double *forces_of_all, long n, int n_inputs, int n_forces)
{
    static casadi_int iw[64];
    static double w[65536];
    for (long i = 0; i < n; i++) {
        const double *argument[8] = {inputs + i * n_inputs};
        double *result[8] = {forces_of_all + i * n_forces};
        forces(argument, result, iw, w, 0);
    }
}
"""


def prepare(folder: Path) -> None:
    """Write the printouts, CasADi's C code, and rows with forces and derivatives by NumPy."""
    import casadi

    from tirefmu.applications.exports.printout import generate
    from tirefmu.tires import Tire
    from tirefmu.tires.code import code_for

    folder.mkdir(parents=True, exist_ok=True)
    for language in ("jax", "torch", "casadi"):
        generate("mf61", language, folder / language, functions=["forces"], values="inline", rows=1)
    module = _module(folder / "casadi" / "mf61.py")
    generator = casadi.CodeGenerator("forces.c")
    generator.add(module.function("forces"))
    (folder / "forces.c").write_text(generator.dump() + LOOP)
    tire = Tire("mf61", {"FNOMIN": 4000.0, "UNLOADED_RADIUS": 0.3})
    code, rows = code_for(tire.symbolic_model, "numpy"), points(ROWS, module.NOMINAL)
    forces = code.forces(rows.T, tire.parameters()).T
    by_inputs = code.jacobian_inputs(rows.T, tire.parameters())
    np.savez(folder / "reference.npz", rows=rows, forces=forces, by_inputs=by_inputs, outputs=tire.outputs)


def points(n: int, nominal: dict[str, float], seed: int = 0) -> np.ndarray:
    """Return random operating conditions, shape (n, n_inputs)."""
    rng = np.random.default_rng(seed)
    table = np.repeat([list(nominal.values())], n, axis=0)
    limits = {"kappa": (-0.3, 0.3), "alpha": (-0.3, 0.3), "gamma": (-0.1, 0.1), "Fz": (200.0, 9000.0), "V": (5.0, 50.0)}
    for name, (low, high) in limits.items():
        table[:, list(nominal).index(name)] = rng.uniform(low, high, n)
    return table


def _module(path: Path) -> Any:
    spec = importlib.util.spec_from_file_location(f"printed_{path.parent.name}", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


class Casadi:
    """CasADi's C code on one core."""

    def __init__(self, folder: Path) -> None:
        compiler = next(filter(None, map(shutil.which, (os.environ.get("CC", "cc"), "gcc", "clang"))), None)
        if compiler is None:
            raise ImportError("no C compiler")
        library = folder / "forces.so"
        subprocess.run([compiler, "-O3", "-shared", "-fPIC", str(folder / "forces.c"), "-o", str(library), "-lm"],
                       check=True)  # fmt: skip
        self.shared, self.device = ctypes.CDLL(str(library)), f"{platform.processor() or platform.machine()}, one core"

    def function(self, kind: str, number: type) -> Callable[[np.ndarray], Any] | None:
        """Return a function of placed rows; None for what it does not compute."""
        return self._forces if kind == "forces" and number is np.float64 else None

    def _forces(self, rows: np.ndarray) -> np.ndarray:
        forces = np.empty((len(rows), 5))
        given, found = (array.ctypes.data_as(ctypes.c_void_p) for array in (rows, forces))
        self.shared.every_point(given, found, ctypes.c_long(len(rows)), rows.shape[1], 5)
        return forces

    def placed(self, rows: np.ndarray, number: type) -> np.ndarray:
        """Return rows where the functions read them."""
        return np.ascontiguousarray(rows, dtype=number)

    def memory(self) -> None:
        """Not measured."""


class Jax:
    """The JAX printout, compiled by XLA."""

    def __init__(self, folder: Path) -> None:
        os.environ.setdefault("XLA_PYTHON_CLIENT_PREALLOCATE", "false")
        import jax

        jax.config.update("jax_enable_x64", True)
        self.jax, self.printed = jax, _module(folder / "jax" / "mf61.py")
        self.device = str(jax.devices()[0].device_kind)

    def placed(self, rows: np.ndarray, number: type) -> Any:
        """Return rows on the device."""
        return self.jax.numpy.asarray(rows, dtype=number)

    def function(self, kind: str, number: type) -> Callable[[Any], Any]:
        """Return a compiled function of placed rows that waits for its result."""

        def forces(rows: Any) -> Any:
            columns = {name: rows[:, i] for i, name in enumerate(self.printed.INPUTS)}
            return self.printed.forces(**columns)

        def all_forces(rows: Any) -> Any:
            return self.jax.numpy.stack(list(forces(rows).values()), axis=1)

        compiled = self.jax.jit(all_forces if kind == "forces" else self.jax.grad(lambda x: forces(x)["Fy"].sum()))
        return lambda rows: compiled(rows).block_until_ready()

    def memory(self) -> float | None:
        """Return the largest memory of the device so far, bytes; None if the device does not report it."""
        statistics = self.jax.devices()[0].memory_stats()
        return float(statistics["peak_bytes_in_use"]) if statistics else None


class Torch:
    """The PyTorch printout, operation by operation."""

    def __init__(self, folder: Path) -> None:
        import torch

        self.torch, self.printed = torch, _module(folder / "torch" / "mf61.py")
        self.on_gpu = torch.cuda.is_available()
        self.device = torch.cuda.get_device_name(0) if self.on_gpu else "CPU"
        self.where = "cuda" if self.on_gpu else "cpu"
        torch.set_default_device(self.where)

    def placed(self, rows: np.ndarray, number: type) -> Any:
        """Return rows on the device."""
        return self.torch.tensor(rows, dtype=getattr(self.torch, np.dtype(number).name), device=self.where)

    def function(self, kind: str, number: type) -> Callable[[Any], Any]:
        """Return a function of placed rows that waits for its result."""
        torch = self.torch

        def call(rows: Any) -> Any:
            given = rows.detach().requires_grad_(kind == "gradient")
            forces = self.printed.forces(**{name: given[:, i] for i, name in enumerate(self.printed.INPUTS)})
            if kind == "gradient":
                (result,) = torch.autograd.grad(forces["Fy"].sum(), given)
            else:
                result = torch.stack(list(forces.values()), dim=1)
            if self.on_gpu:
                torch.cuda.synchronize()
            return result.detach()

        return call

    def memory(self) -> float | None:
        """Return the largest memory since the last call, bytes; None on a CPU."""
        if not self.on_gpu:
            return None
        largest = float(self.torch.cuda.max_memory_allocated())
        self.torch.cuda.reset_peak_memory_stats()
        return largest


MEASURED = dict(zip(LIBRARIES, (Casadi, Jax, Torch), strict=True))


def measure(folder: Path, n: int, chunk: int, libraries: list[str], limit: float) -> Iterator[dict[str, Any]]:
    """Yield a result for each library, kind of result and number."""
    began = time.monotonic()
    stored = np.load(folder / "reference.npz")
    for name in libraries:
        try:
            library = MEASURED[name](folder)
        except ImportError as error:
            yield {"library": name, "not run": str(error)}
            continue
        for kind in KINDS:
            for number in (np.float64, np.float32):
                row = {"library": name, "device": library.device, "kind": kind, "type": np.dtype(number).name}
                function = library.function(kind, number)
                if function is None:
                    continue
                if time.monotonic() - began > limit:
                    yield row | {"not run": f"after {limit:g} s"}
                    continue
                yield row | _measured(library, function, kind, number, stored, n, chunk)


def _measured(
    library: Any, function: Callable[[Any], Any], kind: str, number: type, stored: Any, n: int, chunk: int
) -> dict[str, Any]:
    """Return agreement with NumPy, points per second, and memory a point."""

    def on_cpu(result: Any) -> np.ndarray:
        return np.asarray(result.cpu() if hasattr(result, "cpu") else result, dtype=float)

    side = list(stored["outputs"]).index("Fy")
    expected = stored["forces"] if kind == "forces" else stored["by_inputs"][:, side]
    found = on_cpu(function(library.placed(stored["rows"], number)))
    size = np.abs(expected).max(axis=0)
    difference = np.abs(found - expected) / np.where(size > 0, size, 1.0)
    table = library.placed(np.resize(stored["rows"], (chunk, stored["rows"].shape[1])), number)
    function(table)  # compiled for this size
    library.memory()
    began = time.perf_counter()
    for _ in range(max(1, n // chunk)):
        function(table)
    seconds = time.perf_counter() - began
    memory = library.memory()
    return {
        "largest difference": float(difference.max()),
        "finite": bool(np.isfinite(found).all()),
        "points per second": max(1, n // chunk) * chunk / seconds,
        "bytes a point": None if memory is None else memory / chunk,
    }


def main(arguments: list[str] | None = None) -> int:
    """Print a table; 1 if a result is not finite."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--prepare", type=Path, metavar="FOLDER", help="only print the code into a folder")
    parser.add_argument("--folder", type=Path, help="measure the code in a prepared folder")
    parser.add_argument("--points", type=int, default=10_000_000)
    parser.add_argument("--chunk", type=int, default=1_000_000, help="points at a time")
    parser.add_argument("--libraries", default=",".join(LIBRARIES))
    parser.add_argument("--limit", type=float, default=330.0, help="seconds after which no part begins")
    parser.add_argument("--json", type=Path)
    given = parser.parse_args(arguments)
    if given.prepare:
        prepare(given.prepare)
        return 0
    with tempfile.TemporaryDirectory() as scratch:
        folder = given.folder or Path(scratch)
        if not given.folder:
            prepare(folder)
        results = []
        for result in measure(folder, given.points, given.chunk, given.libraries.split(","), given.limit):
            results.append(result)
            print(*(f"{key}: {value:.3g}" if isinstance(value, float) else f"{key}: {value}"
                    for key, value in result.items()), sep=", ", flush=True)  # fmt: skip
    if given.json:
        given.json.write_text(json.dumps(results, indent=1) + "\n")
    return int(not all(result.get("finite", True) for result in results))


if __name__ == "__main__":
    sys.exit(main())
