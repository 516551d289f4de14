"""Whether a model satisfies its declarations: checked before its code is printed.

All numbers of a model come from its printed code, so a model that fails here cannot be evaluated or fitted. Most checks
compare names. The sign laws are checked by numbers (`tirefmu.symbolic.model.sign_law`).
"""

from __future__ import annotations

import re
from collections.abc import Iterable

from ...boundary.errors import ModelError, nearest
from ...boundary.escaping import excerpt
from ..contract import ROLES
from ..declarations import Coefficient
from ..quantities import BEYOND
from .definition import INDISPENSABLE, Model
from .sign_law import check_reversal, check_signs

#: How a description begins: in lower case, with the symbol of a force or moment, or with the name of a model.
_DESCRIPTION = re.compile(r"[a-z]|[FM][xyz]\b|MF[0-9.]+: [a-z]")


def verify(model: Model) -> None:
    """Raise `ModelError` for the first declaration that a model violates.

    Raises `ModelError`: with the name of the model and of the coefficient or quantity.

    >>> from tirefmu.symbolic.models import model_named
    >>> verify(model_named("mf96"))
    """
    _check_tables(model)
    _check_coefficients(model)
    _check_quantities(model)
    check_signs(model)
    check_reversal(model)


def _check_tables(model: Model) -> None:
    """Check the assumptions of every program on inputs, outputs and the two sizes of a tire."""
    inputs = [quantity.name for quantity in model.inputs]
    if inputs[:2] != ["kappa", "alpha"] or "Fz" not in inputs:
        raise ModelError(f"{model.name}: inputs begin with kappa and alpha and have Fz, not {', '.join(inputs)}")
    outputs = [quantity.name for quantity in model.outputs]
    filed = {line.symbol.name for line in model.equations}
    for name in ("Fx", "Fy", *outputs):
        if name not in outputs or name not in filed:
            raise ModelError(f"{model.name}: no line makes the output {name}")
    declarations = _declared(model)
    # An added effect may read T without a coefficient for its reference: a table without T then has its typical value.
    nominal = (q.nominal for q in model.inputs if isinstance(q.nominal, str) and q.name not in BEYOND)
    for name in (*INDISPENSABLE, *nominal):
        if name not in declarations:
            raise ModelError(f"{model.name}: no section has the coefficient {name}")


def _check_coefficients(model: Model) -> None:
    declarations = _declared(model)
    for name, declaration in model.coefficients.items():
        if declaration.default != declaration.default:
            raise ModelError(f"{model.name}: coefficient {name} has neither a neutral value nor a start")
    of_files = {effect.section for effect in model.added}  # with any text, checked by their reader
    for section in model.sections:
        for name, declaration in section.coefficients.items() if section.title not in of_files else ():
            _check_declaration(model, name, declaration)
    named = [(f"role {role}", name) for role, declared in model.roles.items() for name in declared.coefficients]
    named += [("the baseline", name) for name in model.baseline.coefficients]
    named += [("the relaxation lengths", name) for name in model.motion.relaxation]
    named += [("its own relaxation lengths", name) for name in model.motion.own_relaxation]
    named += [("the low speed", name) for name in (model.motion.low_speed,) if name]
    named += [("the scales of friction", name) for name in model.motion.friction_scales]
    named += [("a start", name) for start in model.baseline.starts for name in start]
    for where, name in named:
        if name not in declarations:
            near = nearest(name, declarations)
            raise ModelError(f"{model.name}: {where} has {name}, which is no coefficient of it{near}")


def _check_declaration(model: Model, name: str, declared: Coefficient) -> None:
    """Check name, description and bounds of a coefficient."""
    where = f"{model.name}: coefficient {name}"
    if name != name.upper():
        raise ModelError(f"{where} is not in capital letters")
    if not _DESCRIPTION.match(declared.description):
        begins = "in lower case, or as 'Fy at ...' or 'MF5.2: ...'"
        raise ModelError(f"{where}: the description {excerpt(declared.description, 40)!r} has to begin {begins}")
    if not declared.lower <= declared.generic <= declared.upper or declared.lower == declared.upper:
        bounds = f"{declared.lower:g} to {declared.upper:g}"
        raise ModelError(f"{where}: the start {declared.generic:g} is not within its bounds, {bounds}")


def _check_quantities(model: Model) -> None:
    named = {line.symbol.name for line in model.equations if line.named}
    outputs = {quantity.name for quantity in model.outputs}
    for role, declared in model.roles.items():
        if role not in ROLES:
            raise ModelError(f"{model.name}: unknown role {role!r}{nearest(role, ROLES)}")
        _check_named(model, f"role {role}", declared.quantity, named)
    for name in model.results:
        _check_named(model, "the results", name, named)
    for output, constraints in model.fit.constraints.items():
        if output not in outputs:
            raise ModelError(f"{model.name}: constraints of {output}, which is no output of it")
        for constraint in constraints:
            _check_named(model, f"a constraint of {output}", constraint.quantity, named)
    lags = [f"relaxation_{axis}" for axis in "xy" if model.quantity(f"relaxation_{axis}")]
    if len(lags) == 1 or (lags and "V" not in {quantity.name for quantity in model.inputs}):
        raise ModelError(f"{model.name}: slips lag by relaxation_x and relaxation_y, at the input V: all or none")
    for kind, why in (
        ("friction", "an FMU reports its use"),
        ("stiffness", "a standing tire with relaxation needs it"),
    ):
        missing = [role for role in (f"{kind}_x", f"{kind}_y") if not model.quantity(role)]
        if missing and (kind == "friction" or lags):
            raise ModelError(f"{model.name}: role {missing[0]} is missing: {why}")


def _check_named(model: Model, where: str, name: str, named: Iterable[str]) -> None:
    names = list(named)
    if name not in names:
        raise ModelError(f"{model.name}: {where} has {name}, which is no named quantity of it{nearest(name, names)}")


def _declared(model: Model) -> set[str]:
    return {name for section in model.sections for name in section.coefficients}
