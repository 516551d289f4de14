"""Detection limits: the smallest detectable size of each effect, and the effects that are not identifiable."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from scipy.special import chdtri

from ...numerics.ties import graded
from ...symbolic.channels import OUTPUTS
from ...symbolic.detection import LARGEST_IN_SIZES
from ..probing.candidates import Candidate, excited, rows_per_second, varies
from ..probing.effect_probing import Screen, Tried
from ..thresholds import MIN_INDEPENDENT_SHARE

#: p-value under coloured noise, with Bonferroni correction, at which the detection limit of an effect is stated.
#: Convention.
EFFECT_P = 1e-3


def detectable_sizes(
    screen: Screen, candidates: Mapping[str, Candidate], tested: Sequence[Tried]
) -> tuple[dict[str, dict[str, float]], dict[str, str]]:
    """Return the smallest identifiable change of the forces by effect, and the effects that are not identifiable.

    `screen`: of the improved model. `candidates`: those that it lacks. `tested`: their responses in its residual.
    Returns: by effect and channel: root mean square, N and N m; by effect: the reason why this recording cannot
    identify it.
    """
    tire, signals, inverse_noise = screen.problem.simulator.tire, screen.signals, screen.problem.inverse_noise
    threshold = float(np.sqrt(chdtri(1, EFFECT_P / max(len(tested), 1))))
    detectable: dict[str, dict[str, float]] = {}
    not_identifiable: dict[str, str] = {}
    for name, candidate in candidates.items():
        lacking = [needed for needed in candidate.requires if not varies(signals, tire, needed)]
        unmeasured = [needed for needed in lacking if needed in OUTPUTS]
        responses = [effect.response for effect in tested if effect.name == name]
        if unmeasured:
            not_identifiable[name] = f"cross-talk of {' and '.join(unmeasured)}, which was not recorded, resembles it"
        elif lacking:
            not_identifiable[name] = f"{' and '.join(lacking)} does not vary or was not recorded"
        elif (rate := rows_per_second(signals)) < candidate.rate:
            others = [pair.other for pair in tire.symbolic_model.detections[name].confounded]
            similar = f" to separate it from {' and '.join(others)}" if others else ""
            not_identifiable[name] = f"it requires {candidate.rate:g} rows per second{similar}, not {rate:.0f}"
        elif not excited(signals, tire, candidate.requires):
            not_identifiable[name] = f"{' and '.join(candidate.requires)} do not vary simultaneously"
        elif not responses or not set(candidate.channels) & set(signals.channels):
            not_identifiable[name] = f"it changes {', '.join(candidate.channels)} only, which was not recorded"
        elif responses[0].independent_share < MIN_INDEPENDENT_SHARE:
            not_identifiable[name] = "it is confounded with coefficients of the baseline model in this recording"
        else:
            response = responses[0]
            k = int(np.argmin(graded(response.error)))
            smallest = threshold * float(response.error[k])
            if smallest > LARGEST_IN_SIZES:
                not_identifiable[name] = "its detection limit is more than five times its typical size"
                continue
            used = inverse_noise > 0.0
            change = np.divide(response.columns[:, :, k], inverse_noise, out=np.zeros(used.shape), where=used)
            rms = smallest * np.sqrt(np.sum(change**2, axis=1) / np.maximum(used.sum(axis=1), 1))
            detectable[name] = {
                channel: float(size) for channel, size in zip(signals.channels, rms, strict=True) if size > 0.0
            }
    return detectable, not_identifiable
