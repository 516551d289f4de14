"""Radius, width, rim and vertical stiffness of a tire: from its size, or from what the recordings show."""

from __future__ import annotations

from collections.abc import Iterable

from ...boundary.errors import FitError
from ...boundary.escaping import excerpt
from ...measurements.checks.columns.radii import SIZE, TireSize, radii, tire_size
from ...measurements.recording import Recording

#: What shows the free radius, the best source first. The loaded radius is some percent smaller.
SOURCES = (SIZE, "radius at zero load", "wheel speed", "loaded radius")


def size_named(text: str) -> TireSize:
    """Return the dimensions of a size that a user gives. Raises `FitError` if it is none.

    >>> size_named("245/45R18").width
    0.245
    >>> size_named("17 inches")
    Traceback (most recent call last):
    ...
    tirefmu.boundary.errors.FitError: size '17 inches' is not like 245/45R18 or 16x7.5-10
    """
    size = tire_size(text)
    if size is None:
        raise FitError(f"size {excerpt(text)!r} is not like 245/45R18 or 16x7.5-10")
    return size


def dimensions(recordings: Iterable[Recording], size: str | None) -> tuple[dict[str, float], list[str]]:
    """Return coefficients with dimensions that are known, and a note on each source.

    `size`: the designation that the user gives; by default that in the title of a recording, or the radius and the
    vertical stiffness that the first recording with them shows.
    """
    values: dict[str, float] = {}
    notes: list[str] = []
    dimension = size_named(size) if size is not None else None
    for recording in recordings:
        shown = radii(recording)
        source = next((name for name in SOURCES if name in shown), None)
        if dimension is None and source is not None and "UNLOADED_RADIUS" not in values:
            dimension = tire_size(recording.about.get("tireid", "")) if source == SIZE else None
            if dimension is not None:
                size = recording.about["tireid"]
            else:
                values["UNLOADED_RADIUS"] = float(f"{shown[source]:.3g}")
                notes.append(f"radius R0 not given: {shown[source]:.3g} m by the {source} of {recording.source}")
        if "vertical stiffness" in recording.about and "VERTICAL_STIFFNESS" not in values:
            stiffness = float(recording.about["vertical stiffness"])
            values["VERTICAL_STIFFNESS"] = float(f"{stiffness:.3g}")
            notes.append(f"vertical stiffness {stiffness:.3g} N/m by the loaded radius of {recording.source}")
    if dimension is not None:
        values |= {"UNLOADED_RADIUS": dimension.radius, "WIDTH": dimension.width, "RIM_RADIUS": dimension.rim_radius}
        notes.append(
            f"size {excerpt(size or '', 60)}: radius R0 {dimension.radius:.4g} m, width {dimension.width:.3g} m, "
            f"rim radius {dimension.rim_radius:.4g} m"
        )
    return values, notes
