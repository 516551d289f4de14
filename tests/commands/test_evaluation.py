"""The outputs of a tire over a recording are those of `evaluate`, however many rows are evaluated at a time."""

import pandas as pd

from tirefmu.measurements import evaluation, read_recording
from tirefmu.tires import published


def test_parts_are_the_whole(bench_csv, monkeypatch):
    tire, recording = published("trento_hoosier"), read_recording(bench_csv).with_signs("sae")
    whole = evaluation.evaluate(tire, recording)[["Fx", "Fy", "Mz"]]
    pd.testing.assert_frame_equal(evaluation.predicted_outputs(tire, recording), whole)
    monkeypatch.setattr(evaluation, "ROWS_AT_A_TIME", 77)
    pd.testing.assert_frame_equal(evaluation.predicted_outputs(tire, recording), whole, rtol=1e-12)
