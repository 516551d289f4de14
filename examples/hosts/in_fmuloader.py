"""FMUs in fmuloader: the C interface, call by call; it reads no model description, so that fmpy's is used."""

import json
import sys

from fmpy import read_model_description
from fmuloader.fmi2 import Fmi2Slave, Fmi2Type
from fmuloader.fmi3 import Fmi3Slave

tires, outputs = json.loads(sys.argv[1]), sys.argv[3].split(",")
slaves, references, found = {}, {}, {}
for name, (path, inputs) in tires.items():
    about = read_model_description(path)
    newer = about.fmiVersion.startswith("3")
    references[name] = {variable.name: variable.valueReference for variable in about.modelVariables}
    slaves[name] = (Fmi3Slave if newer else Fmi2Slave)(path, model_identifier=about.coSimulation.modelIdentifier)
    if newer:
        slaves[name].instantiate_co_simulation(name, instantiation_token=about.guid)
    else:
        slaves[name].instantiate(name, Fmi2Type.CO_SIMULATION, guid=about.guid)
        slaves[name].setup_experiment()
    slaves[name].enter_initialization_mode()
    slaves[name].exit_initialization_mode()
    set_values = slaves[name].set_float64 if newer else slaves[name].set_real
    set_values([references[name][key] for key in inputs], list(inputs.values()))
for step in range(1000):
    for slave in slaves.values():
        slave.do_step(step * 0.001, 0.001)
for name, slave in slaves.items():
    get_values = slave.get_float64 if newer else slave.get_real
    values = get_values([references[name][key] for key in outputs])
    found[name] = dict(zip(outputs, values, strict=True))
print(json.dumps(found))
