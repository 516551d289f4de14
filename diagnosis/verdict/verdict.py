"""The verdict of a diagnosis: a headline and its sentences."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import hypot
from typing import Any

from ...drawing.labels import drawn_unit
from ...numerics.ties import graded
from ..explanations.answer import NAMED, OneOf, percent
from ..unexplained.formula_proposal import Unknown
from .adequacy import Adequacy
from .findings import FoundEffect

#: A channel is reported for an effect from this share of the largest channel's power. Convention.
CHANNEL_SHARE = 0.02
_NOTHING, _UNIDENTIFIED = "nothing material is missing", "no effect is identified as missing"


def verdict_sentences(
    findings: Sequence[FoundEffect], unknown: Sequence[Unknown], confounded: Mapping[str, Mapping[str, float]],
    refined: Sequence[str], adequacy: Sequence[Adequacy], detectable: Mapping[str, Mapping[str, float]],
    against: Sequence[str], recording: Mapping[str, Any], *, one_of: Sequence[OneOf] = (), stopped: bool = False,
) -> list[str]:  # fmt: skip
    """Return the sentences of the verdict: what is missing, refined, not identified and removed, and reservations.

    `confounded`: correlation with other explanations, by effect. `refined`: refinements of effects of the baseline
    model. `detectable`: smallest detectable sizes, by effect and channel. `against`: reasons why the improved tire is
    not delivered. `recording`: errors of the recording. `one_of`: effects of which one is missing. `stopped`:
    whether explanations remained, so that it is not known that nothing is missing.
    """
    parts = _missing(findings, unknown, confounded, one_of)
    if refined:
        parts.append(f"refinement needed: {'; '.join(refined)}")
    red = [str(rated) for rated in adequacy if rated.rating == "red"]
    if red:
        what = "is missing in the delivered tire" if against else "is missing and was not identified"
        parts.append(f"something {what} in {', '.join(red)}")
    parts = parts or [_UNIDENTIFIED if stopped else _nothing(adequacy, detectable)]
    if against:
        parts.append(f"the improved tire is not delivered, because {'; '.join(against)}")
    if removed := _removed(recording["periodic"], adequacy):
        parts.append(removed)
    if recording["derived_columns"]:
        parts.append(f"not recorded, but computed from other columns: {', '.join(recording['derived_columns'])}")
    return [part[0].upper() + part[1:] for part in parts]


def headline_text(
    findings: Sequence[FoundEffect], adequacy: Sequence[Adequacy], delivered: bool, stopped: bool,
    one_of: Sequence[OneOf] = (),
) -> str:  # fmt: skip
    """Return what an engineer needs first: the effects that are missing, and where something else is.

    >>> headline_text((), (), True, False)
    'Nothing material is missing'
    >>> headline_text((), (), True, True)
    'Best explanation so far: no effect is identified as missing'
    """
    in_class = {name for alternatives in one_of for name in alternatives.effects}
    names = [finding.effect for finding in findings if finding.probability >= NAMED and finding.effect != "UNKNOWN"]
    missing = [name for name in names if name not in in_class]
    missing += [
        f"either {', '.join(others)} or {last}" for *others, last in (alternatives.effects for alternatives in one_of)
    ]
    red = [rated.channel for rated in adequacy if rated.rating == "red"]
    parts = [f"missing: {', '.join(missing)}"] if missing else []
    if any(finding.effect == "UNKNOWN" and finding.probability >= NAMED for finding in findings):
        parts.append("an effect is missing that is not in the library")
    elif red:
        what = f"something {'else ' * bool(missing)}is missing" + " and was not identified" * delivered
        parts.append(f"{what} in {', '.join(red)}")
    if not delivered:
        parts.append("the improved tire is not delivered")
    if "missing" not in " ".join(parts):
        parts = [_UNIDENTIFIED if findings or stopped else _NOTHING, *parts]
    text = "; ".join(parts)
    return f"Best explanation so far: {text}" if stopped else text[0].upper() + text[1:]


def _missing(
    findings: Sequence[FoundEffect], unknown: Sequence[Unknown], confounded: Mapping[str, Mapping[str, float]],
    one_of: Sequence[OneOf],
) -> list[str]:  # fmt: skip
    """Return the sentences on effects that are more probable than not, and on others of the improved tire."""
    missing, uncertain = list[str](), list[str]()
    in_class = {name: alternatives for alternatives in one_of for name in alternatives.effects}
    reported = set[OneOf]()
    for finding in findings:
        if finding.effect in in_class:
            alternatives = in_class[finding.effect]
            if alternatives not in reported:
                missing.append(_one_of_text(alternatives, findings))
            reported.add(alternatives)
            continue
        certain = missing if finding.probability >= NAMED else uncertain
        if finding.effect == "UNKNOWN":
            if unknown[0].formula:
                sure = percent(finding.probability)
                certain.append(
                    f"an unexplained effect that depends on {', '.join(unknown[0].depends_on)} (probability {sure})"
                )
            continue
        size = confounded.get(finding.effect, {})
        others = ", ".join(sorted(size, key=lambda name: -graded(size[name])))
        bounds = f"; at its bound: {', '.join(finding.at_bounds)}" if finding.at_bounds else ""
        confounded_with = f"; confounded with {others}" if others else ""
        certain.append(f"{finding.effect} (probability {percent(finding.probability)}{bounds}{confounded_with})")
    headed = (("Missing", missing), ("The fit is better with, but does not identify", uncertain))
    return [f"{head}: {'; '.join(names)}" for head, names in headed if names]


def _one_of_text(alternatives: OneOf, findings: Sequence[FoundEffect]) -> str:
    """Return the sentence on effects of which one is missing, and which of them the improved tire has."""
    delivered = [finding for finding in findings if finding.effect in alternatives.effects]
    names = ", ".join(finding.effect for finding in delivered)
    if len(delivered) == 1:
        names += ", the most probable" if names == alternatives.effects[0] else ", a simpler one"
    at_bounds = ", ".join(name for finding in delivered for name in finding.at_bounds)
    bounds = f"; at its bound: {at_bounds}" if at_bounds else ""
    share = percent(alternatives.probability)
    return (
        f"{' or '.join(alternatives.effects)} (one of them: probability {share}; the improved tire has {names}{bounds})"
    )


def _removed(waves: Sequence[Mapping[str, Any]], adequacy: Sequence[Adequacy]) -> str:
    """Return the sentence on periodic disturbances: amplitudes by period, in channels with a considerable share.

    Considerable is compared with the noise floor and with the channel of the largest ratio. The JSON has all waves.
    """
    floors, sizes = {rated.channel: max(rated.floor, 1e-12) for rated in adequacy}, dict[str, dict[str, float]]()
    for wave in waves:  # one whose amplitude or period changes slowly is several waves of nearly the same period
        period = f"{1.0 / wave['frequency']:.3g} {'s' if wave['over'] == 't' else 'm of distance'}"
        amplitudes = sizes.setdefault(period, {})
        amplitudes |= {name: hypot(amplitudes.get(name, 0.0), wave["amplitude"][name]) for name in floors}
    texts = [
        f"{size:.3g} {drawn_unit(name)} in {name} every {every} (amplitude, {size / floors[name]:.1f} times the noise "
        "floor)"
        for every, amplitudes in sizes.items()
        for name, size in amplitudes.items()
        if (size / floors[name]) ** 2
        > CHANNEL_SHARE * max(1.0, *((amplitude / floors[other]) ** 2 for other, amplitude in amplitudes.items()))
    ]
    return f"removed as a periodic disturbance of the recording: {'; '.join(texts)}" if texts else ""


def _nothing(adequacy: Sequence[Adequacy], detectable: Mapping[str, Mapping[str, float]]) -> str:
    channels = [rated.channel for rated in adequacy]
    sizes = {
        channel: sorted(limits[channel] for limits in detectable.values() if channel in limits) for channel in channels
    }
    text = ", ".join(
        f"{size[len(size) // 2]:.2g} {drawn_unit(channel)} in {channel}" for channel, size in sizes.items() if size
    )
    return f"{_NOTHING} (smallest detectable effect, median: {text})"
