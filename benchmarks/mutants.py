"""Mutation test: single-line faults over all packages, each planted in a copy of the tree.

`mutants.toml` contains for each fault the file, the correct and the wrong line, and the tests nearest to it. First all
these tests run without a fault, because a test that fails then cannot detect one. A fault survives if its tests pass or
if its line is not in its file. The exit code is then 1.
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
#: Exit codes of pytest.
PASSED, FAILED = 0, 1


@dataclass(frozen=True)
class Fault:
    """A line, its replacement with a fault, and the tests that have to detect it.

    - `file`: relative to the root.
    - `old`, `new`: `old` occurs once in the file.
    - `tests`: arguments of pytest.
    """

    file: str
    old: str
    new: str
    tests: tuple[str, ...]

    def __str__(self) -> str:
        return f"{self.file}: {self.old.strip()} -> {self.new.strip()}"


def faults(words: Sequence[str]) -> list[Fault]:
    """Return the faults whose file or line contains one of the words; all faults without words."""
    table = tomllib.loads(Path(__file__).with_suffix(".toml").read_text(encoding="utf-8"))["fault"]
    every = [Fault(row["file"], row["old"], row["new"], tuple(row["tests"])) for row in table]
    return [fault for fault in every if not words or any(word in str(fault) for word in words)]


class Copy:
    """A copy of the tree whose tests import the copy: a link `tirefmu` to the root."""

    def __init__(self, folder: Path) -> None:
        self.root = folder
        listed = ["git", "ls-files", "--cached", "--others", "--exclude-standard", "-z"]
        names = subprocess.run(listed, cwd=ROOT, check=True, capture_output=True, text=True).stdout.split("\0")
        for name in filter(None, names):
            if (ROOT / name).is_file():
                (folder / name).parent.mkdir(parents=True, exist_ok=True)
                shutil.copyfile(ROOT / name, folder / name)
        self._path = folder / "import"
        self._path.mkdir()
        (self._path / "tirefmu").symlink_to(folder, target_is_directory=True)
        (self._path / "missing_effects").symlink_to(folder / "benchmarks" / "missing_effects", target_is_directory=True)
        # Invalidated by content: a fault may be planted and removed within one second, the resolution of time stamps.
        compiled = [sys.executable, "-m", "compileall", "-qq", "--invalidation-mode", "checked-hash", str(folder)]
        subprocess.run(compiled, check=False)

    def test(self, *arguments: str) -> subprocess.CompletedProcess[str]:
        """Run pytest on the copy."""
        environment = {**os.environ, "PYTHONPATH": str(self._path), "PYTHONDONTWRITEBYTECODE": "1"}
        command = [sys.executable, "-m", "pytest", "-x", "-q", "--no-header", "-p", "no:cacheprovider", *arguments]
        return subprocess.run(
            command, cwd=self.root, env=environment, capture_output=True, text=True, check=False, errors="replace"
        )

    def verdict(self, fault: Fault) -> str:
        """Plant a fault, run its tests and remove it. Return "detected", or why it was not."""
        path = self.root / fault.file
        content = path.read_text(encoding="utf-8")
        if content.count(fault.old) != 1:
            return f"SURVIVES: its line occurs {content.count(fault.old)} times in the file"
        path.write_text(content.replace(fault.old, fault.new), encoding="utf-8")
        try:
            done = self.test(*fault.tests)
        finally:
            path.write_text(content, encoding="utf-8")
        if done.returncode == FAILED:
            return "detected"
        return "SURVIVES" if done.returncode == PASSED else f"SURVIVES: no test ran\n{done.stdout}{done.stderr}"


def pass_without_fault(copy: Copy, chosen: Sequence[Fault]) -> bool:
    """Return whether the tests pass without a fault, and print those that fail."""
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
    """Run the chosen faults. Return 1 if one survives."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("words", nargs="*", help="only faults whose file or line contains one of these")
    parser.add_argument("-j", "--jobs", type=int, default=2, help="faults tested in parallel")
    options = parser.parse_args()
    chosen, start = faults(options.words), time.monotonic()
    if not chosen:
        parser.error(f"no fault contains {' or '.join(options.words)} in its file or line")
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
        if not pass_without_fault(first, chosen):
            return 1
        copies.put(first)
        survivors = 0
        with ThreadPoolExecutor(copies.qsize()) as pool:
            for number, (fault, verdict) in enumerate(zip(chosen, pool.map(judged, chosen), strict=True), start=1):
                survivors += verdict != "detected"
                print(f"{number:2}/{len(chosen)} {verdict:8} {fault}", flush=True)
    print(f"{survivors} of {len(chosen)} faults survive ({time.monotonic() - start:.0f} s)")
    return int(survivors > 0)


if __name__ == "__main__":
    sys.exit(main())
