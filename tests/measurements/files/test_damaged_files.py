"""Bench files with bytes changed, lost or doubled are read or refused with one line, never with a traceback."""

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from scipy.io import savemat

from tirefmu.boundary.errors import TirefmuError
from tirefmu.measurements import INPUTS, check_plausible, coverage_notes, exclude_rows, read_recording

DAT = b"""Tire_Name=Somebody's 16x7.5-10\tISO False
ET\tV\tSA\tIA\tP\tFX\tFY\tFZ\tMX\tMZ\tTSTC\tSL
sec\tkph\tdeg\tdeg\tkPa\tN\tN\tN\tN-m\tN-m\tdeg C\tnone
0.00\t40.2\t0.01\t0.00\t83.1\t-12.5\t-31.2\t-903.1\t5.1\t0.71\t58.8\t0.000
0.01\t40.2\t0.05\t0.00\t83.1\t-12.1\t-52.8\t-901.6\t5.0\t0.82\t58.8\t0.000
0.02\t40.2\t0.09\t0.00\t83.2\t-12.9\t-74.0\t-899.4\t5.3\t0.97\t58.9\t0.001
"""
TDX = b"""**HEADER
RELEASE   1.3
**CONSTANTS
INFLPRES  inflation pressure   bar  2.5
**MEASURCHANNELS
LONGSLIP  longitudinal slip    %    0.1  0  0
SLIPANGL  slip angle           deg  1    0  0
FZW       vertical force       kN   1    0  0
FYW       side force           N    1    0  0
**MEASURDATA
0 1.5 3.01 -1100
1 2.5 3.02 -1800
**END
"""


DAMAGE = st.tuples(
    st.floats(0.0, 1.0),
    st.sampled_from(["lost", "changed", "doubled", "cut"]),
    st.sampled_from([b"\t", b"\n", b"nan", b"-", b"*", b"\xff", b"1e400", b"\0", b"9", b"FZ", b""]),
)


def refused(path):
    """Read a file as far as a fit would; return the line that refuses it, or None where it was read."""
    try:
        recording = read_recording(path)
        check_plausible(recording)
        coverage_notes(recording)
        included = exclude_rows(recording).included
    except TirefmuError as error:
        return str(error)
    assert len(included) == len(recording) > 0
    present = [name for name in INPUTS if name in recording.table]
    assert np.isfinite(recording.table[present].to_numpy()).all()
    return None


@pytest.mark.parametrize(("kind", "content"), [(".dat", DAT), (".tdx", TDX)])
@settings(max_examples=50, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(damage=st.lists(DAMAGE, min_size=1, max_size=4))
def test_damaged_text(tmp_path, kind, content, damage):
    for position, what, other in damage:
        at = int(position * len(content))
        content = {
            "lost": content[:at] + content[at + 3 :],
            "changed": content[:at] + other + content[at + max(1, len(other)) :],
            "doubled": content[:at] + content[max(0, at - 30) : at] + content[at:],
            "cut": content[:at],
        }[what]
    path = tmp_path / f"run{kind}"
    path.write_bytes(content)
    message = refused(path)
    assert message is None or ("\n" not in message and f"run{kind}: " in message)


def test_matlab_files_cut_short(tmp_path):
    path = tmp_path / "run.mat"
    numbers = {name: np.linspace(1.0, 2.0, 5)[:, None] for name in ("ET", "SA", "IA", "FY", "SL")}
    savemat(path, {**numbers, "FZ": np.full((5, 1), -900.0)})
    content = path.read_bytes()
    for share in np.linspace(0.0, 0.99, 12):
        path.write_bytes(content[: int(share * len(content))])
        message = refused(path) or ""
        assert "\n" not in message
        assert "run.mat: " in message


def test_the_whole_files_are_read(tmp_path):
    for kind, content in ((".dat", DAT), (".tdx", TDX)):
        (tmp_path / f"run{kind}").write_bytes(content)
        assert refused(tmp_path / f"run{kind}") is None
