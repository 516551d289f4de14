"""Summary of the number of fuzzed files of each kind, printed if only the fuzz tests are run."""

from __future__ import annotations

from collections import defaultdict


def pytest_terminal_summary(terminalreporter):
    counts = defaultdict(lambda: [0, 0])
    for report in terminalreporter.getreports("passed"):
        for name, value in report.user_properties:
            if name == "fuzz" and report.when == "call":
                kind, files, read = value
                counts[kind][0] += files
                counts[kind][1] += read
    if counts:
        terminalreporter.section("fuzzed files")
        for kind, (files, read) in counts.items():
            terminalreporter.write_line(f"{kind:<12}{files:>7} files: {read:>6} read, {files - read:>6} refused")
        total = sum(files for files, _ in counts.values())
        terminalreporter.write_line(f"{'all':<12}{total:>7} files")
