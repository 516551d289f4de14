"""A summary of a tire in a few lines, for ``repr`` and notebooks, and what its user has to know."""

from __future__ import annotations

from collections.abc import Collection, Iterable

from ..boundary.escaping import excerpt
from .definition import TireDefinition
from .notebook import html_details, html_summary, html_table

#: The longest name that a summary shows, in characters.
LONGEST_NAME = 80


def tire_text(tire: TireDefinition, assumed: Collection[str]) -> str:
    """Return a summary of a tire in a few lines; `assumed`: its coefficients that were not given.

    >>> from tirefmu.tires import published
    >>> print(tire_text(published("trento_hoosier"), ()))
    Tire 'Hoosier 6.0/18.0-10 LCO (Trento team 6)': mf96 (Magic Formula 1996, Trento form), adapted-sae signs, left side
      nominal: Fz 220 N
      ranges (SI): kappa -0.3 to 0.3, alpha -0.2094 to 0.2094, gamma 0 to 0.06981, Fz 120 to 1220
      100 of 100 coefficients given, 20 effects
    """
    name = f" {excerpt(tire.name, LONGEST_NAME)!r}" if tire.name else ""
    side = f", {tire.side} side" if tire.side else ""
    absent = [
        effect
        for effect in tire.symbolic_model.effects
        if effect not in tire.has and effect in tire.symbolic_model.default_effects
    ]
    given = len(tire.values) - len({*tire.defaulted, *assumed})
    lines = [
        f"Tire{name}: {tire.model} ({tire.symbolic_model.title}), {tire.signs} signs{side}",
        f"  nominal: {', '.join(f'{name} {value:.4g} {unit}'.rstrip() for name, value, unit in _nominal(tire))}",
    ]
    if tire.ranges:
        ranges = (f"{name} {low:.4g} to {high:.4g}" for name, (low, high) in tire.ranges.items())
        lines.append(f"  ranges (SI): {', '.join(ranges)}")
    lines.append(f"  {given} of {len(tire.values)} coefficients given, {len(tire.has)} effects")
    if absent:
        lines.append(f"  without: {_few(absent)}")
    return "\n".join(lines)


def tire_html(tire: TireDefinition, assumed: Collection[str]) -> str:
    """Return the same as HTML, with the coefficients that were given.

    >>> from tirefmu.tires import published
    >>> "<td>PDY1</td>" in tire_html(published("trento_hoosier"), ())
    True
    """
    absent = {*tire.defaulted, *assumed}
    given = [declared for name, declared in tire.symbolic_model.coefficients.items() if name not in absent]
    rows = [(declared.name, tire.values[declared.name], declared.unit, declared.description) for declared in given]
    table = html_table(["coefficient", "value", "unit", "description"], rows)
    return html_summary(tire_text(tire, assumed), html_details(f"Coefficients ({tire.signs} signs)", table))


def idle_effects(tire: TireDefinition) -> list[str]:
    """Return the effects of a tire that do nothing: their coefficients are neutral, but for references.

    >>> from tirefmu.tires import published
    >>> "camber_thrust" in idle_effects(published("trento_hoosier"))
    False
    """
    model, plain = tire.symbolic_model, tire.in_signs("adapted-sae")
    neutral = {name: declaration.neutral for name, declaration in model.coefficients.items()}
    idle = []
    for effect in (name for name in model.effects if name in tire.has):
        switched = [name for name in model.owned(effect) if neutral[name] is not None]
        if switched and all(plain.values[name] == neutral[name] for name in switched):
            idle.append(effect)
    return idle


def idle_notes(names: Iterable[str]) -> list[str]:
    """Return a sentence on each effect that does nothing.

    >>> idle_notes(["relax_mf"])
    ['the effect relax_mf does nothing: its coefficients have neutral values']
    """
    return [f"the effect {name} does nothing: its coefficients have neutral values" for name in names]


def _nominal(tire: TireDefinition) -> list[tuple[str, float, str]]:
    """Return name, value and unit of the nominal inputs that are not 0."""
    values = [(q.name, tire.nominal(q.name), "" if q.unit == "1" else q.unit) for q in tire.symbolic_model.inputs]
    return [entry for entry in values if entry[1] != 0.0]


def _few(names: list[str], most: int = 6) -> str:
    """Return the first names and the number of further names."""
    more = f" and {len(names) - most} more" if len(names) > most else ""
    return ", ".join(names[:most]) + more
