"""The result of each command in a few lines, for the terminal and the page of a project."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any


def summary_of(command: str, result: Mapping[str, Any]) -> Iterator[str]:
    """Yield what a command found, from its JSON result.

    Parameters
    ----------
    command : str
    result : mapping of str to Any

    Examples
    --------
    >>> list(summary_of("export", {"fmi": 3, "inputs": "slip", "bytes": 2048}))
    ['FMI 3, slip inputs, 2 KB']
    """
    yield from _SUMMARIES[command](result)


def _inspect(result: Mapping[str, Any]) -> Iterator[str]:
    findings = result["findings"]
    serious = [each for each in findings if each["serious"]]
    yield f"{len(findings)} findings, {len(serious)} of them serious"
    yield from (f"warning: {each['text']}" for each in serious)


def _fit(result: Mapping[str, Any]) -> Iterator[str]:
    yield f"verdict: {result['verdict']['word']} ({result['model']})"
    yield from result["verdict"]["reasons"]
    for each in result["channels"]:
        quality = f"RMSE {_short(each['rmse'])} {each['unit']}, R2 {_short(each['r2'])}"
        yield f"{each['recording']}, {each['channel']}: {quality}"


def _explore(result: Mapping[str, Any]) -> Iterator[str]:
    yield f"page with sliders, {result['bytes'] / 1024:.0f} KB"


def _export(result: Mapping[str, Any]) -> Iterator[str]:
    yield f"FMI {result['fmi']}, {result['inputs']} inputs, {result['bytes'] / 1024:.0f} KB"


def _check(result: Mapping[str, Any]) -> Iterator[str]:
    for name, each in result["channels"].items():
        yield f"{name}: RMSE {_short(each['rmse'])} {each['unit']}, R2 {_short(each['r2'])}"


def _diagnose(result: Mapping[str, Any]) -> Iterator[str]:
    yield result["verdict"]
    for channel, gap in result["gap"]["holdout"].items():
        if gap["before"] is not None:
            yield (
                f"{channel} on the hold-out set: error {_short(gap['before'])} before, {_short(gap['after'])} after, "
                f"noise floor {_short(gap['floor'])}"
            )


def _short(value: float | None) -> str:
    return "unknown" if value is None else f"{value:.4g}"


_SUMMARIES = {
    "inspect": _inspect, "fit": _fit, "explore": _explore, "export": _export, "check": _check, "diagnose": _diagnose,
}  # fmt: skip
