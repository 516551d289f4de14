"""What pyproject.toml cannot declare: the sub-folders of each root folder that have Python files, and printed code."""

import subprocess
import sys
import tomllib
from pathlib import Path

from setuptools import setup
from setuptools.command.build_py import build_py

ROOT = Path(__file__).parent
PACKAGES = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["setuptools"]["package-dir"]
#: Runs where the packages have been copied to, as they are installed.
PRINT = (
    "import sys, pathlib; from tirefmu.symbolic.printers.generate import write; write(pathlib.Path(sys.argv[1]), True)"
)


class BuildWithPrintedCode(build_py):
    """Copies the packages and prints all code into the copy: Jacobians and the models with the library of effects.

    A clone, and an editable install of it, print them at their first use instead.
    """

    def run(self) -> None:
        """Copy, then print."""
        super().run()
        if not self.editable_mode:
            tree = Path(self.build_lib).resolve()
            subprocess.run([sys.executable, "-c", PRINT, tree / "tirefmu" / "generated"], cwd=tree, check=True)


setup(
    packages=sorted(
        ".".join([package, *file.parent.relative_to(ROOT / folder).parts])
        for package, folder in PACKAGES.items()
        for file in (ROOT / folder).rglob("__init__.py")
    ),
    cmdclass={"build_py": BuildWithPrintedCode},
)
