"""An FMU in libcosim, which reads FMI 2: steps are whole nanoseconds."""

import json
import sys

from libcosimpy.CosimExecution import CosimExecution
from libcosimpy.CosimObserver import CosimObserver
from libcosimpy.CosimSlave import CosimLocalSlave

path, inputs, outputs = sys.argv[1], json.loads(sys.argv[3]), sys.argv[4].split(",")
execution, observer = CosimExecution.from_step_size(1_000_000), CosimObserver.create_last_value()
execution.add_observer(observer)
tire = execution.add_local_slave(CosimLocalSlave(path, "tire"))
references = {variable.name.decode(): variable.reference for variable in execution.slave_variables(tire)}
for name, value in inputs.items():
    execution.real_initial_value(tire, references[name], value)
execution.step(1000)
print(json.dumps(dict(zip(outputs, observer.last_real_values(tire, [references[n] for n in outputs]), strict=True))))
