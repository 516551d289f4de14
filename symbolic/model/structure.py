"""The structure of the lines of a model: their coefficients, options and effects, and the names that each line reads.

It is stored with the generated code, so SymPy is not needed to read, evaluate, fit and export a tire. The lines
themselves are loaded to print code, to add effects and to show equations.
"""

from __future__ import annotations

import json
from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import asdict, dataclass
from functools import cached_property
from importlib.resources.abc import Traversable
from itertools import compress, product

from ...boundary.errors import ModelError


@dataclass(frozen=True)
class LineCase:
    """The content of a line under certain conditions: a number, as text, or '' and the names that it reads."""

    number: str
    reads: tuple[str, ...]


@dataclass(frozen=True)
class Line:
    """The names that a line reads, depending on its effects and on the earlier lines that may be numbers.

    - `earlier`: by earlier line, the numbers that it may be, as text; '' for an expression.
    - `cases`: one for each of `conditions`.
    """

    name: str
    effects: tuple[str, ...]
    earlier: Mapping[str, tuple[str, ...]]
    cases: tuple[LineCase, ...] = ()

    def conditions(self) -> Iterator[tuple[tuple[str, ...], tuple[str, ...]]]:
        """Yield for each case the effects of the line that are on, and the numbers that the earlier lines are."""
        for switched_on in product((False, True), repeat=len(self.effects)):
            yield from product([tuple(compress(self.effects, switched_on))], product(*self.earlier.values()))

    @cached_property
    def _by_condition(self) -> dict[tuple[frozenset[str], tuple[str, ...]], LineCase]:
        pairs = zip(self.conditions(), self.cases, strict=True)
        return {(frozenset(present), numbers): case for (present, numbers), case in pairs}

    def case(self, present: Collection[str], numbers: Mapping[str, str]) -> LineCase:
        """Return the content of the line with these effects and earlier lines that are numbers."""
        key = (frozenset(present).intersection(self.effects), tuple(numbers.get(name, "") for name in self.earlier))
        return self._by_condition[key]


@dataclass(frozen=True)
class Structure:
    """What the lines of a model determine.

    - `coefficients`: those that a line reads, in the order of the parameter vector.
    - `options`, `plain_options`: the options that a line reads; those that act in rows without an effect on demand,
      except the signs.
    - `effects`: in the order in which the lines have them.
    - `relaxing_effects`: the effects in the lines of the relaxation lengths.
    - `upright`: the lines that repeat another one without inclination.
    - `quantities`: unit and description of each named quantity.
    - `plain`: what each output reads in rows without an effect on demand, under default options.

    >>> from tirefmu.symbolic.models import model_named
    >>> structure = model_named("mf96").structure
    >>> structure.quantities["mu_y"]
    ('1', 'peak friction')
    >>> sorted(structure.reached(["mu_y"], ["load_friction"]) & set(structure.coefficients))
    ['FNOMIN', 'LFZ0', 'LMUY', 'PDY1', 'PDY2']
    """

    coefficients: tuple[str, ...]
    options: tuple[str, ...]
    plain_options: tuple[str, ...]
    effects: tuple[str, ...]
    relaxing_effects: tuple[str, ...]
    upright: tuple[str, ...]
    quantities: Mapping[str, tuple[str, str]]
    plain: Mapping[str, tuple[str, ...]]
    lines: tuple[Line, ...]

    def reached(self, targets: Iterable[str], effects: Collection[str]) -> frozenset[str]:
        """Return the names on which lines depend with these effects: inputs, coefficients, options, earlier lines."""
        numbers: dict[str, str] = {}
        reads: dict[str, tuple[str, ...]] = {}
        for line in self.lines:
            case = line.case(effects, numbers)
            reads[line.name] = case.reads
            if case.number:
                numbers[line.name] = case.number
        needed = set(targets)
        reached: set[str] = set()
        for line in reversed(self.lines):
            if line.name in needed:
                needed.update(reads[line.name])
                reached.update(reads[line.name])
        return frozenset(reached)

    def to_text(self, about: str) -> str:
        """Return the text of the stored file: JSON, with one line of text for each line of the model.

        `from_text` is the inverse, without the remark about the file.
        """
        content = {"about": about, **asdict(self)}
        del content["lines"]
        lines = [
            [line.name, line.effects, line.earlier, [case.number or case.reads for case in line.cases]]
            for line in self.lines
        ]
        fields = [f"{json.dumps(key)}: {json.dumps(value)}" for key, value in content.items()]
        rows = ",\n  ".join(json.dumps(line) for line in lines)
        return "{\n" + ",\n".join([*fields, f'"lines": [\n  {rows}\n]']) + "\n}\n"

    @classmethod
    def from_text(cls, text: str) -> Structure:
        """Return the structure of a stored text."""
        content = json.loads(text)
        del content["about"]
        lines = tuple(
            Line(name, tuple(effects), {line: tuple(numbers) for line, numbers in earlier.items()},
                 tuple(LineCase(case, ()) if isinstance(case, str) else LineCase("", tuple(case)) for case in cases))
            for name, effects, earlier, cases in content.pop("lines")
        )  # fmt: skip
        quantities = {name: (unit, description) for name, (unit, description) in content.pop("quantities").items()}
        plain = {name: tuple(reads) for name, reads in content.pop("plain").items()}
        names = {key: tuple(value) for key, value in content.items()}
        return cls(**names, quantities=quantities, plain=plain, lines=lines)


def stored_structure(file: Traversable, declared: Collection[str]) -> Structure:
    """Return the structure in a file.

    `declared`: coefficients that the model declares. Raises `ModelError` if it does not fit the declarations.
    """
    try:
        structure = Structure.from_text(file.read_text(encoding="ascii"))
    except (AttributeError, KeyError, TypeError, ValueError):
        raise ModelError(f'{file} is stale: run "tirefmu generate"') from None
    if unknown := set(structure.coefficients).difference(declared):
        raise ModelError(f'{file} is stale, it has {min(unknown)}: run "tirefmu generate"')
    return structure
