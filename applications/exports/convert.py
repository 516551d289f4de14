"""A tire as a property file that another program accepts, with another model's coefficients where necessary."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import product
from pathlib import Path

import numpy as np
import pandas as pd

from ...boundary.errors import TirefmuError
from ...boundary.escaping import visible
from ...boundary.named_options import named
from ...fitting import fit
from ...measurements import CHANNELS
from ...symbolic.models import MODELS
from ...tires import Tire, TireLike, tire_from, write_tir
from ...tires.definition import RANGES
from .dialects import Host
from .lacking import acting, lacked, nearest
from .lint import LintMessage, host_messages, host_named, lost_effects

#: Typical dimensions where a model has none, as shares of the unloaded radius; hosts draw the tire and do not compute
#: forces with them.
SHAPE = {"WIDTH": 0.65, "RIM_RADIUS": 0.65, "ASPECT_RATIO": 0.55}
#: Relative error of the forces up to which an effect does not change them.
UNCHANGED = 1e-4
#: Error of a force, as a share of it, from which a file does not describe the tire. Convention.
POOR = 0.5
#: Kinds of physical constraints that a tire of another model may violate.
NOT_ENFORCED = ("curvature", "friction_falling")
#: Key and value that several hosts require and that a file may lack.
GENERAL = {"LONGVL": 16.7, "VXLOW": 1.0}


#: What is written if a tire does not state its side: hosts require it.
ASSUMED_SIDE = "left"


@dataclass(frozen=True, repr=False)
class Conversion:
    """A written property file.

    - `tire`: what the file contains.
    - `refitted`: whether coefficients were fitted to the tire's forces: of another model, without those that the host
      lacks, or because added effects change the forces at nominal conditions, where their states are in equilibrium.
    - `errors`: root mean square of the difference of each force or moment from the tire, relative to the root mean
      square of the tire's, over its range, also of the inputs of added effects; empty if the file is the same tire.
    """

    path: Path
    tire: Tire
    model: str
    refitted: bool
    errors: Mapping[str, float]
    findings: list[LintMessage]

    def __repr__(self) -> str:
        """Return file, model, errors and findings, a line each."""
        lines = [f"{self.path}: {self.model}"]
        if self.errors:
            errors = ", ".join(f"{name} {error:.2%}" for name, error in self.errors.items())
            lines.append(f"coefficients fitted to the tire's forces; RMS error over its range: {errors}")
        return "\n  ".join(visible(line) for line in [*lines, *map(str, self.findings)])


@named()
def convert(tire: TireLike, path: str | Path, host: str, model: str | None = None) -> Conversion:
    """Write a tire as a property file for another program.

    The coefficients of another model than the tire's are fitted to its forces, and so are those of its own model if it
    has coefficients that the host's model lacks, or added effects that change the forces at nominal conditions.

    Parameters
    ----------
    tire : Tire, path of a .tir file, or name of a published tire
        In any signs.
    path : str or Path
        The file to write.
    host : str
        One of `tirefmu.applications.exports.dialects.HOSTS`.
    model : str, optional
        One of the models that the host has; default: that of the tire if the host has it, else the host's first.

    Returns
    -------
    Conversion
        What the file contains, its errors, and what the host does not evaluate.

    Raises
    ------
    UnknownName
        If there is no such host.
    TirefmuError
        If the host has no such model, or the file cannot be written.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     written = convert("trento_hoosier", Path(folder, "hoosier.tir"), "mfeval", "mf52")
    ...     written.model, written.refitted
    ('mf52', True)
    """
    rules, whole = host_named(host), tire_from(tire).in_signs("iso")
    chosen = model or (whole.model if whole.model in rules.dialects else next(iter(rules.dialects)))
    if chosen not in rules.dialects:
        raise TirefmuError(f"{rules.title} has no {chosen}: choose from {', '.join(rules.dialects)}")
    lacking = lacked(rules, chosen)
    plain = without_added(whole)
    table = _operating_range(whole)
    forces = whole.evaluate(table, steady=True)
    folded = {name for name in whole.has - plain.has if _changes(name, whole, table, forces)}
    converted = plain if chosen == plain.model else _of_model(plain, chosen, table, forces)
    if acting(converted, lacking) or (folded and chosen == plain.model):
        evaluated = converted.evaluate(table, steady=True)  # outputs that the tire does not have stay as they are
        target = np.stack([forces.get(name, evaluated[name]) for name in converted.outputs])
        converted = nearest(converted, target, lacking, table)
    refitted = converted is not plain
    errors: Mapping[str, float] = {}
    if refitted or whole is not plain:
        wide = _over_all_inputs(table, whole)
        errors = relative_errors(converted, wide, whole.evaluate(wide, steady=True))
    written = _for_host(converted if refitted else whole, rules, chosen)
    write_tir(written, path, line_end="\r\n" if rules.expects_crlf else "\n")
    findings = host_messages(path, host)
    stated = {finding.text for finding in findings}
    lost = [*lost_effects(whole, rules, folded), *_lost_relaxation(whole, written)]
    if not whole.side:
        lost.append(f"the side of the tire is not stated: TYRESIDE = '{ASSUMED_SIDE.upper()}' is written")
    findings += [LintMessage("note", 0, text) for text in lost if text not in stated]
    findings += [
        LintMessage("error", 0, f"{name} of the file differs by {error:.0%} from the tire: {chosen} cannot describe it")
        for name, error in errors.items()
        if error > POOR
    ]
    return Conversion(Path(path), written, chosen, refitted, errors, findings)


def without_added(tire: Tire) -> Tire:
    """Return a tire without its added effects and their coefficients: the tire itself if it has none."""
    added = {effect.name for effect in tire.symbolic_model.added}
    if not added:
        return tire
    declared = MODELS[tire.model].coefficients
    values = {name: value for name, value in tire.values.items() if name in declared and name not in tire.defaulted}
    return replace(tire, values=values, effects=tire.has - added, added=())


def _for_host(tire: Tire, rules: Host, model: str) -> Tire:
    """Return a tire whose file has the entries that the host expects."""
    entries = dict(rules.dialects[model].entries)
    side = f"'{(tire.side or ASSUMED_SIDE).upper()}'"
    entries["TYRESIDE"] = side
    values = {name: value for name, value in tire.values.items() if name not in tire.defaulted}
    declared = tire.symbolic_model.coefficients
    values |= {key: value for key, value in GENERAL.items() if key in declared and not values.get(key)}
    shape = {key: share * tire.values["UNLOADED_RADIUS"] for key, share in SHAPE.items()}
    values |= {key: value for key, value in shape.items() if key in declared and not values.get(key)}
    foreign = {title for title, key, _ in tire.other_entries if rules.tables and not key and title not in rules.tables}
    kept = tuple(entry for entry in tire.other_entries if entry[1] not in entries and entry[0] not in foreign)
    present = {key for _, key, _ in kept} | set(declared)
    shape_lines = [("DIMENSION", key, repr(value)) for key, value in shape.items() if key not in present]
    general = [("MODEL", key, repr(value)) for key, value in GENERAL.items() if key not in present]
    lines = [("MODEL", key, value) for key, value in entries.items()]
    ranges = {name: (low, high) for name, (low, high) in tire.ranges.items() if low < high}  # programs refuse a point
    for key in [key for name in tire.ranges.keys() - ranges.keys() for key in RANGES.get(name, ())]:
        values.pop(key, None)
    return replace(tire, values=values, other_entries=(*kept, *lines, *general, *shape_lines), ranges=ranges)


def _changes(name: str, tire: Tire, table: pd.DataFrame, forces: pd.DataFrame) -> bool:
    """Return whether an effect of a tire changes its forces at nominal conditions."""
    without = replace(tire, effects=tire.has - {name})
    return max(relative_errors(without, table, forces).values()) > UNCHANGED


def _lost_relaxation(tire: Tire, written: Tire) -> list[str]:
    lost = (
        tire.has
        & tire.symbolic_model.relaxing_effects - {effect.name for effect in tire.symbolic_model.added} - written.has
    )
    return [f"{name} is not converted: the file has no relaxation lengths of it" for name in sorted(lost)]


def relative_errors(tire: Tire, table: pd.DataFrame, forces: pd.DataFrame) -> dict[str, float]:
    """Return the root mean square difference of each output from given forces, relative to that of the force."""
    computed = tire.evaluate(table, steady=True)
    errors = {}
    for name in [name for name in tire.outputs if name in forces]:
        size = float(np.sqrt(np.mean(forces[name] ** 2)))
        errors[name] = float(np.sqrt(np.mean((computed[name] - forces[name]) ** 2))) / size if size else 0.0
    return errors


def _of_model(plain: Tire, model: str, table: pd.DataFrame, truth: pd.DataFrame) -> Tire:
    """Fit another model to the forces of a tire.

    Only the physical constraints on signs are enforced. The tire itself may violate the others (E_t of the Trento tire
    is above 1); the fit would then not converge.
    """
    declared = MODELS[model].coefficients
    common = {name: value for name, value in plain.values.items() if name in declared and name not in plain.defaulted}
    common |= {key: plain.values[key] for key in ("FNOMIN", "UNLOADED_RADIUS")}
    start = Tire(model, common)
    made = [name for name in start.outputs if name in truth and truth[name].any()]  # a tire may make no Mz at all
    measured = truth[[*table, *made]]
    fitted = fit(
        measured, model, start=start, recipe="joint", screening=False, rows="equal", effects=start.has,
        without_constraints=NOT_ENFORCED,
    )  # fmt: skip
    return replace(fitted.tire.in_signs("iso"), name=plain.name, side=plain.side, ranges=plain.ranges)


def _over_all_inputs(table: pd.DataFrame, tire: Tire) -> pd.DataFrame:
    """Return the rows, and those at the ends of the range of each further input: temperature, pressure, speed."""
    ends = [
        table.assign(**{name: end})
        for name in tire.inputs if name in CHANNELS and name in tire.ranges and name not in table
        for end in tire.ranges[name]
    ]  # fmt: skip
    rows = pd.concat([table, *ends], ignore_index=True)
    return rows.fillna({name: tire.nominal(name) for name in tire.inputs if name in rows})


def _operating_range(tire: Tire) -> pd.DataFrame:
    """Return pure and combined slip at several loads and inclinations within the tire's range."""
    low, high = tire.ranges.get("Fz", (0.3 * tire.values["FNOMIN"], 1.6 * tire.values["FNOMIN"]))
    loads = np.linspace(max(low, 0.2 * high), high, 4)
    kappa_low, kappa_high = tire.ranges.get("kappa", (-0.3, 0.3))
    alpha_low, alpha_high = tire.ranges.get("alpha", (-0.25, 0.25))
    gammas = np.linspace(*tire.ranges.get("gamma", (-0.07, 0.07)), 3)
    kappas = np.linspace(max(kappa_low, -0.3), min(kappa_high, 0.3), 15)
    alphas = np.linspace(max(alpha_low, -0.3), min(alpha_high, 0.3), 15)
    rows = [(0.0, alpha, gamma, load) for alpha, gamma, load in product(alphas, gammas, loads)]
    rows += list(product(kappas, (-0.1, 0.0, 0.1), gammas, loads))
    return pd.DataFrame(rows, columns=["kappa", "alpha", "gamma", "Fz"])
