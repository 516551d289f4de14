"""The thresholds of the diagnosis: unit, meaning, and reason for the value.

There are four kinds of reasons:

- *Derived*: the value follows from the method or from physics, as stated.
- *Convention*: other values are equally suitable.
- *Benchmark*: the value was selected by results on the 116 recordings of docs/discovery.md. The rates in that document
  are measured on the same recordings and are optimistic in this respect.
- *Not recorded*: the value is that of the first version; no study of it is recorded.

No recorded study validates a single threshold on independent data. The benchmark validates, as a set, the thresholds
that it did not select. The measured recordings of ``make real`` (docs/diagnosis.md) selected no value, but some rules
followed from looking at one of them: errors of the load, the least variation of a speed, `FURTHER_MEMORY` beside an
effect of a recorded temperature, another first effect (`search/memory.py`), and corrections of the functional form
(`search/proposals.py`). For these, the confirmation suite is the validation (docs/discovery.md).

Thresholds of one effect are in its file (docs/effects.md), those of `tirefmu.estimation` in its modules.
"""

from __future__ import annotations

from collections.abc import Mapping

from tirefmu.measurements.virtual_bench.bench_errors import CROSS_TALK_PRIOR_SHARE as CROSS_TALK_PRIOR_SHARE
from tirefmu.measurements.virtual_bench.bench_errors import DRIFT_WAVES as DRIFT_WAVES
from tirefmu.measurements.virtual_bench.bench_errors import MAX_CROSS_TALK as MAX_CROSS_TALK
from tirefmu.measurements.virtual_bench.bench_errors import MAX_SKEW as MAX_SKEW

# ------------------------------------------------------------------ the recording

#: Minimum number of rows under load. Derived from `MIN_BLOCKS`: a block then has about 16 rows.
MIN_ROWS = 200
#: Maximum number of compared rows; of longer recordings every n-th row is compared. Convention: computing time.
MAX_ROWS = 6000
#: Share of nominal load above which a row is compared; below it the tire is lifted. Not recorded.
MIN_LOAD = 0.02
#: In time steps: a longer step is a gap in time, which separates segments of smoothing. Not recorded.
TIME_GAP = 5.0
#: Length of a time block, s; longer than the modelled correlation (`MAX_CORRELATION_TIME`). Not recorded.
BLOCK_LENGTH = 2.5
#: Number of blocks. A jackknife covariance of k responses requires more than k + 1 blocks; many blocks cost computing
#: time. Convention.
MIN_BLOCKS, MAX_BLOCKS = 12, 60
#: Minimum number of blocks with measured outputs; with fewer, their scatter has too few degrees of freedom. Convention.
MIN_MEASURED_BLOCKS = 8
#: Every n-th block is in the hold-out set, which no fit uses. Convention.
HOLDOUT_EVERY = 8
#: Longitudinal slip, 1. Below it Fx contains drag and offset only, as its peak is near 0.1. Not recorded.
MIN_KAPPA = 0.004
#: Prior standard deviations of offset (practically free) and drift, in noise standard deviations. Not recorded.
OFFSET_PRIOR, DRIFT_PRIOR = 20.0, 1.0
#: Drift that may explain structure: largest number of half waves, and prior standard deviation of the k-th one times k,
#: in noise standard deviations. The quotient is derived: a random walk has it. The size and the number are conventions.
FAST_DRIFT_WAVES, FAST_DRIFT_PRIOR = 12, 2.0
#: Smallest skew that is corrected, s: in a sweep of 10 deg/s, 3 ms are 0.03 deg. Benchmark: increased from 1 ms after a
#: skew of -2 ms was found in a recording with hysteresis.
MIN_SKEW = 0.003
#: Prior standard deviation of the relative error of the load that follows the direction of slip: benches hold the load
#: within 1 %. Errors beyond two deviations are attributed to the tire. Convention.
LOAD_ERROR_PRIOR = 0.005
#: Minimum range of an input that identifies an effect: 1, rad, rad and share of nominal load or speed. Not recorded,
#: except the last one, a convention: a bench holds a constant speed within 1 %.
MIN_VARIATION: Mapping[str, float] = {"kappa": 0.01, "alpha": 0.01, "gamma": 0.005, "Fz": 0.02, "V": 0.05}
#: The same in standard deviations of the input's noise. Not recorded.
MIN_VARIATION_IN_NOISE = 4.0

#: Share of the rows in which all slips and angles of an effect deviate from zero by half of their minimum range.
#: Derived: about 2 % of the rows is one of 50 blocks, the least that a jackknife over blocks can omit.
MIN_JOINT_SHARE = 0.02

# ------------------------------------------------------------------ the baseline fit and the probes

#: Outliers exceed twice this number of robust standard deviations of the short-range residual. Not recorded.
OUTLIER = 7.0
#: Rows over which the short-range residual is centred. Not recorded.
LOCAL_ROWS = 15
#: Prior standard deviation of an effect in the linear test, in probe sizes: practically free. Convention.
PROBE_PRIOR = 20.0
#: Longest lag of the noise covariance in the test, s; the block jackknife covers longer correlations. Not recorded.
MAX_CORRELATION_TIME = 1.0
#: Minimum number of rows of a block, or half the median of all blocks if that is smaller. Not recorded; the half is
#: derived: blocks are intervals of time, and a recording with few rows per second has no blocks of 20 rows.
MIN_ROWS_OF_BLOCK = 20
#: Share of a response's norm that is orthogonal to the baseline's tangent space; with less it is not tested. Derived:
#: the standard error is then 50 times that of the response alone.
MIN_INDEPENDENT_SHARE = 0.02
#: The same for an effect's first form; with less it is reported as not identifiable. Convention.
NOT_IDENTIFIABLE = 0.05
#: Correlation from which two explanations are confounded, and from which the other one is reported. Pairs that are
#: confounded by design had 0.80 to 1 in an independent study; the lower value is not recorded.
CONFOUNDED, REPORTED = 0.8, 0.7
#: Share of an effect's norm from which the response of a single coefficient is compared as well. Not recorded.
MIN_SHARE = 0.4

# ------------------------------------------------------------------ identified effects

#: p-value under coloured noise with Bonferroni correction. Convention: one false identification in 1000 recordings if
#: the noise model were exact. It is not, hence three further criteria.
EFFECT_P = 1e-3
#: Other p-values are larger or smaller by this factor. Larger: that of the block jackknife, as blocks are few and
#: unequal, and that from which a candidate is refitted, as the nonlinear fit may gain more. Smaller: those of a
#: formula, which can have many forms. Not recorded.
P_FACTOR = 10.0
#: Minimum gain in cross-validation, in standard errors. Benchmark: increased from 1 to 1.2 and to 1.4 after false
#: identifications in recordings without a missing effect (docs/discovery.md, "Limitations").
EFFECT_ERRORS = 1.4
#: Largest share of one block in that sum of gains; larger gains are reduced. Convention: at least five blocks gain;
#: five equal gains among 50 blocks have 2.3 standard errors.
LARGEST_SHARE = 0.2
#: Minimum gain as a share of the squared misfit. Decreased from 0.008, which rejected weak true effects; no study of it
#: is recorded.
EFFECT_GAIN = 0.003
#: Number of candidates and of refinements refitted in a round, and maximum number of rounds. Five as in the independent
#: study of the method; the others are conventions.
REFITTED, REFITTED_REFINEMENTS, ROUNDS = 5, 2, 6
#: Standard errors of the difference by which the gain of a refinement, of an effect that contains another, or of a
#: formula with one more term must exceed that of the simpler explanation. Convention: about 95 %.
PREFERRED_ERRORS = 2.0
#: An effect is preferred to unexplained structure from this share of its gain. Not recorded: a flexible formula gains
#: more than one effect if several are missing.
PREFERRED_SHARE = 0.6
#: The same for the joint gain with the effects that the next rounds would identify, and the number of those rounds.
#: Benchmark: several missing effects were reported as unexplained structure.
PREFERRED_JOINT_SHARE, LOOKAHEAD = 0.8, 3
#: Share of the gain of an identified effect with states, or of a recorded temperature, that a further effect of the
#: past must gain. Benchmark: a hysteresis of another form was reported as two effects.
FURTHER_MEMORY = 0.15
#: Rows of the fits in the search; iterations of the final fit. Conventions: computing time.
SEARCH_ROWS, FINAL_ITERATIONS = 2500, 6

# ------------------------------------------------------------------ confirmation in the final fit

#: Joint significance of an effect in the final fit, in standard deviations of a normal distribution. Convention: true
#: effects of an independent study had 5.9 or more, false ones mostly less than 4. The measured rate of false names
#: (docs/discovery.md) is none of 100 recordings of the first generator from 2 on, and 4 of 100 of the second generator
#: at any threshold up to 4. It was selected on neither.
CONFIRMED_Z = 4.0
#: Ratio of root mean square residuals, whitened to equal weights, above which the whitened fit is not used. Convention:
#: the agreement that is required of reported residuals.
MAX_WHITENED_MISFIT = 1.02

# ------------------------------------------------------------------ the probability of explanations

#: Power of the likelihood. No model of a tire or of its noise is exact; with 1 probabilities are too near 0 and 1. From
#: an independent study of 76 recordings; the suites of docs/discovery.md did not select it.
LIKELIHOOD_POWER = 0.3
#: Prior odds of each effect and of an unknown component. Convention: about one of all effects is missing.
EFFECT_ODDS = 1.0 / 40.0
#: Prior standard deviation of a term of the unknown component, as a share of all forces. Convention.
UNKNOWN_SHARE = 0.1
#: Prior standard deviation of the discrepancy of an effect, as a share of its response, and those of the discrepancy of
#: the model, as a share of the forces, of which the evidence selects one. Conventions.
FORM_ERROR, DISCREPANCIES = 0.1, (0.002, 0.006, 0.02)
#: Number of effects that are refitted in place of each identified one, and logarithm of the evidence relative to the
#: best explanation from which an addition is refitted. Conventions: computing time.
RIVALS, REFIT_MARGIN = 3, -4.0

# ------------------------------------------------------------------ unexplained structure

#: Minimum gain of a formula in standard errors. Benchmark: increased from 1.
STRUCTURE_ERRORS = 1.2
#: Minimum gain of a formula as a share of the squared misfit, and of a further term as a share of the gain of the
#: previous terms. Not recorded.
STRUCTURE_GAIN = 0.03
#: Number of best correlated columns that are cross-validated. Convention: computing time.
SHORTLIST = 12
#: Maximum number of terms of a formula. Convention: legibility.
MAX_TERMS = 3
#: Minimum gain of a further term with a new variable in standard errors. Benchmark: variables of unexplained structure.
TERM_ERRORS_OF_VARIABLE = 2.5
#: Number of long stretches of a recording, minimum number that an effect or a formula must predict better, and share of
#: the gain of a formula that must remain. By chance 6 or more of 8 are positive in 14 %: the criterion rejects proxies,
#: not noise. 43 of 44 true effects of an independent study passed it. Benchmark.
STRETCHES, MIN_STRETCHES, MIN_RETAINED_GAIN = 8, 6, 0.5
#: Share of the squared misfit on the hold-out set that a formula must remove to be added. Not recorded.
MIN_IMPROVEMENT = 0.02
#: Bounds of a formula's coefficient as multiples of its estimate. Convention.
COEFFICIENT_BOUND_FACTOR = 10.0

# ------------------------------------------------------------------ the delivered tire and the verdict

#: Probability with which a tire that is as good as the baseline tire, in each channel and on both sets, is not
#: delivered. Convention.
WORSE_P = 0.05
#: Largest uncertainty of an effect over the operating range, as a share of its spread among tires; the same for the
#: coefficients of a refinement. Derived: above it,
#: three quarters of the knowledge about the effect's variance come from other tires, not from the recording.
MAX_UNCERTAINTY = 0.5
#: Largest change of a force by an effect that the recording does not determine, in multiples of the spread among tires.
#: Derived: a larger one is less plausible than none. Benchmark: effects that the recording determines are exempt,
#: because true effects were larger than the spread.
MAX_UNDETERMINED_CHANGE = 1.0
#: Residual over noise floor above which a channel lacks something that was not identified. From the requirements of the
#: diagnosis.
INADEQUATE = 1.5

# ------------------------------------------------------------------ the report

#: A channel is reported for an effect from this share of the largest channel's power. Convention.
CHANNEL_SHARE = 0.02
#: Share of the evidence in the reported stretches of time. Convention.
REPORTED_EVIDENCE = 0.67
#: Distance outside an input's range at which an effect is evaluated, as a share of the range and of the distance to the
#: limit of the physical range, and the change of its part of a force, relative to the force, that is reported as
#: doubtful. Convention.
EXTRAPOLATED_SHARE, MAX_CHANGE = 0.5, 0.15
#: Minimum number of rows of a cell whose mean is shown in a residual map. Derived: its standard error is then a third
#: of the noise.
MIN_ROWS_OF_CELL = 10
