"""The test suite with the instruction sets of other processors in BLAS, NumPy and the compiled kernels.

Sums and elementary functions then differ in their last digits, as they do between machines: no test may notice.
Arguments are those of pytest.
"""

from __future__ import annotations

import os
import platform
import subprocess
import sys

import numpy as np


def settings() -> dict[str, dict[str, str]]:
    """Return environment variables by the processor that they imitate."""
    found = np.show_config(mode="dicts")["SIMD Extensions"].get("found", [])
    if platform.machine() not in ("x86_64", "AMD64"):
        return {"without vector instructions in NumPy": {"NPY_DISABLE_CPU_FEATURES": " ".join(found)}}
    wide = [name for name in found if name.startswith(("AVX512", "X86_V4"))]
    result = {"SSE3": ("Prescott", found, "x86-64")}
    if len(wide) < len(found):  # it has AVX2
        result["AVX2"] = "Haswell", wide, "x86-64-v3"
    return {
        name: {"OPENBLAS_CORETYPE": core, "NPY_DISABLE_CPU_FEATURES": " ".join(disabled), "TIREFMU_MACHINE": kernels}
        for name, (core, disabled, kernels) in result.items()
    }


def main() -> int:
    """Run the suite with each setting. Return 1 if a test fails with one."""
    failed = []
    for name, variables in settings().items():
        print(f"{name}: {' '.join(f'{key}={value!r}' for key, value in variables.items())}", flush=True)
        command = [sys.executable, "-m", "pytest", "-q", *sys.argv[1:]]
        if subprocess.run(command, env={**os.environ, **variables}, check=False).returncode:
            failed.append(name)
    print(f"fails with {', '.join(failed)}" if failed else "passes with each")
    return int(bool(failed))


if __name__ == "__main__":
    sys.exit(main())
