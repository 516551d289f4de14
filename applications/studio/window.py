"""What the window can do: one method for each message of the page."""

from __future__ import annotations

import asyncio
import json
import os
import tempfile
from collections.abc import Awaitable, Callable, Mapping, Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any, TypeVar

from ...boundary.errors import TirefmuError, UnknownName
from ...boundary.escaping import excerpt, file_name
from ...diagnosis.diagnose import with_library
from ...diagnosis.probing.candidates import candidates_for
from ...fitting.options import declared_options
from ...fitting.problem.recipe import RECIPES
from ...measurements import Noise, VirtualBench, trento_program, write_table
from ...measurements.catalogue import effects
from ...measurements.files.reading import READERS
from ...symbolic.models import MODELS, model_named
from ...tires import Tire, published, tire_from
from ..explorer.explore import fit_intervals
from ..project.project_file import SECTIONS
from ..project.records import Records, files_of
from ..project.steps import Step, reads_results, steps_of
from ..project.summaries import summary_of
from .data_view import recording_of, rows_expression, series, tables_view
from .fits import PROJECT, RESULT, TIRE, Fits
from .project_state import FOLDER, ProjectState, Stale
from .tire_view import Measured, PageTires, changed_tire, initial_tire
from .work import Work

T = TypeVar("T")
Event = dict[str, Any]
#: Steps that the window runs.
STEPS = ("inspect", "fit", "explore", "export", "convert", "generate", "check", "diagnose")
#: s between two looks at the project file and at the tire of a running fit.
INTERVAL = 0.1
#: File of the example, and its rows per second.
EXAMPLE, EXAMPLE_RATE = "example.csv", 10.0
#: Name of the tire whose fit is running, or will be.
LIVE = "live"


class Window:
    """A project and those who look at it.

    `send`: sends an event to all pages.
    """

    def __init__(self, state: ProjectState, send: Callable[[Event], Awaitable[None]]) -> None:
        self.state, self._send = state, send
        self.fits = Fits(state.folder / FOLDER / "fits")
        self.work = Work(self._worked)
        self.tires = PageTires()
        self._edit = asyncio.Lock()
        self._live: Tire | None = None
        self._measured: tuple[Any, Measured] | None = None
        self._actions = {name.removeprefix("do_"): getattr(self, name) for name in dir(self) if name.startswith("do_")}

    async def answer(self, text: str) -> str:
        """Return the answer to a message: a JSON object with ``do``, the name of an action, and its arguments."""
        number: Any = None
        try:
            try:
                message = json.loads(text)
            except (ValueError, RecursionError):
                raise TirefmuError("a message is no JSON") from None
            if not isinstance(message, dict):
                raise TirefmuError("a message is a JSON object")
            number = message.get("id") if isinstance(message.get("id"), int) else None
            name = given(message, "do", str)
            if name not in self._actions:
                raise UnknownName("action", name, self._actions)
            return json.dumps({"id": number, "result": await self._actions[name](message)}, allow_nan=False)
        except TirefmuError as error:
            return json.dumps({"id": number, "error": excerpt(error), "stale": isinstance(error, Stale)})
        except Exception as error:  # the server goes on, whatever fails
            text = excerpt(f"{type(error).__name__}: {error}")
            return json.dumps({"id": number, "error": f"internal error: {text}"})

    async def watch(self) -> None:
        """Report changes of the project file by other programs, and the stages of a running fit."""
        seen, stage = self._signature(), None
        while True:
            await asyncio.sleep(INTERVAL)
            if (now := self._signature()) != seen:
                seen = now
                await self._send({"event": "changed"})
            if self.work.running and self.work.title.startswith("fit"):
                stage = await self._show_stage(stage)

    async def do_state(self, message: Event) -> Event:
        """Return the state of the project."""
        return await asyncio.to_thread(self._state)

    async def do_choices(self, message: Event) -> Event:
        """Return the models, the options of a fit with choices, and the effects and recipes of the project's model."""
        chosen = self.state.project().get("fit", "model", "mf61")
        available = await asyncio.to_thread(effects, None, chosen)
        model = model_named(chosen)
        return {
            "models": {name: declaration.title for name, declaration in MODELS.items()},
            "effects": [{key: effect[key] for key in ("name", "kind", "physics")} for effect in available],
            "default": sorted(model.default_effects),
            "exports": {name: SECTIONS["export"][name].schema["items"]["enum"] for name in ("convert", "generate")},
            "options": [
                {"name": name, "label": option.label, "choices": list(option.choices.items()), "default": default}
                for name, (option, default) in declared_options().items()
                if option.label
            ],
            "recipes": sorted({*RECIPES, *model.fit.recipes} - {"family"}),
        }

    async def do_set(self, message: Event) -> None:
        """Set a key of the project file; null removes it."""
        version, section, key = (given(message, name, str) for name in ("version", "section", "key"))
        await self._changed(self.state.set_value, version, section, key, message.get("value"))

    async def do_correct(self, message: Event) -> None:
        """Set what the columns of the tables mean: keys of [data]."""
        version, keys = given(message, "version", str), given(message, "keys", dict)
        await self._changed(self.state.set_values, version, "data", keys)

    async def do_tables(self, message: Event) -> None:
        """Set the tables of the project."""
        tables = texts(message, "tables")
        await self._changed(self.state.set_tables, given(message, "version", str), tables)

    async def do_example(self, message: Event) -> None:
        """Write a recording of the virtual bench into the folder of the project and add it to the tables."""
        handle, name = tempfile.mkstemp(dir=self.state.folder / FOLDER, suffix=".csv")
        os.close(handle)
        try:
            await asyncio.to_thread(_write_example, Path(name))
            await self.add_table(EXAMPLE, Path(name))
        finally:
            Path(name).unlink(missing_ok=True)

    async def do_undo(self, message: Event) -> None:
        """Restore the project file before the latest change."""
        await self._changed(self.state.undo, given(message, "version", str))

    async def do_rows(self, message: Event) -> None:
        """Exclude rows of a table, exclude all others, or hold rows out of the fit."""
        how = given(message, "how", str)
        keys = {"exclude": ("data", "exclude"), "keep": ("data", "exclude"), "hold_out": ("fit", "hold_out")}
        if how not in keys:
            raise UnknownName("selection", how, keys)
        first, last = given(message, "first", int), given(message, "last", int)
        path = self._table(message)
        rows = len(await asyncio.to_thread(recording_of, path, self.state.project()))
        if not 1 <= first <= last <= rows:
            raise TirefmuError(f"rows {excerpt(first, 20)} to {excerpt(last, 20)}: {path.name} has rows 1 to {rows}")
        section, key = keys[how]
        inside = rows_expression(path.name, first, last, inside=how != "keep")
        values = [*self.state.project().get(section, key, ()), inside]
        await self._changed(self.state.set_value, given(message, "version", str), section, key, values)

    async def do_data(self, message: Event) -> list[Event]:
        """Return what is shown of the tables."""
        return await asyncio.to_thread(tables_view, self.state.project())

    async def do_series(self, message: Event) -> Event:
        """Return the time history of a channel of a table."""
        path, channel, project = self._table(message), given(message, "channel", str), self.state.project()
        return await asyncio.to_thread(lambda: series(recording_of(path, project), channel, project))

    async def do_measured(self, message: Event) -> Event:
        """Return the measured rows under the curves."""
        measured = await asyncio.to_thread(self._measured_rows)
        return measured.data()

    async def do_tire(self, message: Event) -> Event:
        """Return a tire: "live", "result", or the number of a fit."""
        return await asyncio.to_thread(self._shown_tire, given(message, "tire", str))

    async def do_errors(self, message: Event) -> Event:
        """Return the errors of a tire with values of the page over the measured rows."""
        tire = await self._tire_of_page(message)
        condition = given(message, "condition", int)
        return await asyncio.to_thread(lambda: self._measured_rows().errors(tire, condition))

    async def do_start_from(self, message: Event) -> None:
        """Write a tire with values of the page to the folder, and let the fit start from it."""
        tire = await self._tire_of_page(message)
        name = "start.tir"
        await asyncio.to_thread(tire.save, self.state.folder / name)
        await self._changed(self.state.set_value, given(message, "version", str), "fit", "start", name)

    async def do_run(self, message: Event) -> None:
        """Run steps of the project, and those whose results they read."""
        only = texts(message, "steps")
        for name in only:
            if name not in STEPS:
                raise UnknownName("step", name, STEPS)
        project = self.state.project()
        if not project.tables:
            raise TirefmuError("the project has no table: add one first")
        initial = await asyncio.to_thread(initial_tire, project)
        steps = ["--only", ",".join(only)] if only else []
        self._live_file.unlink(missing_ok=True)  # of an earlier fit
        await self.work.start(", ".join(only) or "all steps", ["run", str(self.state.path), *steps], self._live_file)
        self._live = initial
        await self._send({"event": "started", "title": self.work.title})

    async def do_stop(self, message: Event) -> None:
        """End the running work."""
        await self.work.stop()

    async def do_note(self, message: Event) -> None:
        """Write the note of a fit."""
        number, text = given(message, "fit", int), given(message, "text", str)
        await asyncio.to_thread(self.fits.set_note, number, text)
        await self._send({"event": "changed"})

    async def do_restore(self, message: Event) -> None:
        """Take the fit's section of the project file of an earlier fit."""
        path = self.fits.of(given(message, "fit", int)) / PROJECT
        await self._changed(self.state.restore_section, given(message, "version", str), "fit", path)

    async def do_reject(self, message: Event) -> None:
        """Exclude an effect from the candidates of the diagnosis."""
        effect = given(message, "effect", str)
        tire = await asyncio.to_thread(self._tire, "result")
        candidates = candidates_for(with_library(tire))
        if effect not in candidates:
            raise UnknownName("candidate", effect, candidates)
        tested = self.state.project().get("diagnose", "candidates", sorted(candidates))
        others = [other for other in tested if other != effect]
        await self._changed(self.state.set_value, given(message, "version", str), "diagnose", "candidates", others)

    async def add_table(self, name: str, content: Path) -> str:
        """Move an uploaded file into the folder of the project and add it to the tables; return its name."""
        path = self.state.folder / file_name(name)
        if path.suffix.lower() not in READERS:
            readers = ", ".join(sorted(READERS))
            raise TirefmuError(f"{file_name(name)}: not a kind of recording that is read: {readers}")
        async with self._edit:
            if path.exists():
                raise TirefmuError(f"{path.name} exists already in the folder of the project: rename the file")
            content.replace(path)
            tables = [*self.state.project().get("data", "tables", []), path.name]
            self.state.set_tables(self.state.version(), tables)
        await self._send({"event": "changed"})
        return path.name

    async def _changed(self, change: Callable[..., None], *arguments: Any) -> None:
        async with self._edit:
            await asyncio.to_thread(change, *arguments)
        await self._send({"event": "changed"})

    async def _worked(self, event: Event) -> None:
        if event["event"] == "ended":
            await asyncio.to_thread(self._keep_fit)
        await self._send(event)

    def _keep_fit(self) -> None:
        project = self.state.project()
        fits = [step for step in steps_of(project) if step.command == "fit"]
        if any(Records.of(project.folder).status(step) is not None for step in fits):
            self.fits.keep(project.folder, self.state.text())

    async def _show_stage(self, seen: Any) -> Any:
        try:
            now = self._live_file.stat().st_mtime_ns
        except OSError:
            return seen
        if now != seen:
            self._live = await asyncio.to_thread(_read_tire, self._live_file, now)
            await self._send({"event": "stage"})
        return now

    @property
    def _live_file(self) -> Path:
        """The tire that the running fit has reached."""
        return self.state.folder / FOLDER / "stage.tir"

    def _signature(self) -> Any:
        try:
            status = self.state.path.stat()
            return status.st_mtime_ns, status.st_size
        except OSError:
            return None

    def _state(self) -> Event:
        project = self.state.project()
        steps = steps_of(project) if project.tables else []
        records = Records.of(project.folder)
        return {
            "version": self.state.version(),
            "folder": str(self.state.folder.absolute()),
            "sections": project.sections,
            "undoable": self.state.undoable(),
            "steps": _steps(steps, records, project.folder),
            "fits": self.fits.summaries(),
            "work": {"running": self.work.running, "title": self.work.title, "lines": list(self.work.lines)},
        }

    def _table(self, message: Event) -> Path:
        tables = self.state.project().tables
        number = given(message, "table", int)
        if not 0 <= number < len(tables):
            raise TirefmuError(f"there is no table {excerpt(number, 20)}")
        return tables[number]

    def _tire(self, name: str) -> Tire:
        if name == LIVE:
            self._live = self._live or initial_tire(self.state.project())
            return self._live
        path = self._tire_file(name)
        if not path.is_file():
            raise TirefmuError("there is no fitted tire yet")
        return _read_tire(path, path.stat().st_mtime_ns)

    def _tire_file(self, name: str) -> Path:
        if name == "result":
            return self.state.project().folder / TIRE
        if not name.isdecimal() or len(name) > 9:
            raise TirefmuError(f"there is no tire {excerpt(name, 40)}")
        return self.fits.of(int(name)) / TIRE

    def _shown_tire(self, name: str) -> Event:
        tire, result = self._tire(name), None if name == LIVE else self._tire_file(name).with_name(RESULT)
        return self.tires.of(tire, name, fit_intervals(result, tire) if result and result.is_file() else {})

    def _measured_rows(self) -> Measured:
        project = self.state.project()
        key = self.state.version(), tuple(path.stat().st_mtime_ns for path in project.tables if path.exists())
        if self._measured is None or self._measured[0] != key:
            inputs = model_named(project.get("fit", "model", "mf61")).inputs
            self._measured = key, Measured.of(project, [quantity.name for quantity in inputs])
        return self._measured[1]

    async def _tire_of_page(self, message: Event) -> Tire:
        values = given(message, "values", dict)
        if not all(isinstance(number, (int, float)) and not isinstance(number, bool) for number in values.values()):
            raise TirefmuError("values of coefficients are numbers")
        base = await asyncio.to_thread(self._tire, given(message, "tire", str))
        return changed_tire(given(message, "model", str), texts(message, "effects"), values, base)


@lru_cache(maxsize=64)
def _read_tire(path: Path, changed: int) -> Tire:
    return tire_from(path)


def _steps(steps: Sequence[Step], records: Records, folder: Path) -> list[Event]:
    """Return what is shown of steps; one that reads results of a step that is out of date is out of date."""
    shown, stale = [], list[Step]()
    for step in steps:
        status = None if reads_results(step, stale) else records.status(step)
        stale += [step] if status is None else []
        shown.append(_step(step, status, folder))
    return shown


def _step(step: Step, status: int | None, folder: Path) -> Event:
    """Return what is shown of a step: its outcome if it is up to date."""
    shown: Event = {"name": step.name, "command": step.command, "status": status, "files": []}
    if status is None:
        return shown
    try:
        result = json.loads(step.result.read_text(encoding="utf-8"))
        summary = summary_of(step.command, result, status)
        shown |= {"headline": summary.text, "rating": summary.rating, "summary": list(summary.lines)}
        if step.command == "diagnose":
            shown["found"] = [str(finding["effect"]) for finding in result["found"]]
    except (OSError, ValueError, KeyError, TypeError) as error:
        shown |= {"headline": f"result cannot be read: {excerpt(error)}", "rating": "bad", "summary": []}
    files = [step.page, *step.outputs] if step.page else step.outputs
    named = [path for name in files for path in files_of(name) if path.is_file() and path.is_relative_to(folder)]
    shown["files"] = list(dict.fromkeys(path.relative_to(folder).as_posix() for path in named))
    return shown


def given(message: Mapping[str, Any], name: str, kind: type[T]) -> T:
    """Return an entry of a message. Raises `TirefmuError` if it is missing or of another type."""
    value = message.get(name)
    if not isinstance(value, kind) or (kind is int and isinstance(value, bool)):
        words = {str: "a text", int: "a whole number", dict: "an object", list: "a list"}
        raise TirefmuError(f"{name} of a message is {words[kind]}")
    return value


def texts(message: Mapping[str, Any], name: str) -> Sequence[str]:
    """Return an entry of a message that is a list of texts. Raises `TirefmuError`."""
    value: list[Any] = given(message, name, list)
    if not all(isinstance(item, str) for item in value):
        raise TirefmuError(f"{name} of a message is a list of texts")
    return value


def _write_example(path: Path) -> None:
    """Write a recording of a published tire on the virtual bench."""
    program = trento_program(sample_rate=EXAMPLE_RATE, signs="iso")
    write_table(VirtualBench(published("trento_hoosier"), Noise()).run(program).with_signs("iso").table, path)
