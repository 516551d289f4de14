"""Files for the hosting service are valid: workflows, issue forms, citation; what workflows run exists."""

from __future__ import annotations

import re
import subprocess
import sys

import pytest

from .rooms import ROOT, TARGETS

WORKFLOWS = sorted((ROOT / ".github" / "workflows").glob("*.yml"))
#: Schemas that come with check-jsonschema.
SCHEMAS = {
    "vendor.github-workflows": WORKFLOWS,
    "custom.github-workflows-require-timeout": WORKFLOWS,
    "vendor.github-issue-forms": sorted((ROOT / ".github" / "ISSUE_TEMPLATE").glob("*.yml")),
    "vendor.citation-file-format": [ROOT / "CITATION.cff"],
}


def checked(schema, *files):
    """Return exit code and output of check-jsonschema."""
    pytest.importorskip("check_jsonschema", reason="check-jsonschema is not installed (extra dev)")
    command = [sys.executable, "-m", "check_jsonschema", "--builtin-schema", schema, *map(str, files)]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    return done.returncode, done.stdout + done.stderr


@pytest.mark.parametrize("schema", SCHEMAS)
def test_files_are_valid(schema):
    assert SCHEMAS[schema]
    status, output = checked(schema, *SCHEMAS[schema])
    assert status == 0, output


def test_an_invalid_workflow_is_refused(tmp_path):
    text = WORKFLOWS[0].read_text(encoding="utf-8")
    wrong = tmp_path / "wrong.yml"
    wrong.write_text(text.replace("runs-on:", "runs_on:", 1), encoding="utf-8")
    assert wrong.read_text(encoding="utf-8") != text
    assert checked("vendor.github-workflows", wrong)[0] == 1


def test_what_workflows_run_exists():
    text = "".join(path.read_text(encoding="utf-8") for path in WORKFLOWS)
    used = set(re.findall(r"- run: make ([a-z-]+)", text))
    assert used
    assert used <= TARGETS
    floor = re.search(r'requires-python = ">=([\d.]+)"', (ROOT / "pyproject.toml").read_text(encoding="utf-8"))[1]
    versions = re.findall(r'"(3\.\d+)"', text)
    assert floor in versions
    assert all(int(version.split(".")[1]) >= int(floor.split(".")[1]) for version in versions)
