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


def test_slips_of_a_file_that_are_probably_in_percent_have_a_warning(command, published_tir, tmp_path):
    (tmp_path / "slips.csv").write_text("kappa,Fz\n0,900\n2,900\n5,900\n8,900\n", encoding="utf-8")
    done = command("evaluate", published_tir, tmp_path / "slips.csv", "-o", tmp_path / "forces.csv")
    assert done.status == 0
    assert "warning: kappa from 0 to 8 is that of a wheel that spins: it is a fraction (in percent?" in done.text
    assert "UserWarning" not in done.err
