"""Files of jobs and folders of recordings."""

from __future__ import annotations

import pytest

from tirefmu.applications.batch import read_jobs
from tirefmu.boundary.errors import TirefmuError

JOB = '[[jobs]]\nname = "front"\ntables = ["a.csv"]\n'


def test_defaults_apply_unless_a_job_has_its_own(tmp_path):
    (tmp_path / "start.tir").touch()
    (tmp_path / "jobs.toml").write_text(
        '[defaults]\nmodel = "mf96"\nsigns = "sae"\nnominal = {Fz0 = 700, R0 = 0.23}\n'
        + JOB + '[[jobs]]\nname = "rear"\ntables = ["b.csv", "c.csv"]\nmodel = "mf61"\nwhere = "t > 5"\n'
        + 'start = "start.tir"\nrecipe = "joint"\n'
    )  # fmt: skip
    front, rear = read_jobs(tmp_path / "jobs.toml")
    assert (front.name, front.signs, front.where) == ("front", "sae", None)
    assert front.options == {"model": "mf96", "nominal": {"Fz0": 700, "R0": 0.23}}
    assert rear.tables == (tmp_path / "b.csv", tmp_path / "c.csv")
    assert (rear.options["model"], rear.signs, rear.where) == ("mf61", "sae", "t > 5")
    assert rear.options["start"] == str(tmp_path / "start.tir")
    assert rear.options["recipe"] == "joint"


def test_each_recording_of_a_folder_is_a_job(tmp_path):
    for name in ("soft.csv", "hard.parquet", "notes.txt"):
        (tmp_path / name).touch()
    jobs = read_jobs(tmp_path, {"model": "mf52", "signs": "sae"})
    assert [job.name for job in jobs] == ["hard", "soft"]
    assert all(job.options == {"model": "mf52"} and job.signs == "sae" for job in jobs)
    with pytest.raises(TirefmuError, match="options: unknown key 'modle': did you mean model"):
        read_jobs(tmp_path, {"modle": "mf52"})


@pytest.mark.parametrize(("text", "message"), [
    ("", "jobs is missing"),
    ("jobs = 3", "jobs is 3: expected a list"),
    ("jobs = [3]", r"jobs\[1\] is 3: expected a table"),
    (JOB.replace("name", "nam"), r"unknown key 'nam' in jobs\[1\]: did you mean name"),
    (JOB.replace('tables = ["a.csv"]', ""), r"tables is missing in jobs\[1\]"),
    (JOB.replace('["a.csv"]', "[3]"), r"jobs\[1\]\.tables\[1\] is 3: expected a text"),
    (JOB.replace("front", "../front"), "of a job is not a file name"),
    (JOB + JOB.replace("front", "Front"), "two jobs have the name 'Front'"),
    (JOB + "iterations = true", "iterations is true: expected a whole number"),
    (JOB + "nominal = {Fz0 = nan}", "nominal.Fz0 is nan: expected a number"),
    ("[defaults]\nmodle = 'mf61'\n" + JOB, "unknown key 'modle' in defaults: did you mean model"),
    ("[defaults", "jobs.toml: "),
])  # fmt: skip
def test_an_invalid_file_is_one_line(tmp_path, text, message):
    (tmp_path / "jobs.toml").write_text(text)
    with pytest.raises(TirefmuError, match=message):
        read_jobs(tmp_path / "jobs.toml")


def test_options_belong_to_a_folder(tmp_path):
    (tmp_path / "jobs.toml").write_text(JOB)
    with pytest.raises(TirefmuError, match=r"\[defaults\] in the file sets model"):
        read_jobs(tmp_path / "jobs.toml", {"model": "mf61"})
    with pytest.raises(TirefmuError, match="no recording"):
        read_jobs(tmp_path)
