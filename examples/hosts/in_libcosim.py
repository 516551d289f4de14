"""FMUs in libcosim, which reads FMI 2: steps are whole nanoseconds."""

import json
import sys

from libcosimpy.CosimExecution import CosimExecution
from libcosimpy.CosimObserver import CosimObserver
from libcosimpy.CosimSlave import CosimLocalSlave

tires, outputs = json.loads(sys.argv[1]), sys.argv[3].split(",")
execution, observer = CosimExecution.from_step_size(1_000_000), CosimObserver.create_last_value()
execution.add_observer(observer)
slaves = {name: execution.add_local_slave(CosimLocalSlave(path, name)) for name, (path, _) in tires.items()}
references = {name: {v.name.decode(): v.reference for v in execution.slave_variables(slaves[name])} for name in tires}
for tire, (_, inputs) in tires.items():
    for name, value in inputs.items():
        execution.real_initial_value(slaves[tire], references[tire][name], value)
execution.step(1000)
found = {}
for tire in tires:
    values = observer.last_real_values(slaves[tire], [references[tire][name] for name in outputs])
    found[tire] = dict(zip(outputs, values, strict=True))
print(json.dumps(found))
