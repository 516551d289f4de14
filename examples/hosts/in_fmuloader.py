"""An FMU in fmuloader: the C interface, call by call; it reads no model description, so that fmpy's is used."""

import json
import sys

from fmpy import read_model_description
from fmuloader.fmi2 import Fmi2Slave, Fmi2Type
from fmuloader.fmi3 import Fmi3Slave

path, inputs, outputs = sys.argv[1], json.loads(sys.argv[3]), sys.argv[4].split(",")
about = read_model_description(path)
references = {variable.name: variable.valueReference for variable in about.modelVariables}
newer = about.fmiVersion.startswith("3")
tire = (Fmi3Slave if newer else Fmi2Slave)(path, model_identifier=about.coSimulation.modelIdentifier)
if newer:
    tire.instantiate_co_simulation("tire", instantiation_token=about.guid)
else:
    tire.instantiate("tire", Fmi2Type.CO_SIMULATION, guid=about.guid)
    tire.setup_experiment()
tire.enter_initialization_mode()
tire.exit_initialization_mode()
(tire.set_float64 if newer else tire.set_real)([references[name] for name in inputs], list(inputs.values()))
for step in range(1000):
    tire.do_step(step * 0.001, 0.001)
values = (tire.get_float64 if newer else tire.get_real)([references[name] for name in outputs])
print(json.dumps(dict(zip(outputs, values, strict=True))))
