"""Thresholds of the data screening: all numbers for decisions on rows, levels, phases or units of a recording.

Each constant states its unit, its meaning and the reason for its value. "Judgement" means that no study or source
gives the value: it was chosen with a margin and is covered by the tests in ``tests/measurements``, which use virtual
recordings of known content. Limits and tolerances of single channels are in their declarations (`channels.CHANNELS`),
limits on file sizes in the modules that read the files.
"""

from __future__ import annotations

# ---------------------------------------------------------------- segments: `Recording.segments`

#: Median steps of the clock. A longer step ends a segment: between two sweeps a bench stops logging for seconds,
#: whereas a few lost samples belong to the sweep. Judgement.
LOGGING_GAP = 5.0

# ---------------------------------------------------------------- levels: `operating_conditions.levels`

#: Fraction of the largest load: scatter of a held load about its level, caused by the load cell, the non-uniformity
#: of the tire and the control of the load actuator. Judgement; twice the noise of the test recordings (2 %).
LOAD_TOLERANCE = 0.04
#: Fraction of all rows. A density peak with fewer rows is a transition between two levels. Judgement.
MIN_LEVEL_SHARE = 0.01
#: Prominence of a density peak as a fraction of its height. A flatter peak is not a level: within the scatter of an
#: evenly swept input no peak reaches half its height. Judgement.
MIN_LEVEL_PROMINENCE = 0.5
#: Fraction of all rows. If fewer rows are near a level, the input was swept and has no levels. Judgement.
MIN_ROWS_AT_LEVELS = 0.7

# ---------------------------------------------------------------- phases: `operating_conditions.phases`

#: s, window of the median filter on the inputs. It is longer than one wheel revolution (0.13 s at 11 m/s with a radius
#: of 0.23 m), which removes ripple and noise; a median filter preserves the edges of steps.
PHASE_SMOOTHING = 0.2
#: s, window in which the range of an input without levels is compared with `SWEEP_TOLERANCES`. Judgement: the slowest
#: common sweep, 4 deg/s, covers eight tolerances of the slip angle in it.
SWEEP_WINDOW = 1.0
#: Level tolerances. An input that covers a larger range within `SWEEP_WINDOW` is swept: a held one stays within one
#: tolerance on either side of its level.
SWEEP_TOLERANCES = 2.0
#: s. A transition that passes a level in less time does not end there. Judgement.
SHORTEST_STAY = 0.5
#: Rows that an input stays at a level, on average over the rows there. Fewer occur where a sweep of few samples
#: returns to its own steps. Judgement.
MIN_STAY_ROWS = 3
#: s. A slip that takes longer from one level to the next is swept: a bench moves an idle slip faster. Judgement.
LONGEST_TRANSITION = 3.0
#: Level tolerances. A row farther from every level is in transition. Judgement: a held load deviates from its level by
#: more than one tolerance while the slip is swept.
FAR_FROM_LEVELS = 4.0
#: Rows. A shorter segment is not treated as a time series. Judgement.
MIN_SERIES_ROWS = 25
#: s. Rows farther apart are steady points: `SWEEP_WINDOW` must contain at least four rows.
LONGEST_SAMPLE_INTERVAL = SWEEP_WINDOW / 4.0
#: Level tolerances. A larger step from one row to the next is a jump. Noise within one tolerance steps by at most two.
JUMP_TOLERANCES = 3.0
#: Fraction of the steps. Where more are jumps, the rows are steady points: those jump in every other row or more
#: often, a time series only where a condition changes. Judgement.
MAX_JUMPS = 0.1
#: s, sample interval of a recording without a clock: 100 Hz, the rate of FSAE TTC files.
DEFAULT_SAMPLE_INTERVAL = 0.01

# ---------------------------------------------------------------- groups of rows: `operating_conditions.grouping`

#: Median rows per swept range. An operating condition with more rows was repeated or swept slowly and is weighted
#: down. Judgement: counts of equal sweeps scatter by less than a quarter, one repetition doubles them.
OVERSAMPLED = 1.25

# ---------------------------------------------------------------- outliers: `quality.outliers`

#: Robust standard deviations from the running median. Far more than a normal distribution needs (Davies and Gather,
#: 1993, use 3): an excluded value has to be wrong beyond doubt. Judgement.
OUTLIER_SIGMAS = 15.0
#: Standard deviation of a normal distribution over its median absolute deviation, 1/quantile(3/4).
SIGMA_PER_DEVIATION = 1.4826
#: s, window of the running median. It covers 15 rows at 100 Hz, so that 7 consecutive bad values are found. Judgement.
OUTLIER_WINDOW = 0.15
#: Rows, smallest window of the running median: three consecutive bad values do not move it.
MIN_WINDOW_ROWS = 7
#: s, window in which the scatter is estimated: near its limit a tire scatters more than at zero slip. Judgement.
SCATTER_WINDOW = 1.0
#: s. If `MIN_WINDOW_ROWS` span more time, the running median does not follow a sweep and no outlier is sought: at
#: 4 deg/s the slip angle changes by 2 deg in it. Judgement.
LONGEST_MEDIAN_SPAN = 0.5
#: Fraction of the deviation from the running median. With slow sampling a value is an outlier only if it jumps from
#: its neighbors by at least this part of its deviation; a smaller jump is curvature of the signal. Judgement.
MIN_JUMP = 0.7
#: Fraction of the range of the channel (5 to 95 %). A smaller deviation does not affect a fit, and the resolution of a
#: coarse sensor reaches it regularly. Judgement.
MIN_DEVIATION = 0.1

# ---------------------------------------------------------------- excluded rows: `quality.row_exclusion`

#: Fraction of the largest load. At a smaller load the wheel is lifted. Judgement: below the scatter of a held load.
LIFTED_LOAD = 0.02
#: m/s. Below this speed the slips of a wheel are not defined well enough. Judgement.
STANDING_SPEED = 0.5
#: K below the later tread temperature. A recording that starts colder has a warm-up. Judgement: more than the change
#: within and between sweeps.
COLD_START = 15.0
#: K below the later tread temperature. The warm-up ends at the first row that reaches it. Judgement.
WARM_TREAD = 5.0
#: Quantile of the second half of the tread temperatures: the later tread temperature, without the coldest rows.
LATER_TEMPERATURE_QUANTILE = 0.05
#: Fraction of all rows. A warm-up that takes longer is not excluded: the tread never reached a steady temperature.
LONGEST_WARM_UP = 0.5
#: s after a transition until the tire has settled: three relaxation lengths of 0.5 m at 5 m/s.
SETTLING_TIME = 0.3

# ---------------------------------------------------------------- signs and units: `column_meaning`

#: N. If no load is larger, it is taken for kN: the smallest tires known to us run at 60 N and more. Loads of a truck
#: tire in kN (up to 60) are not recognized.
SMALLEST_LOAD = 20.0
#: bar and psi. The median of a pressure that is not in Pa is taken as bar below the first, as psi below the second and
#: as kPa above. Judgement; only the suggestion in the message depends on it.
LARGEST_BAR, LARGEST_PSI = 8.0, 50.0
#: rad. At larger slip angles the pneumatic trail vanishes, and the aligning moment may change its sign. Judgement.
SMALL_ANGLE = 0.05
#: Fraction of the largest slip angle up to which, or up to `SMALL_ANGLE`, the sign of Mz is judged. Judgement.
ALIGNING_SLIP = 0.4
#: Correlation of a slip with its force from which a sign is judged. A sweep reaches 0.8 and more. Judgement.
STRONG_CORRELATION = 0.5
#: Standard deviation of a slip (rad or 1). Less is sensor noise (0.02 deg, 0.002 of slip) rather than a sweep.
MIN_SLIP_DEVIATION = 0.005
#: The same correlation below which a force does not follow a slip. Judgement: noise of some hundred rows is below it.
WEAK_CORRELATION = 0.3
#: kappa up to which a row is taken as free rolling for the sign of Mz: Fx contributes to Mz. Judgement.
SMALL_SLIP = 0.03
#: Fraction of the rows. Larger and smaller forces are limited to the quantile of this fraction before the sign of their
#: change is determined, twice the share of spikes in the tests. Judgement.
SPIKE_QUANTILE = 0.02
#: Rows of a table from which its traits are computed; of more every k-th one.
MAX_SAMPLED_ROWS = 4000
#: Fraction of the largest load. Forces at a smaller load are not divided by it. Judgement.
LIGHT_LOAD = 0.05
#: Fractions of the largest slip at which a force is linear in it, and at which the tire slides. Judgement.
NEAR_SLIP, FAR_SLIP = 0.15, 0.7
#: Rows. A slope over fewer is not computed. Judgement.
MIN_TRAIT_ROWS = 8
#: Standard deviation of the abscissa of a slope over its largest value. Over less, noise makes the slope. Judgement.
MIN_SPREAD = 0.02
#: Change of a force over the load. With more its slip is swept, whatever its unit is. Judgement.
MIN_RESPONSE = 0.3
#: Share of the rows at large slip with either sign of a force, from which the slip lacks its sign. Judgement.
MIN_SIGN_SHARE = 0.1
#: Range of a force over the load. With more its slip was swept, although its column is absent or constant. Judgement.
SWEPT_RESPONSE = 0.8
#: Slip stiffness times largest slip over the largest force. With more the largest force is the friction: a brush model
#: slides at 3. Judgement.
MIN_SATURATION = 2.5
#: rad or 1, range of a slip that is swept: an output that stays the same was not measured. Judgement.
MIN_SWEPT = 0.06
#: Arm of a moment at large slip angles over that at small ones: at most that of a pneumatic trail, at least that of
#: the overturning moment. Judgement.
MAX_FAR_TRAIL, MIN_FAR_ARM = 0.5, 0.7
#: Side force over load at the largest camber and zero slip angle. Less is a shift. Judgement.
MIN_CAMBER_RESPONSE = 0.01

# ---------------------------------------------------------------- coverage: `quality.coverage`, `findings.two_tires`

#: Rows. With fewer, a fit would be misleading: the pure side force alone has a dozen coefficients.
FEW_ROWS = 50
#: Fraction of the clock's steps. If more are negative, the rows are not in the order of time. Judgement.
MAX_BACKWARD_STEPS = 0.1
#: Quantile of the loads of a recording that is taken as its largest load, so that outliers do not matter. Judgement.
LARGEST_LOAD_QUANTILE = 0.95
#: Ratio of the largest loads of two recordings. Above it they are probably of two tires: the test program of one tire
#: has similar largest loads in all files. Judgement.
LARGEST_LOAD_RATIO = 4.0
#: Parts with a clock of their own in one recording. With more, resets of the clock are not joined files. Judgement.
MAX_JOINED_PARTS = 10

# ---------------------------------------------------------------- files without units: `files.ttc_channels`

#: kPa. A median pressure below it is in psi: no tire of the consortium runs below 30 kPa, and none above 30 psi.
LOWEST_KPA = 30.0
#: Fraction of the load. If FX is larger, the wheel was driven or braked: rolling resistance and the component of the
#: side force stay below it. Judgement.
FREE_ROLLING_FORCE = 0.15

# ---------------------------------------------------------------- incomplete rows: `quality.incomplete_rows`

#: Fraction of the rows. Rows without an input are excluded up to this share; with more, the file is refused: what
#: remains is not the test that was run. Judgement.
MAX_INCOMPLETE = 0.2

# ---------------------------------------------------------------- findings: `findings`

#: Fraction of the rows. If more occur twice, the same data were joined or given twice. Judgement: rows of a recording
#: differ by noise, so that almost none are equal by chance.
MAX_REPEATED_ROWS = 0.01
#: Fraction of the rows. If more occur twice, the repetition changes the weights of a fit seriously. Judgement.
SERIOUS_REPEATED_ROWS = 0.2
#: Rows. A shorter stretch of equal rows is chance, or the turning point of a sweep without noise. Judgement.
SHORTEST_REPETITION = 20
#: s, window of the running median of the tread temperature: longer than a sweep, shorter than a warm-up.
TEMPERATURE_WINDOW = 20.0
#: K below the later tread temperature, averaged over sweeps. A recording that starts colder warms up. Judgement: the
#: reference changes by less over the sweeps of a warm tire at equal slip.
COOL_TREAD = 4.0
#: m/s. A median speed above it without a declared unit may be in km/h: common test speeds are 30 to 120 km/h, and few
#: benches run at more than 90 km/h. Judgement.
FAST = 25.0
#: Fraction of the largest slip. Below it a sweep is in progress. Above it the sweep may end or turn. Judgement.
INNER_SLIP = 0.8
#: Relative. Levels in two units have the ratio of the units up to the control of the bench. Judgement.
RATIO_TOLERANCE = 0.02
#: Ratio of the largest friction at equal operating conditions. Above it two tires are probable: pressure, camber and
#: temperature change friction by less than a fifth.
FRICTION_RATIO = 1.3
#: Ratio of loads, and level tolerances of all other held inputs, within which operating conditions are equal.
EQUAL_LOAD_RATIO, EQUAL_TOLERANCES = 1.1, 2.0
#: Largest force of a sweep: quantile of |F/Fz|, so that outliers do not matter. Judgement.
FRICTION_QUANTILE = 0.98
#: Fraction, and standard errors, beyond which the slip stiffness of two recordings differs. Judgement: repeated sweeps
#: of one tire agree within 5 %.
STIFFNESS_DIFFERENCE, DIFFERENCE_ERRORS = 0.05, 3.0
#: rad (0.1 deg). A smaller difference of the slip angle of zero side force is that of the alignment of the wheel.
SHIFT_DIFFERENCE = 0.0017
#: rad, slip angle on either side of zero at which the stiffness between recordings is compared; rad, half width of
#: the rows that are averaged there; |kappa| that counts as free rolling.
COMPARED_ANGLE, COMPARED_WIDTH, FREE_ROLLING_SLIP = 0.02, 0.006, 0.01
#: Rows over which the noise of a force is correlated: a tenth of a second at 100 Hz, about one wheel revolution.
CORRELATED_ROWS = 10
#: Fraction of the mean squared residual. A cause that explains less is not reported. Judgement.
MIN_EXPLAINED = 0.03
#: K. If the tread temperature varies by less (5 to 95 %), its influence cannot be estimated. Judgement.
MIN_TEMPERATURE_RANGE = 3.0
