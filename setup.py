"""What pyproject.toml cannot declare: the packages, and printed code."""

import subprocess
import sys
from pathlib import Path

from setuptools import setup
from setuptools.command.build_py import build_py

ROOT = Path(__file__).parent
#: Runs where the packages have been copied to, as they are installed.
PRINT = (
    "import sys, pathlib; from tirefmu.symbolic.printers.generate import write; write(pathlib.Path(sys.argv[1]), True)"
)


def packages() -> list[str]:
    """Return the root and every folder with Python files below it, without the tests."""
    files = [file for room in ROOT.glob("*/__init__.py") if room.parent.name != "tests"
             for file in room.parent.rglob("__init__.py")]  # fmt: skip
    return ["tirefmu", *sorted(".".join(["tirefmu", *file.parent.relative_to(ROOT).parts]) for file in files)]


class BuildWithPrintedCode(build_py):
    """Copies the packages and prints all code into the copy: Jacobians and the models with the library of effects.

    A clone, and an editable install of it, print them at their first use instead.
    """

    def find_package_modules(self, package: str, package_dir: str) -> list[tuple[str, str, str]]:
        """Return the modules of a package: of the root only those that are imported."""
        modules = super().find_package_modules(package, package_dir)
        return [module for module in modules if package != "tirefmu" or module[1] in ("__init__", "__main__")]

    def run(self) -> None:
        """Copy, then print, without bytecode, which would be in the wheel."""
        super().run()
        if not self.editable_mode:
            tree = Path(self.build_lib).resolve()
            subprocess.run([sys.executable, "-B", "-c", PRINT, tree / "tirefmu" / "generated"], cwd=tree, check=True)


setup(packages=packages(), cmdclass={"build_py": BuildWithPrintedCode})
