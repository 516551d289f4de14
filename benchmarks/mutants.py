"""Do the tests notice a fault? Single-line faults over all packages, each planted in a copy of the tree.

`mutants.toml` names for each fault the file, the line as it is and as it would be wrong, and the tests nearest to it.
First all those tests run on the copy as it is: what fails then says nothing of a fault. A fault that its tests pass has
survived, and so has one whose line is no longer in its file: the command then ends with 1.
"""

from __future__ import annotations

import argparse
import os
import shutil
import subprocess
import sys
import tempfile
import time
import tomllib
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from queue import SimpleQueue

ROOT = Path(__file__).parents[1]
#: What pytest ends with.
PASSED, FAILED = 0, 1


@dataclass(frozen=True)
class Fault:
    """A line, what it would be with a fault in it, and the tests that have to notice.

    Attributes
    ----------
    file : str
        Relative to the root.
    old, new : str
        `old` stands in the file once.
    tests : tuple of str
        Arguments of pytest.
    """

    file: str
    old: str
    new: str
    tests: tuple[str, ...]

    def __str__(self) -> str:
        return f"{self.file}: {self.old.strip()} -> {self.new.strip()}"


def faults(words: Sequence[str]) -> list[Fault]:
    """Return the faults whose file or line has one of the words; all where there is none."""
    table = tomllib.loads(Path(__file__).with_suffix(".toml").read_text(encoding="utf-8"))["fault"]
    every = [Fault(one["file"], one["old"], one["new"], tuple(one["tests"])) for one in table]
    return [fault for fault in every if not words or any(word in str(fault) for word in words)]


class Copy:
    """A copy of the tree in which tests import the copy: `tirefmu/` beside links to the root folders."""

    def __init__(self, folder: Path) -> None:
        self.root = folder
        listed = ["git", "ls-files", "--cached", "--others", "--exclude-standard", "-z"]
        names = subprocess.run(listed, cwd=ROOT, check=True, capture_output=True, text=True).stdout.split("\0")
        for name in filter(None, names):
            if (ROOT / name).is_file():
                (folder / name).parent.mkdir(parents=True, exist_ok=True)
                shutil.copyfile(ROOT / name, folder / name)
        packages = tomllib.loads((folder / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["setuptools"]
        self._path = folder / "import"
        for package, source in packages["package-dir"].items():
            place = self._path.joinpath(*package.split("."))
            if "." in package:
                place.symlink_to(folder / source, target_is_directory=True)
            else:
                shutil.move(folder / source, place)
                (folder / source).symlink_to(place, target_is_directory=True)
        # By content, as a fault may be planted within the second in which its file was written, and be no longer.
        compiled = [sys.executable, "-m", "compileall", "-qq", "--invalidation-mode", "checked-hash", str(self._path)]
        subprocess.run(compiled, check=False)

    def test(self, *arguments: str) -> subprocess.CompletedProcess[str]:
        """Run pytest on the copy."""
        environment = {**os.environ, "PYTHONPATH": str(self._path), "PYTHONDONTWRITEBYTECODE": "1"}
        command = [sys.executable, "-m", "pytest", "-x", "-q", "--no-header", "-p", "no:cacheprovider", *arguments]
        return subprocess.run(
            command, cwd=self.root, env=environment, capture_output=True, text=True, check=False, errors="replace"
        )

    def verdict(self, fault: Fault) -> str:
        """Plant a fault, run its tests, take it out again; return "noticed", or why it was not."""
        path = self.root / fault.file
        content = path.read_text(encoding="utf-8")
        if content.count(fault.old) != 1:
            return f"SURVIVES: its line is {content.count(fault.old)} times in the file"
        path.write_text(content.replace(fault.old, fault.new), encoding="utf-8")
        try:
            done = self.test(*fault.tests)
        finally:
            path.write_text(content, encoding="utf-8")
        if done.returncode == FAILED:
            return "noticed"
        return "SURVIVES" if done.returncode == PASSED else f"SURVIVES: no test ran\n{done.stdout}{done.stderr}"


def sound(copy: Copy, chosen: Sequence[Fault]) -> bool:
    """Return whether the tests pass where there is no fault, and show those that do not."""
    selections = sorted({fault.tests for fault in chosen})
    whole = {arguments[0] for arguments in selections if len(arguments) == 1}
    once = [name for name in sorted(whole) if name.split("::")[0] not in whole - {name}]
    runs = [tuple(once)] if once else []
    runs += [arguments for arguments in selections if len(arguments) > 1]
    for arguments in runs:
        done = copy.test(*arguments)
        if done.returncode != PASSED:
            print(f"{done.stdout}{done.stderr}\nthe tests fail without a fault: {' '.join(arguments)}")
            return False
    return True


def main() -> int:
    """Return 1 where a fault survives."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("words", nargs="*", help="only faults whose file or line has one of these")
    parser.add_argument("-j", "--jobs", type=int, default=2, help="faults tested at a time")
    options = parser.parse_args()
    chosen, began = faults(options.words), time.monotonic()
    if not chosen:
        parser.error(f"no fault has {' or '.join(options.words)} in its file or line")
    with tempfile.TemporaryDirectory() as folder:
        copies: SimpleQueue[Copy] = SimpleQueue()
        for number in range(min(options.jobs, len(chosen))):
            copies.put(Copy(Path(folder) / str(number)))

        def judged(fault: Fault) -> str:
            copy = copies.get()
            try:
                return copy.verdict(fault)
            finally:
                copies.put(copy)

        first = copies.get()
        print(f"the tests of {len(chosen)} faults without a fault", flush=True)
        if not sound(first, chosen):
            return 1
        copies.put(first)
        survivors = 0
        with ThreadPoolExecutor(copies.qsize()) as pool:
            for number, (fault, verdict) in enumerate(zip(chosen, pool.map(judged, chosen), strict=True), start=1):
                survivors += verdict != "noticed"
                print(f"{number:2}/{len(chosen)} {verdict:8} {fault}", flush=True)
    print(f"{survivors} of {len(chosen)} faults survive ({time.monotonic() - began:.0f} s)")
    return int(survivors > 0)


if __name__ == "__main__":
    sys.exit(main())
