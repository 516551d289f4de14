"""The steps of a project: command lines with the files that they read and write."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from ...boundary.escaping import file_name
from .project_file import Project


@dataclass(frozen=True)
class Step:
    """A command line of a project.

    - `name`: unique in the project.
    - `arguments`: after the name of the command.
    - `inputs`: files that the result depends on.
    - `outputs`: files and folders that it writes.
    - `result`: its JSON result, one of the outputs.
    - `page`: what a reader opens first, one of the outputs or in one of them.
    - `time_limit`: seconds after which the command is ended.
    """

    name: str
    command: str
    arguments: tuple[str, ...]
    inputs: tuple[Path, ...]
    outputs: tuple[Path, ...]
    result: Path
    page: Path | None = None
    time_limit: float | None = None


def steps_of(project: Project) -> list[Step]:
    """Return the steps of a project in their order."""
    folder, tables, data = project.folder, project.tables, project.data_options()
    given = (*tables, *project.files_of("data"))
    tire, fmu, fitted = folder / "tire.tir", folder / "tire.fmu", folder / "fit.json"
    inspection, report, explorer = folder / "inspect.html", folder / "fit.html", folder / "explorer.html"
    fit_options = [
        *project.data_options(fitted=True),
        *project.options("fit"),
        "-o",
        str(tire),
        "--report",
        str(report),
    ]
    explore_options = [*data, "--fit", str(fitted), "-o", str(explorer)]
    steps = [
        _step(folder, "inspect", [*data, "-o", str(inspection)], tables, given, inspection),
        _step(folder, "fit", fit_options, tables, (*given, *project.files_of("fit")), report, tire),
        _step(folder, "explore", explore_options, (tire, *tables), (tire, fitted, *given), explorer),
        _export(project, tire, fmu, fitted, given),
        *_for_programs(project, folder, tire),
    ]
    for table, label in zip(tables, labels(tables), strict=True):
        page = folder / f"check_{label}.html"
        options = [*data, *project.options("check"), "--report", str(page)]
        steps.append(_step(folder, "check", options, (fmu, table), (fmu, *given), page, label=label))
    for table, label in zip(project.diagnosed, labels(project.diagnosed), strict=True):
        answer = folder / f"diagnosis_{label}"
        limit = ["--time-limit", f"{project.time_limit:g}"]
        options = [*data, *project.options("diagnose"), *limit, "--tire", str(tire), "-o", str(answer)]
        inputs = (tire, table, *project.files_of("data"))
        step = _step(folder, "diagnose", options, (table,), inputs, answer / "report.html", answer, label=label)
        steps.append(replace(step, time_limit=project.time_limit))
    return steps


def needed(steps: Sequence[Step], commands: Collection[str]) -> list[Step]:
    """Return the steps of some commands, and those whose results they read."""
    chosen = {step.name for step in steps if step.command in commands}
    for step in reversed(steps):  # a step reads results of earlier ones
        if step.name in chosen:
            chosen |= {other.name for other in steps if reads_results(step, [other])}
    return [step for step in steps if step.name in chosen]


def reads_results(step: Step, others: Iterable[Step]) -> bool:
    """Return whether a step reads results of other steps."""
    return any({*other.outputs} & {*step.inputs} for other in others)


def _export(project: Project, tire: Path, fmu: Path, fitted: Path, given: tuple[Path, ...]) -> Step:
    """Return the step that exports; a native FMU with slip inputs has a proof over the first table by default."""
    options = project.options("export")
    has_reference = (
        project.get("export", "kind", "native") == "native" and project.get("export", "inputs", "slip") == "slip"
    )
    table = project.get("export", "proof")
    if table is None and has_reference:
        options += ["--proof", str(project.tables[0])]
    inputs: tuple[Path, ...] = (tire,)
    if "--proof" in options and table != "none":
        options += ["--fit", str(fitted), *project.data_options()]
        inputs = (tire, fitted, *given, *project.files_of("export"))
    return _step(fmu.parent, "export", [*options, "-o", str(fmu)], (tire,), inputs, None, fmu)


def _for_programs(project: Project, folder: Path, tire: Path) -> Iterator[Step]:
    """Yield the steps that write property files and code."""
    for host in dict.fromkeys(project.get("export", "convert", ())):
        file = folder / f"tire_{host}.tir"
        yield _step(folder, "convert", ["--for", host, "-o", str(file)], (tire,), (tire,), None, file, label=host)
    for language in dict.fromkeys(project.get("export", "generate", ())):
        label = file_name(language)
        code, options = folder / f"code_{label}", ["--language", language]
        yield _step(folder, "generate", [*options, "-o", str(code)], (tire,), (tire,), None, code, label=label)


def _step(
    folder: Path, command: str, options: list[str], operands: tuple[Path, ...], inputs: tuple[Path, ...],
    page: Path | None, *outputs: Path, label: str = "",
) -> Step:  # fmt: skip
    """Return a step that also writes its JSON result; a page that is not in an output is an output."""
    name = f"{command} {label}".strip()
    result = folder / f"{name.replace(' ', '_')}.json"
    inside = page is None or page.parent in outputs
    written = (result, *outputs) if inside else (result, page, *outputs)
    arguments = (*options, "--json", str(result), "--", *map(str, operands))
    return Step(name, command, arguments, inputs, tuple(path for path in written if path), result, page)


def labels(tables: tuple[Path, ...]) -> list[str]:
    """Return a short name for each table, part of file names; numbered where two tables have the same.

    >>> labels((Path("a/run 1.csv"), Path("c.mat"))), labels((Path("a/run.csv"), Path("b/run.csv")))
    (['run_1', 'c'], ['1_run', '2_run'])
    """
    names = [file_name(table.stem) for table in tables]
    return names if len(set(names)) == len(names) else [f"{i}_{name}" for i, name in enumerate(names, 1)]
