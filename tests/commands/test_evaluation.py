"""The outputs of a tire over a recording are those of `evaluate`."""

import pandas as pd

from tirefmu.measurements import evaluation, read_recording
from tirefmu.tires import published


def test_predicted_outputs_are_those_of_the_evaluation(bench_csv):
    tire, recording = published("trento_hoosier"), read_recording(bench_csv).with_signs("sae")
    whole = evaluation.evaluate(tire, recording)[["Fx", "Fy", "Mz"]]
    pd.testing.assert_frame_equal(evaluation.predicted_outputs(tire, recording), whole)
    pd.testing.assert_frame_equal(
        evaluation.evaluate(tire, bench_csv)[["Fx"]], evaluation.evaluate(tire, recording)[["Fx"]]
    )
