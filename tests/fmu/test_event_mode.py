"""Event mode and early return of Co-Simulation in FMI 3: the brake of a spinning wheel locks and releases in a step."""

from __future__ import annotations

import zipfile

import fmpy
import pytest
from fmpy.fmi1 import FMICallException
from fmpy.fmi3 import FMU3Slave

FIXED = {"v_x": 8.0, "WHEEL_INERTIA": 0.8, "omega": 33.0}
STEP = 0.02


class Wheel:
    """A wheel on a carrier that moves straight on."""

    def __init__(self, path, folder, **used):
        with zipfile.ZipFile(path) as archive:
            archive.extractall(folder)
        self.description, self.log = fmpy.read_model_description(str(path)), []
        self.references = {v.name: v.valueReference for v in self.description.modelVariables}
        identifier = self.description.coSimulation.modelIdentifier
        self.fmu = FMU3Slave(guid=self.description.guid, unzipDirectory=str(folder), modelIdentifier=identifier,
                             instanceName="wheel")  # fmt: skip
        self.fmu.instantiate(logMessage=lambda _environment, _status, _category, line: self.log.append(line), **used)
        self.now, self.events, self.early = 0.0, [], 0

    def set(self, **values):
        self.fmu.setFloat64([self.references[name] for name in values], list(values.values()))

    def get(self, *names):
        return self.fmu.getFloat64([self.references[name] for name in names])

    def start(self, **values):
        self.set(**FIXED | values)
        self.fmu.enterInitializationMode()
        self.fmu.exitInitializationMode()
        return self

    def handle(self):
        self.fmu.enterEventMode()
        assert self.fmu.updateDiscreteStates() == (False, False, False, False, False, 0.0)
        self.fmu.enterStepMode()

    def run(self, steps):
        """Return where each step ended, from communication point to communication point."""
        for _ in range(steps):
            end = round(self.now / STEP + 1.0) * STEP
            while self.now < end - 1e-9:
                event, stop, early, self.now = self.fmu.doStep(self.now, end - self.now)
                assert not stop
                assert early == (self.now < end - 1e-9)
                self.early += early
                if event:
                    self.events.append(self.now)
                    self.handle()
        return self


@pytest.fixture
def make(fmus, tmp_path):
    made = []

    def wheel(inputs="hub-torque", **used):
        made.append(Wheel(fmus["first", 3, inputs], tmp_path / str(len(made)), **used))
        return made[-1]

    yield wheel
    for instance in made:
        instance.fmu.freeInstance()


def test_a_step_ends_where_the_brake_locks(make):
    wheel = make(eventModeUsed=True, earlyReturnAllowed=True).start(T_brake=300.0)
    with pytest.raises(FMICallException):  # a run begins in event mode
        wheel.fmu.doStep(0.0, STEP)
    assert wheel.fmu.updateDiscreteStates()[0] is False
    wheel.fmu.enterStepMode()
    wheel.run(20)
    assert len(wheel.events) == wheel.early == 1
    assert wheel.get("omega", "der(omega)") == [0.0, 0.0]


def test_a_step_ends_where_a_brake_slips(make):
    wheel = make(eventModeUsed=True, earlyReturnAllowed=True).start(v_x=0.0, omega=0.0, T_brake=30.0)
    wheel.fmu.enterStepMode()
    wheel.run(5)
    assert (wheel.events, wheel.get("omega")) == ([], [0.0])
    wheel.set(v_x=0.1)
    wheel.run(20)
    assert len(wheel.events) == wheel.early == 1
    assert wheel.events == [pytest.approx(5 * STEP + 1e-3)]
    assert wheel.get("omega")[0] > 0.0
    assert wheel.get("brake_torque") == pytest.approx([-30.0], rel=1e-12)


def test_the_result_is_that_of_steps_without_events(make):
    alone = make().start(T_brake=300.0)
    alone.run(20)
    assert (alone.events, alone.early) == ([], 0)
    wheel = make(eventModeUsed=True, earlyReturnAllowed=True).start(T_brake=300.0)
    wheel.fmu.enterStepMode()
    wheel.run(20)
    names = ("omega", "Fx", "M_y", "kappa_lagged")
    assert wheel.get(*names) == pytest.approx(alone.get(*names), rel=1e-12, abs=1e-12)


def test_without_early_return_the_event_is_reported_at_the_end_of_the_step(make):
    wheel = make(eventModeUsed=True).start(T_brake=300.0)
    wheel.fmu.enterStepMode()
    wheel.run(20)
    assert wheel.early == 0
    assert wheel.events == [pytest.approx(STEP * round(wheel.events[0] / STEP))]
    other = make(earlyReturnAllowed=True).start(T_brake=300.0)
    other.run(20)
    assert (other.events, other.early) == ([], 1)
    with pytest.raises(FMICallException):
        other.fmu.enterEventMode()


def test_where_nothing_can_happen_there_is_no_event_mode(make, fmus):
    described = {
        inputs: zipfile.ZipFile(fmus["first", 3, inputs]).read("modelDescription.xml")
        for inputs in ("hub", "hub-torque")
    }
    assert b'hasEventMode="true"' in described["hub-torque"]
    assert b"hasEventMode" not in described["hub"]
    with pytest.raises(Exception, match=r"[Ii]nstantiate"):
        make("hub", eventModeUsed=True)
