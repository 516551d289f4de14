"""FMUs in jaxonomy: inputs are ports that get constants; its first step ends at 0, and so it makes 1001 of them."""

import json
import sys

import jaxonomy
from fmpy import read_model_description
from jaxonomy import library

tires, kind, outputs = json.loads(sys.argv[1]), sys.argv[2], sys.argv[3].split(",")
builder, blocks = jaxonomy.DiagramBuilder(), {}
for name, (path, inputs) in tires.items():
    given = {"name": name, "output_names": outputs}
    if kind == "ModelExchange":
        blocks[name] = builder.add(library.fmu_import.ModelicaFMUME(path, **given))
    else:
        blocks[name] = builder.add(library.ModelicaFMU(path, dt=0.001, **given))
    for i, variable in enumerate(v for v in read_model_description(path).modelVariables if v.causality == "input"):
        value = inputs.get(variable.name, float(variable.start))
        constant = builder.add(library.Constant(value, name=f"{name}_{variable.name}"))
        builder.connect(constant.output_ports[0], blocks[name].input_ports[i])
diagram = builder.build()
recorded = {f"{t} {key}": blocks[t].output_ports[i] for t in tires for i, key in enumerate(outputs)}
rows = jaxonomy.simulate(diagram, diagram.create_context(), (0.0, 1.0), recorded_signals=recorded).outputs
print(json.dumps({t: {key: float(rows[f"{t} {key}"][-1]) for key in outputs} for t in tires}))
