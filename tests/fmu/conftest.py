"""FMUs of tires of every model in both versions, and a host that calls them one function at a time."""

from __future__ import annotations

import contextlib
import ctypes
import json
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from fmpy.fmi1 import FMICallException

from tirefmu.fmu import export
from tirefmu.fmu.packaging import prebuilt
from tirefmu.fmu.simulation import simulate
from tirefmu.symbolic.models import MODELS
from tirefmu.tires import TABLE_OUTPUTS, Tire, published
from tirefmu.tires.code.compiler import CompilerError, find_compiler

OK, DISCARD, ERROR = 0, 2, 3

#: Tires of the golden coefficients: model, effects in addition to the default ones, effects that they lack, values.
GOLDEN = {
    "mf52": ("mf52", set(), {"turn_slip"}, {}),
    "mf61": ("mf61", set(), set(), {}),
    # Lags by the lengths of the Magic Formula, and by given ones; the lateral one changes with load.
    "mf62": ("mf62", {"relax_mf"}, {"turn_slip"}, {"SIGK": 1.0}),
    "rolling": ("mf61", {"relax_lon", "relax_load"}, set(), {"SIGX": 0.2, "SIGY": 0.5, "SIGC": 0.4}),
}
#: Tires of physical models by their values.
PHYSICAL = {
    "fiala": {"FNOMIN": 4000.0, "UNLOADED_RADIUS": 0.32, "WIDTH": 0.2, "UMAX": 1.0, "UMIN": 0.8, "CSLIP": 6e4,
              "CALPHA": 5e4, "VERTICAL_STIFFNESS": 2e5, "ROLLING_RESISTANCE": 0.01},
    "brush": {"FNOMIN": 1000.0, "UNLOADED_RADIUS": 0.23, "CKAPPA": 1.8e4, "CALPHA": 1.4e4, "MUX": 1.2, "MUY": 1.1,
              "PATCH": 0.05},
}  # fmt: skip
TIRES = ("first", "second", *GOLDEN)
LAGGING = ("mf62", "rolling")
#: Effects with states, and values with which each of them has an influence.
EFFECTS = ("heat_friction", "slip_history", "hysteresis_force", "break_in", "load_lag", "carcass_2nd_order")
VALUES = {
    "FNOMIN": 4000.0, "UNLOADED_RADIUS": 0.3, "SIGX": 0.2, "SIGY": 0.4, "HMU": 0.2, "HTAU": 6.0,
    "SHMUX": 0.05, "SHMUY": 0.05, "SHKX": 0.08, "SHKY": 0.08, "HFPLAY": 0.02,
    "BIMU": 0.1, "BIWORK": 5.0, "LLMU": 0.5, "LLK": 0.5, "LLDIR": 0.5, "CASIG": 0.3, "CAFREQ": 60.0, "CASAT": 4.0,
}  # fmt: skip
HEATED = {
    "FNOMIN": 1500.0, "UNLOADED_RADIUS": 0.25, "SIGX": 0.1, "SIGY": 0.3, "TMU1": -0.002, "TMU2": -2e-5, "TREF": 60.0,
    "THACT": 1.0, "THSTARTS": 295.0, "THSTARTC": 297.0, "THSTARTG": 299.0,
}  # fmt: skip
RELAXATION = {"relax_lat", "relax_lon"}
#: Tires with effects that read a temperature and the distance, with states whose slips lag or act at once, and with
#: temperatures, alone and beside other states: values, effects, and the FMI versions in which they are tested.
STATEFUL = {
    "warm": ({"TMU1": 0.004, "TMU2": -1e-4, "TREF": 60.0, "WMU1": -2e-4}, {"temp_friction", "wear_drift"}, (2, 3)),
    "lagged": (VALUES, {*EFFECTS, *RELAXATION}, (3,)),
    "direct": (VALUES, set(EFFECTS), (2,)),
    "heated": (HEATED, {"temperature", "temp_friction", *RELAXATION}, (3,)),
    "heated more": ({**HEATED, "BIMU": 0.1, "BIWORK": 5.0, "SHMUY": 0.05},
                    {"temperature", "temp_friction", "break_in", "slip_history", *RELAXATION}, (3,)),
}  # fmt: skip


class Host:
    """A host of one instance: every call returns its status, values go by name."""

    def __init__(self, slave):
        self.slave, self.fmu, self.log = slave, slave.fmu, slave.log
        self.version = 3 if slave.version_3 else 2
        self.variables = {variable.name: variable for variable in slave.description.modelVariables}
        self.inputs, shown = (
            [name for name, variable in self.variables.items() if variable.causality == causality]
            for causality in ("input", "output")
        )
        self.outputs = [name for name in shown if name in TABLE_OUTPUTS]
        self.extras = [name for name in shown if name not in TABLE_OUTPUTS]

    def call(self, function, *arguments):
        """Call a function of the standard by its name without prefix."""
        try:
            status = getattr(self.fmu, f"fmi{self.version}{function}")(self.fmu.component, *arguments)
        except FMICallException as error:
            return error.status
        return status

    def references(self, names):
        numbers = [name if isinstance(name, int) else self.variables[name].valueReference for name in names]
        return (ctypes.c_uint * len(numbers))(*numbers)

    def set(self, **values):
        return self.set_references(list(values), list(values.values()))

    def set_references(self, names, values):
        array, n = (ctypes.c_double * len(values))(*values), len(values)
        if self.version == 3:
            return self.call("SetFloat64", self.references(names), len(names), array, n)
        return self.call("SetReal", self.references(names), n, array)

    def get(self, *names):
        return np.array(self.read(names)[1])

    def read(self, names):
        """Return the status and the values."""
        values, n = (ctypes.c_double * len(names))(*[np.nan] * len(names)), len(names)
        if self.version == 3:
            return self.call("GetFloat64", self.references(names), n, values, n), list(values)
        return self.call("GetReal", self.references(names), n, values), list(values)

    def forces(self, **inputs):
        assert self.set(**inputs) == OK
        return self.get(*self.outputs)

    def start(self, time=0.0, stop=None, **values):
        """Initialize with values that are set while initializing."""
        self.initialize(time, stop)
        assert self.set(**values) == OK
        assert self.call("ExitInitializationMode") == OK
        return self

    def initialize(self, time=0.0, stop=None):
        defined, stop = stop is not None, stop or 0.0
        if self.version == 3:
            status = self.call("EnterInitializationMode", False, 0.0, time, defined, stop)
        else:
            status = self.call("SetupExperiment", False, 0.0, time, defined, stop)
            status = status or self.call("EnterInitializationMode")
        assert status == OK

    def step(self, time, size):
        if self.version == 2:
            return self.call("DoStep", time, size, True)
        flags = [ctypes.byref(ctypes.c_bool()) for _ in range(3)]
        return self.call("DoStep", time, size, True, *flags, ctypes.byref(ctypes.c_double()))

    def everything(self):
        """Return the value of every variable."""
        return self.get(*self.variables)

    def save(self):
        state = ctypes.c_void_p()
        assert self.call(self._state("Get"), ctypes.byref(state)) == OK
        return state

    def restore(self, state):
        return self.call(self._state("Set"), state)

    def free(self, state):
        assert self.call(self._state("Free"), ctypes.byref(state)) == OK
        assert state.value is None

    def serialized(self):
        """Return the bytes of the current state."""
        state = self.save()
        content = self.fmu.serializeFMUState(state)
        self.free(state)
        return content

    def deserialize(self, content):
        """Return the status and the state, which is NULL if the bytes are refused."""
        kind, state = (ctypes.c_uint8, ctypes.c_char)[self.version == 2], ctypes.c_void_p()
        buffer = ctypes.cast(ctypes.create_string_buffer(content, len(content) + 1), ctypes.POINTER(kind))
        name = self._state("Deserialize" if self.version == 3 else "DeSerialize")
        return self.call(name, buffer, len(content), ctypes.byref(state)), state

    def _state(self, verb):
        return f"{verb}FMU{'S' if self.version == 3 else 's'}tate"

    def derivative(self, unknowns, knowns, seed):
        a, b = self.references(unknowns), self.references(knowns)
        seeds, slopes = (ctypes.c_double * len(seed))(*seed), (ctypes.c_double * len(unknowns))()
        if self.version == 3:
            sizes = (a, len(a), b, len(b), seeds, len(seeds), slopes, len(slopes))
        else:
            sizes = (a, len(a), b, len(b), seeds, slopes)
        return self.call("GetDirectionalDerivative", *sizes), np.array(slopes)

    def differences(self, unknowns, name, step):
        """Return central differences of unknowns by an input or a parameter, which has its value again afterwards."""
        (middle,), sides = self.get(name), []
        for value in (middle + step, middle - step, middle):
            assert self.set(**{name: value}) == OK
            sides.append(self.get(*unknowns))
        return (sides[0] - sides[1]) / (2.0 * step)


def distance(values, expected):
    """Return the largest |value - expected| / (1 + |expected|)."""
    return np.max(np.abs(values - expected) / (1.0 + np.abs(expected)))


@pytest.fixture(scope="session", autouse=True)
def compiled_here(tmp_path_factory):
    """Tests compile what they test, even where binaries were built beforehand."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(prebuilt, "FOLDER", tmp_path_factory.mktemp("prebuilt"))
        yield


@pytest.fixture(scope="session")
def compiler():
    """Return the command of the C compiler, without which no FMU can be built."""
    try:
        return find_compiler()
    except CompilerError as error:
        pytest.skip(str(error))


@pytest.fixture(scope="session")
def tires(golden):
    """Return tires in ISO signs: the published one, one with other values, those of the tables above.

    Those of `STATEFUL` are made on first use, because their models are printed then.
    """
    first = published("trento_hoosier").in_signs("iso")
    values = {name: 1.07 * value for name, value in first.values.items()}
    second = replace(first, values=values, name='a <wide> & "strange" tire, é')

    class Tires(dict):
        def __missing__(self, name):
            values, effects, _ = STATEFUL[name]
            if name == "warm":
                plain = self["mf61"]
                values, effects = {**plain.values, **values}, (plain.has | effects) - {"turn_slip"}
            self[name] = Tire("mf61", values, effects=effects)
            return self[name]

    others = {name: golden_tire(golden, name, *reported) for name, reported in GOLDEN.items()}
    others |= {name: Tire(name, values, name=name) for name, values in PHYSICAL.items()}
    return Tires(first=first, second=second, **others)


def golden_tire(folder, name, model, more, without, values):
    (path,) = folder.glob(f"{model}_*_params.json")
    reported, symbolic_model = json.loads(path.read_text(encoding="utf-8")), MODELS[model]
    given = {key: value for key, value in reported.items() if key in symbolic_model.coefficients}
    return Tire(model, {**given, **values}, effects=(symbolic_model.default_effects | more) - without, name=name)


@pytest.fixture(scope="session")
def fmus(compiler, tires, tmp_path_factory):
    """Return the paths of FMUs by tire, FMI version and, where they differ from those of `export`, its options.

    The options are the kind of inputs, the axes, and whether quantities are outputs. Each is built on first use.
    """
    folder = tmp_path_factory.mktemp("fmus")

    class Fmus(dict):
        def __missing__(self, key):
            name, fmi, *options = key
            options = dict(zip(("inputs", "axes", "quantities"), options, strict=False))
            self[key] = export(tires[name], folder / f"{'_'.join(map(str, key))}.fmu", fmi=fmi, **options)
            return self[key]

    return Fmus()


@pytest.fixture
def make_host():
    """Return a function that loads an FMU by its path into a new host."""
    with contextlib.ExitStack() as stack:
        yield lambda path: Host(stack.enter_context(simulate.loaded(path)))


@pytest.fixture(scope="session")
def unpacked_once(fmus, tmp_path_factory):
    """Return a function that returns the folder of an FMU of `fmus`, unpacked on first use."""
    folder = tmp_path_factory.mktemp("unpacked")
    with contextlib.ExitStack() as stack:

        @cache
        def unpack(path):
            with pytest.MonkeyPatch.context() as patch:
                patch.setattr("tempfile.tempdir", str(folder))
                return stack.enter_context(simulate.unpacked(path))

        yield unpack


@pytest.fixture
def hosts(fmus, make_host, unpacked_once):
    """Return a function that loads an FMU of `fmus` into a new host."""

    def host(*key):
        folder = unpacked_once(fmus[key])
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(simulate, "unpacked", lambda _: contextlib.nullcontext(folder))
            return make_host(fmus[key])

    return host


@pytest.fixture
def wheels(hosts):
    """Return a function that loads an FMU with wheel inputs into a new host."""
    return lambda name, fmi=3: hosts(name, fmi, "wheel")


@pytest.fixture(params=TIRES)
def name(request):
    """Name each tire."""
    return request.param


@pytest.fixture(params=LAGGING)
def lagging(request):
    """Name each tire whose slips lag."""
    return request.param


@pytest.fixture(params=[2, 3], ids=["fmi2", "fmi3"])
def fmi(request):
    return request.param


@pytest.fixture
def host(hosts, fmi):
    """Return a host of the first tire, instantiated."""
    return hosts("first", fmi)


@pytest.fixture
def running(host):
    """Return a host of the first tire, initialized."""
    return host.start()


@pytest.fixture
def temporary(tmp_path, monkeypatch):
    """Return the folder of temporary files; it is empty in the end."""
    folder = tmp_path / "temporary"
    folder.mkdir()
    monkeypatch.setattr("tempfile.tempdir", str(folder))
    yield folder
    assert list(folder.iterdir()) == []
