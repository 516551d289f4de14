"""The settings of the diagnosis that several modules share, and those of its priors: meaning, and reason for the value.

Others are beside their use. A value is *derived* from the method or from physics, as stated, or a *convention*: other
values are equally suitable. One value, `INEXACT_SHARE`, is calibrated on made recordings. Settings of one effect are in
its file (docs/effects.md), those of `tirefmu.numerics` in its modules.
"""

from __future__ import annotations

from collections.abc import Mapping

# ------------------------------------------------------------------ the recording

#: Maximum number of compared rows; of longer recordings every n-th row is compared. Convention: computing time.
MAX_ROWS = 6000
#: Length of a time block, s. Derived: blocks count as independent, so that it is 2.5 times the longest modelled
#: correlation of noise (`MAX_CORRELATION_TIME`), after which an exponential has fallen to a twelfth.
BLOCK_LENGTH = 2.5
#: Largest number of blocks. Convention: computing time.
MAX_BLOCKS = 60
#: Prior standard deviation of what is practically free: an offset in noise standard deviations, an effect in the linear
#: test in probe sizes. Convention.
FREE_PRIOR = 20.0
#: Slip at which a smooth sign of it has three quarters of its size, 1 or rad. Convention.
SIDE = 0.02
#: Minimum range of an input that identifies an effect: 1, rad, rad and share of nominal load or speed. Derived for the
#: slips: over half of SIDE a smooth sign changes by half. Conventions for the others, several times the accuracy with
#: which a bench holds them constant: 0.1 deg, 0.5 % of the load, below which the tire is lifted, and 1 % of the speed.
MIN_VARIATION: Mapping[str, float] = {
    "kappa": 0.5 * SIDE, "alpha": 0.5 * SIDE, "gamma": 0.005, "Fz": 0.02, "V": 0.05,
}  # fmt: skip

# ------------------------------------------------------------------ the baseline fit and the probes

#: Minimum number of rows of a block, or half the median of all blocks if that is smaller. Convention: the scatter of 20
#: rows is known to a sixth. Derived for the half: blocks are intervals of time, and a recording with few rows per
#: second has no blocks of 20 rows.
MIN_ROWS_OF_BLOCK = 20
#: Share of a response's norm that is orthogonal to the baseline's tangent space; with less it is not tested, and an
#: effect is not identifiable. Derived: the standard error is then 20 times that of the response alone.
MIN_INDEPENDENT_SHARE = 1.0 / FREE_PRIOR
#: Correlation from which two explanations are confounded, and from which the other one is reported. Pairs that are
#: confounded by design had 0.80 to 1 in an independent study. Derived for the lower value: half of the variance is then
#: common.
CONFOUNDED, REPORTED = 0.8, 0.7

# ------------------------------------------------------------------ the comparison of explanations

#: Number of compared rows at which the likelihood is raised to the power 1/2: no model of a tire or of its noise is
#: exact, so that evidence does not grow in proportion to the rows. An independent study of 76 recordings, most of them
#: with 4,500 rows, gave the power 0.3.
COARSENED_ROWS = 2000
#: Share of the logarithm of the likelihood that an explanation gains and that may be wrong, as no form of an effect is
#: exact: a thirtieth of the response, squared. The one number that is calibrated: on the memory suite of
#: docs/discovery.md, where 0.0003 to 0.002 name most effects correctly.
INEXACT_SHARE = 0.001
#: Prior odds of each effect and of an unknown component. Convention: about one of all effects is missing.
EFFECT_ODDS = 1.0 / 40.0
#: Prior standard deviation of a term of the unknown component, as a share of all forces. Convention.
UNKNOWN_SHARE = 0.1
#: Prior standard deviation of errors of the form of an effect, as a share of its response: of any effect (its square is
#: the share of what is explained that probabilities leave out), and of one with states, as a tire has several memories,
#: an effect of the library one. Conventions.
FORM_ERROR, PAST_ERROR = 0.1, 1.0
#: Prior standard deviations of the discrepancy of the model, as a share of the forces; the evidence selects one of them
#: for each channel. Conventions.
DISCREPANCIES = (0.002, 0.006, 0.02, 0.06, 0.2)
#: Number of parts of the recording without each of which the leading explanations are scored. Convention.
FOLDS = 5
#: Largest number of effects that are refitted in place of one with which they are confounded. Logarithm of the evidence
#: relative to the best explanation from which an addition is refitted: a twentieth. Conventions: computing time.
RIVALS, REFIT_MARGIN = 3, -3.0
