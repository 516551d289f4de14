"""The result of each command in a few lines, for the terminal and the page of a project."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from ...drawing.labels import drawn_unit


@dataclass(frozen=True)
class Summary:
    """The result of a command.

    - `text`: what matters most, in one line.
    - `rating`: one of "good", "limited", "bad".
    - `lines`: what the command found.
    """

    text: str
    rating: str
    lines: tuple[str, ...]


def summary_of(command: str, result: Mapping[str, Any], status: int) -> Summary:
    """Return the summary of the JSON result of a command.

    `status`: the command's exit code.

    >>> summary_of("export", {"fmi": 3, "inputs": "slip", "bytes": 2048}, 0)
    Summary(text='FMU for FMI 3', rating='good', lines=('slip inputs, 2 KB',))
    """
    text, limited, lines = _SUMMARIES[command](result)
    return Summary(text, "bad" if status else "limited" if limited else "good", tuple(lines))


#: Headline, whether it is limited, lines.
_Parts = tuple[str, bool, list[str]]


def _inspect(result: Mapping[str, Any]) -> _Parts:
    findings = result["findings"]
    serious = any(finding["serious"] for finding in findings)
    lines = [f"{len(findings) or 'no'} finding{'s'[: len(findings) != 1]}"]
    lines += [f"{'warning' if finding['serious'] else 'note'}: {finding['text']}" for finding in findings]
    return "data would mislead a fit" if serious else "data ready for a fit", bool(findings), lines


def _fit(result: Mapping[str, Any]) -> _Parts:
    lines = [f"{channel['recording']}, {channel['channel']}: {_quality(channel)}" for channel in result["channels"]]
    reasons = result["reasons"]
    return f"tire {result['verdict']}", bool(reasons), [f"model {result['model']}", *reasons, *lines]


def _explore(result: Mapping[str, Any]) -> _Parts:
    return "page with sliders", False, [_size(result)]


def _export(result: Mapping[str, Any]) -> _Parts:
    return f"FMU for FMI {result['fmi']}", False, [f"{result['inputs']} inputs, {_size(result)}"]


def _convert(result: Mapping[str, Any]) -> _Parts:
    lines = ["coefficients fitted to the forces of the tire"] if result["refitted"] else []
    lines += [f"{name}: RMS error {error:.2%}" for name, error in result["errors"].items()]
    lines += [f"{finding['severity']}: {finding['text']}" for finding in result["findings"]]
    return f"property file, model {result['model']}", bool(result["findings"]), lines


def _generate(result: Mapping[str, Any]) -> _Parts:
    return f"code in {result['language']}", False, [f"{len(result['files'])} files"]


def _check(result: Mapping[str, Any]) -> _Parts:
    lines = [f"{name}: {_quality(channel)}" for name, channel in result["channels"].items()]
    tire = result["statements"]["tire"]
    doubtful, shown = tire["grade"] != "good", [tire["text"], *lines]
    return "FMU check passed" if result["ok"] else "FMU check failed", doubtful, shown


def _diagnose(result: Mapping[str, Any]) -> _Parts:
    effects, headline = bool(result["found"]), result["headline"]
    adequate = all(channel["adequate"] for channel in result["adequacy"].values())
    lines = [
        f"{channel} on the hold-out set: error {_short(gap['before'])} {drawn_unit(channel)} before, "
        f"{_short(gap['after'])} after, noise floor {_short(gap['floor'])}"
        for channel, gap in result["gap"]["holdout"].items() if gap["before"] is not None
    ]  # fmt: skip
    return headline[:1].lower() + headline[1:], effects or not adequate, [result["verdict"], *lines]


def _quality(channel: Mapping[str, Any]) -> str:
    return f"RMSE {_short(channel['rmse'])} {channel['unit']}, R2 {_short(channel['r2'])}"


def _size(result: Mapping[str, Any]) -> str:
    return f"{result['bytes'] / 1024:.0f} KB"


def _short(value: float | None) -> str:
    return "unknown" if value is None else f"{value:.4g}"


_SUMMARIES: Mapping[str, Callable[[Mapping[str, Any]], _Parts]] = {
    "inspect": _inspect, "fit": _fit, "explore": _explore, "export": _export, "convert": _convert,
    "generate": _generate, "check": _check, "diagnose": _diagnose,
}  # fmt: skip
