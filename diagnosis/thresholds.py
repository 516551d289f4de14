"""The thresholds of the diagnosis: unit, meaning, and why each has its value.

The reasons are of four kinds:

- *Derived*: the value follows from the method or from physics, as stated.
- *Convention*: another value would serve as well.
- *Made suite*: results on the 116 recordings of docs/discovery.md chose the value. The table there is measured on the
  same recordings, so its rates are optimistic in this respect.
- *Not recorded*: the value came with the first version of the engine, and no study of it is recorded.

No recorded study checks a single threshold on data that did not choose it. The made suite checks the set of those that
it did not choose; the measured recordings of ``make real`` (docs/diagnosis.md) chose none and check the whole set.

Thresholds of one effect are in its file (docs/effects.md), those of the estimation engine in its modules.
"""

from __future__ import annotations

from collections.abc import Mapping

# ------------------------------------------------------------------ the recording

#: Rows under load; fewer are refused. Derived from `MIN_BLOCKS`: a block then has about 16 rows.
MIN_ROWS = 200
#: Rows; of longer recordings every k-th row is compared. Convention, for the duration.
MAX_ROWS = 6000
#: Share of nominal load above which a row is compared: below, the tire is lifted. Not recorded.
MIN_LOAD = 0.02
#: Time steps; a longer one is a gap, across which nothing is smoothed or counted. Not recorded.
TIME_GAP = 5.0
#: s; length of a block of time, longer than the correlation that is modelled (`MAX_CORRELATION_TIME`). Not recorded.
BLOCK_LENGTH = 2.5
#: Blocks. A jackknife covariance of k responses needs more than k + 1 blocks; many blocks cost time. Convention.
MIN_BLOCKS, MAX_BLOCKS = 12, 60
#: Blocks in which something is measured; with fewer, their scatter has hardly any degrees of freedom. Convention.
MIN_MEASURED_BLOCKS = 8
#: Every n-th block is the hold-out that no decision uses: an eighth of the rows. Convention.
HOLDOUT_EVERY = 8
#: Longitudinal slip, 1; below it Fx shows drag and offset only, as its peak is near .1. Not recorded.
MIN_KAPPA = 0.004
#: Half waves of drift over the recording: slower than sweeps, so that drift imitates no slip curve. Not recorded.
DRIFT_WAVES = 3
#: Noise standard deviations: priors of an offset, which is practically free, and of a drift. Not recorded.
OFFSET_PRIOR, DRIFT_PRIOR = 20.0, 1.0
#: Share of the other force: prior of cross-talk, and the most that is taken for cross-talk; more is an effect of the
#: tire. Not recorded; the benches of the made suite have .3 %. A bench that declares 1 % is beyond it: a known limit.
CROSS_TALK_PRIOR, MAX_CROSS_TALK = 0.002, 0.006
#: 1, rad, rad and share of nominal load: an input that varies less shows no effect. Not recorded.
MIN_VARIATION: Mapping[str, float] = {"kappa": 0.01, "alpha": 0.01, "gamma": 0.005, "Fz": 0.02}
#: Standard deviations of an input's noise: its range has to be larger. Not recorded.
MIN_VARIATION_IN_NOISE = 4.0

# ------------------------------------------------------------------ the baseline fit and the probes

#: Robust standard deviations of short-range residual, twice over: a row beyond them is an outlier. Not recorded.
OUTLIER = 7.0
#: Sizes of a probe: prior standard deviation of an effect in the linear test, practically free. Convention.
PROBE_PRIOR = 20.0
#: s; the longest correlation in the covariance of a response; a longer one is left to the blocks. Not recorded.
MAX_CORRELATION_TIME = 1.0
#: Rows of a block that takes part; half of a typical block's where that is fewer. Not recorded; the half is derived:
#: blocks are stretches of time, and a recording of three rows per second has none of 20 rows.
MIN_ROWS_OF_BLOCK = 20
#: Share of a response's norm outside the baseline's tangent space; with less it cannot be tested. Derived: the estimate's
#: error is then 50 times that of the response by itself.
MIN_INDEPENDENT_SHARE = 0.02
#: The same for an effect's first form; with less it is reported as not identifiable. Convention.
NOT_IDENTIFIABLE = 0.05
#: Correlation from which two explanations count as one, and from which the other one is reported. Pairs that are
#: confounded by design had .80 to 1 in an independent study; the lower value is not recorded.
CONFOUNDED, REPORTED = 0.8, 0.7
#: Share of an effect's norm from which a coefficient's own response is compared as well. Not recorded.
MIN_SHARE = 0.4

# ------------------------------------------------------------------ identified effects

#: Probability under coloured noise, after Bonferroni. Convention: one false name in 1000 recordings if the model of the
#: noise were exact. It is not, hence three further gates.
EFFECT_P = 1e-3
#: Probability by blocks of time, which are few and unequal, so that less is required. Not recorded.
EFFECT_P_OF_BLOCKS = 1e-2
#: Standard errors of the gain in cross-validation. Made suite: raised from 1 to 1.2 and to 1.4, as recordings with
#: nothing missing had passed with less (docs/discovery.md, "What it cannot do").
EFFECT_ERRORS = 1.4
#: Share of the squared misfit; a smaller gain is not material. Not recorded. It also stops weak true effects.
EFFECT_GAIN = 0.008
#: Multiples of `EFFECT_P` up to which a candidate is refitted: the nonlinear fit may gain more. Not recorded.
REFIT_P_FACTOR = 10.0
#: Candidates and refinements that are refitted in a round, and rounds. Five as in the independent study of the method;
#: the others are conventions.
REFITTED, REFITTED_REFINEMENTS, ROUNDS = 5, 2, 6
#: Standard errors of the difference in gain by which a refinement, or an effect that contains another, has to be better
#: than the plainer explanation. Convention: about 95 %.
PREFERRED_ERRORS = 2.0
#: Share of the gain of unexplained structure from which an effect is preferred to it. Not recorded: a formula fitted to
#: all that is missing gains more than one effect.
PREFERRED_SHARE = 0.6
#: The same together with the effects that would be identified after it, and how many of them are tried. Made suite:
#: several effects at once were reported as unexplained structure.
PREFERRED_JOINT_SHARE, LOOKAHEAD = 0.8, 3
#: Rows of the search's fits; iterations of the last fit. Conventions, for the duration.
SEARCH_ROWS, FINAL_ITERATIONS = 2500, 6

# ------------------------------------------------------------------ unexplained structure

#: Probabilities as for effects, a tenth of them, as a formula may take many forms. Not recorded.
STRUCTURE_P, STRUCTURE_P_OF_BLOCKS = 1e-4, 1e-3
#: Standard errors of the gain (made suite: raised from 1), and share of the squared misfit (not recorded).
STRUCTURE_ERRORS, STRUCTURE_GAIN = 1.2, 0.03
#: Columns whose cross-validation is computed, of those sorted by correlation. Convention, for the duration.
SHORTLIST = 12
#: Terms of a formula. Convention: more are hard to read.
MAX_TERMS = 3
#: Gain of a further term: share of what the first ones explain, standard errors, and standard errors where it brings a
#: further variable. Made suite: the variables of unknown structure.
TERM_GAIN, TERM_ERRORS, TERM_ERRORS_OF_VARIABLE = 0.03, 2.0, 2.5
#: Long stretches left out in turn, in how many of them structure has to gain, and the share of the gain that has to
#: remain. By chance 6 or more of 8 are positive in 14 %: it excludes proxies, not noise. Made suite.
STRETCHES, MIN_STRETCHES, MIN_RETAINED_GAIN = 8, 6, 0.5
#: Share of the hold-out's squared misfit that a formula has to remove to be added. Not recorded.
MIN_IMPROVEMENT = 0.02
#: Multiples of its estimate that bound a coefficient of a formula. Convention.
COEFFICIENT_BOUND_FACTOR = 10.0

# ------------------------------------------------------------------ the report

#: Share of the largest channel's power from which an effect shows in a channel. Convention.
CHANNEL_SHARE = 0.02
#: Share of the evidence in the stretches of time that are reported. Convention.
REPORTED_EVIDENCE = 0.67
#: Share of an input's range at which the improved tire is evaluated beyond it, and the relative change of a force from
#: which that is called doubtful. Convention.
EXTRAPOLATED_SHARE, MAX_CHANGE = 0.5, 0.15
#: Rows of a cell of a residual map from which its mean is marked. Derived: its error is then a third of the noise.
MIN_ROWS_OF_CELL = 10
