"""A tire as a property file that another program accepts, with another model's coefficients where necessary."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace
from itertools import product
from pathlib import Path

import numpy as np
import pandas as pd

from tirefmu.fitting import fit
from tirefmu.symbolic.errors import TirefmuError
from tirefmu.symbolic.models import MODELS
from tirefmu.tires import Tire, TireLike, tire_from, write_tir

from .dialects import Host
from .lacking import acting, without
from .lint import Finding, host_named, lint, lost_effects

#: Typical dimensions where a model has none, as shares of the unloaded radius; hosts draw the tire and do not compute
#: forces with them.
SHAPE = {"WIDTH": 0.65, "RIM_RADIUS": 0.65, "ASPECT_RATIO": 0.55}
#: Kinds of physical constraints that a tire of another model may violate.
NOT_ENFORCED = ("curvature", "friction_falling")
#: Key and value that several hosts insist on and that a file may lack.
GENERAL = {"LONGVL": 16.7, "VXLOW": 1.0}


@dataclass(frozen=True)
class Conversion:
    """A written property file.

    Attributes
    ----------
    path : Path
    tire : Tire
        What the file contains.
    model : str
    refitted : bool
        Whether coefficients of another model, or without those that the host lacks, were fitted to the tire's forces.
    errors : mapping of str to float
        Root mean square of the difference of each force or moment from the tire without added effects, relative to the
        root mean square of the tire's; empty if the coefficients are those of the tire.
    findings : list of Finding
    """

    path: Path
    tire: Tire
    model: str
    refitted: bool
    errors: Mapping[str, float]
    findings: list[Finding]


def convert(tire: TireLike, path: str | Path, host: str, model: str | None = None) -> Conversion:
    """Write a tire as a property file for another program.

    Parameters
    ----------
    tire : Tire, str or path-like
    path : str or Path
    host : str
        One of `tirefmu.hosts.dialects.HOSTS`.
    model : str, optional
        One of the models that the host has; default: that of the tire if the host has it, else the host's first. The
        coefficients of another model than the tire's are fitted to its forces, and so are those of its own model if
        it has coefficients that the host's model lacks.

    Returns
    -------
    Conversion

    Raises
    ------
    UnknownName
        If there is no such host.
    TirefmuError
        If the host has no such model, or the file cannot be written.
    """
    rules, given = host_named(host), tire_from(tire).in_signs("iso")
    chosen = model or (given.model if given.model in rules.dialects else next(iter(rules.dialects)))
    if chosen not in rules.dialects:
        raise TirefmuError(f"{rules.title} has no {chosen}: choose from {', '.join(rules.dialects)}")
    errors: Mapping[str, float] = {}
    lost = lost_effects(given, rules)
    lacking = rules.dialects[chosen].lacking
    if chosen != given.model or acting(given, lacking):
        given, errors = refitted(given, chosen, lacking)
    written = _for_host(given, rules, chosen)
    write_tir(written, path)
    findings = lint(path, host)
    known = {finding.text for finding in findings}
    findings += [Finding("note", 0, text) for text in lost if text not in known]
    return Conversion(Path(path), written, chosen, bool(errors), errors, findings)


def _for_host(tire: Tire, rules: Host, model: str) -> Tire:
    """Return a tire whose file has the entries that the host expects."""
    entries = dict(rules.dialects[model].entries)
    side = {"left": "'LEFT'", "right": "'RIGHT'", "": "'LEFT'"}[tire.side]
    entries["TYRESIDE"] = side
    values = {name: value for name, value in tire.values.items() if name not in tire.defaulted}
    declared = tire.book.coefficients
    values |= {key: value for key, value in GENERAL.items() if key in declared and not values.get(key)}
    shape = {key: share * tire.values["UNLOADED_RADIUS"] for key, share in SHAPE.items()}
    values |= {key: value for key, value in shape.items() if key in declared and not values.get(key)}
    kept = tuple(entry for entry in tire.other_entries if entry[1] not in entries)
    known = {key for _, key, _ in kept} | set(declared)
    shape_lines = [("DIMENSION", key, repr(value)) for key, value in shape.items() if key not in known]
    general = [("MODEL", key, repr(value)) for key, value in GENERAL.items() if key not in known]
    own = [("MODEL", key, value) for key, value in entries.items()]
    return replace(tire, values=values, other_entries=(*kept, *own, *general, *shape_lines))


def refitted(tire: Tire, model: str, lacking: Collection[str] = ()) -> tuple[Tire, dict[str, float]]:
    """Fit the coefficients of a host's model to the forces of a tire over its range, without its added effects.

    Parameters
    ----------
    tire : Tire
    model : str
    lacking : collection of str
        Coefficients of the model that stay neutral.

    Returns
    -------
    (Tire, dict of str to float)
        The tire, and the root mean square error of each force relative to that of the force.
    """
    effects = tire.has - {effect.name for effect in tire.added} - tire.book.relaxing_effects
    plain = replace(tire, effects=effects, added=())
    table = _operating_range(plain)
    truth = plain.evaluate(table, steady=True)
    fitted = plain if model == tire.model else _of_model(plain, model, table, truth)
    if acting(fitted, lacking):
        fitted = without(fitted, lacking, table)
    ours = fitted.evaluate(table, steady=True)
    outputs = [name for name in fitted.outputs if name in truth]
    errors = {}
    for name in outputs:
        size = float(np.sqrt(np.mean(truth[name] ** 2)))
        errors[name] = float(np.sqrt(np.mean((ours[name] - truth[name]) ** 2))) / size if size else 0.0
    return fitted, errors


def _of_model(plain: Tire, model: str, table: pd.DataFrame, truth: pd.DataFrame) -> Tire:
    """Fit another model to the forces of a tire.

    Of the physical constraints, those of signs are enforced: a tire may violate the others itself (E_t of the Trento
    tire is above 1), and then the fit would not converge.
    """
    declared = MODELS[model].coefficients
    common = {name: value for name, value in plain.values.items() if name in declared and name not in plain.defaulted}
    common |= {key: plain.values[key] for key in ("FNOMIN", "UNLOADED_RADIUS")}
    start = Tire(model, common)
    measured = truth[[name for name in (*table, *start.outputs) if name in truth]]
    found = fit(
        measured, model, start=start, recipe="joint", screening=False, rows="equal", effects=start.has,
        without_constraints=NOT_ENFORCED,
    )  # fmt: skip
    return replace(found.tire.in_signs("iso"), name=plain.name, side=plain.side, ranges=plain.ranges)


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
