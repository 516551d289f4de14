"""The result of each command in a few lines, for the terminal and the page of a project."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from tirefmu.tires.drawing.labels import drawn_unit


@dataclass(frozen=True)
class Headline:
    """The result of a command in one line.

    - `rating`, one of "good", "limited", "bad".
    """

    text: str
    rating: str


def headline_of(command: str, result: Mapping[str, Any], status: int) -> Headline:
    """Return what matters most in the JSON result of a command.

    `status`: the command's exit code.

    >>> headline_of("fit", {"verdict": "usable with limits", "reasons": ["combined slip"]}, 0)
    Headline(text='tire usable with limits', rating='limited')
    """
    text, limited = _HEADLINES[command](result)
    return Headline(text, "bad" if status else "limited" if limited else "good")


def _inspect_headline(result: Mapping[str, Any]) -> tuple[str, bool]:
    serious = any(each["serious"] for each in result["findings"])
    return "data would mislead a fit" if serious else "data ready for a fit", bool(result["findings"])


def _fit_headline(result: Mapping[str, Any]) -> tuple[str, bool]:
    return f"tire {result['verdict']}", bool(result["reasons"])


def _check_headline(result: Mapping[str, Any]) -> tuple[str, bool]:
    return "FMU check passed" if result["ok"] else "FMU check failed", False


def _diagnose_headline(result: Mapping[str, Any]) -> tuple[str, bool]:
    found = ", ".join(each["effect"] for each in result["found"])
    adequate = all(each["adequate"] for each in result["adequacy"].values())
    return (f"missing effect: {found}", True) if found else ("no missing effect identified", not adequate)


_HEADLINES: dict[str, Callable[[Mapping[str, Any]], tuple[str, bool]]] = {
    "inspect": _inspect_headline,
    "fit": _fit_headline,
    "explore": lambda result: ("page with sliders", False),
    "export": lambda result: (f"FMU for FMI {result['fmi']}", False),
    "convert": lambda result: (f"property file, model {result['model']}", bool(result["findings"])),
    "generate": lambda result: (f"code in {result['language']}", False),
    "check": _check_headline,
    "diagnose": _diagnose_headline,
}


def summary_of(command: str, result: Mapping[str, Any]) -> Iterator[str]:
    """Yield what a command found, from its JSON result.

    >>> list(summary_of("export", {"fmi": 3, "inputs": "slip", "bytes": 2048}))
    ['slip inputs, 2 KB']
    """
    yield from _SUMMARIES[command](result)


def _inspect(result: Mapping[str, Any]) -> Iterator[str]:
    findings = result["findings"]
    yield f"{len(findings) or 'no'} finding{'s'[: len(findings) != 1]}"
    yield from (f"{'warning' if each['serious'] else 'note'}: {each['text']}" for each in findings)


def _fit(result: Mapping[str, Any]) -> Iterator[str]:
    yield f"model {result['model']}"
    yield from result["reasons"]
    for each in result["channels"]:
        quality = f"RMSE {_short(each['rmse'])} {each['unit']}, R2 {_short(each['r2'])}"
        yield f"{each['recording']}, {each['channel']}: {quality}"


def _explore(result: Mapping[str, Any]) -> Iterator[str]:
    yield f"{result['bytes'] / 1024:.0f} KB"


def _export(result: Mapping[str, Any]) -> Iterator[str]:
    yield f"{result['inputs']} inputs, {result['bytes'] / 1024:.0f} KB"


def _convert(result: Mapping[str, Any]) -> Iterator[str]:
    if result["refitted"]:
        yield "coefficients fitted to the forces of the tire"
    yield from (f"{name}: RMS error {error:.2%}" for name, error in result["errors"].items())
    yield from (f"{each['severity']}: {each['text']}" for each in result["findings"])


def _generate(result: Mapping[str, Any]) -> Iterator[str]:
    yield f"{len(result['files'])} files"


def _check(result: Mapping[str, Any]) -> Iterator[str]:
    for name, each in result["channels"].items():
        yield f"{name}: RMSE {_short(each['rmse'])} {each['unit']}, R2 {_short(each['r2'])}"


def _diagnose(result: Mapping[str, Any]) -> Iterator[str]:
    yield result["verdict"]
    for channel, gap in result["gap"]["holdout"].items():
        if gap["before"] is not None:
            yield (
                f"{channel} on the hold-out set: error {_short(gap['before'])} {drawn_unit(channel)} before, "
                f"{_short(gap['after'])} after, noise floor {_short(gap['floor'])}"
            )


def _short(value: float | None) -> str:
    return "unknown" if value is None else f"{value:.4g}"


_SUMMARIES = {
    "inspect": _inspect, "fit": _fit, "explore": _explore, "export": _export, "convert": _convert,
    "generate": _generate, "check": _check, "diagnose": _diagnose,
}  # fmt: skip
