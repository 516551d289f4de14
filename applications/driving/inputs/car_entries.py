"""The entries of a car file: one declaration each, from which the example, the JSON Schema and the checks follow."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from ....boundary.escaping import toml_string
from ....boundary.json_schema import document, object_schema


@dataclass(frozen=True)
class Entry:
    """A number of a car.

    - `section`, `name`, `meaning`, `unit`: of the file.
    - `example`: value in the example file.
    - `default`: None if the entry is required.
    - `uncertainty`: default standard deviation, in units of `scale`: "relative" (to the value), "wheelbase" (to the
      wheelbase), "time" (to the value, whose default is that of a wheelbase of 2.7 m and grows with the square root of
      it, as the periods of similar cars do) or "absolute".
    - `lower`, `upper`: limits of plausible values.
    """

    section: str
    name: str
    meaning: str
    unit: str
    example: float
    default: float | None
    uncertainty: float
    scale: str = "absolute"
    lower: float = -1e3
    upper: float = 1e3


# The default uncertainties are judgement: a scale under the wheels knows a mass within 1 %, a car with driver and fuel
# within 3 %; a yaw inertia from a formula is right within 10 %; a consumer IMU has the offsets below after warm-up, and
# gains within 0.5 %. Roll and pitch of cars reach two thirds of their value in 30 to 80 ms; roll centers 50 to 100 mm
# above the road lift a body by 5 to 10 mm at 0.8 g, and its natural period is 0.6 to 0.9 s. A wheel of a car of 1000 kg
# has 0.5 to 1 kg m^2; rolling radii, or the readings of their speeds, differ by 0.2 %. A floor or wear changes a tire
# in all directions, but not alike.
_ENTRIES = (
    Entry("body", "wheelbase", "distance of the axles", "m", 2.4, None, 0.002, "relative", 0.05, 20.0),
    Entry("body", "mass", "mass with driver and fuel", "kg", 1100.0, None, 0.03, "relative", 0.1, 1e5),
    Entry("body", "cg_to_front", "distance of the center of gravity behind the front axle", "m", 1.15, None, 0.03,
          "relative", 0.0, 20.0),
    Entry("body", "cg_height", "height of the center of gravity", "m", 0.5, None, 0.1, "relative", 0.0, 5.0),
    Entry("body", "track_front", "front track", "m", 1.45, None, 0.005, "relative", 0.02, 5.0),
    Entry("body", "track_rear", "rear track", "m", 1.45, None, 0.005, "relative", 0.02, 5.0),
    Entry("body", "yaw_inertia", "moment of inertia about the vertical axis", "kg m^2", 1600.0, None, 0.1, "relative",
          1e-5, 1e7),
    Entry("body", "front_roll_share", "share of the roll stiffness at the front axle", "1", 0.55, 0.5, 0.1,
          "absolute", 0.0, 1.0),
    Entry("body", "drag", "drag force over the square of the speed", "N s^2/m^2", 0.4, 0.0, 0.3, "relative",
          0.0, 100.0),
    *(
        Entry("body", f"downforce_{axle}", f"downforce of the {axle} axle over the square of the speed, negative for "
              "lift", "N s^2/m^2", 0.0, 0.0, 0.1, "relative", -100.0, 100.0)
        for axle in ("front", "rear")
    ),
    Entry("body", "roll_lag", "time constant of the lateral load transfer behind the lateral acceleration", "s", 0.05,
          0.05, 0.6, "time", 0.0, 1.0),
    Entry("body", "pitch_lag", "time constant of the longitudinal load transfer", "s", 0.05, 0.05, 0.6, "time", 0.0,
          1.0),
    Entry("body", "lift", "rise of the body over the square of the lateral acceleration: jacking by the side forces",
          "s^4/m", 0.0, 0.0, 4e-5, "wheelbase", -0.01, 0.01),
    Entry("body", "heave_period", "natural period of the vertical motion of the body", "s", 0.75, 0.75, 0.2, "time",
          0.01, 10.0),
    Entry("body", "steer_front", "angle that roll and compliance take from the front wheels, over lateral acceleration",
          "rad s^2/m", 0.0, 0.0, 1e-4, "absolute", -0.01, 0.01),
    Entry("body", "steer_rear", "angle that roll and compliance turn the rear wheels into a turn, over lateral "
          "acceleration", "rad s^2/m", 0.0, 0.0, 1e-4, "absolute", -0.01, 0.01),
    Entry("body", "camber", "inclination of the wheels out of a turn over lateral acceleration", "rad s^2/m", 0.0, 0.0,
          1e-3, "absolute", -0.05, 0.05),
    Entry("steering", "ratio", "steering channel over the angle of the front wheels", "1", 15.0, 1.0, 0.01, "relative",
          1e-3, 1e4),
    Entry("steering", "offset", "angle of the front wheels at zero of the channel", "rad", 0.0, 0.0, 0.005,
          "absolute", -0.5, 0.5),
    Entry("steering", "delay", "delay of the wheels behind the steering channel", "s", 0.0, 0.0, 0.02,
          "absolute", -1.0, 1.0),
    Entry("steering", "lag", "time constant of a first-order lag of the wheels behind the channel", "s", 0.0, 0.0, 0.3,
          "relative", 0.0, 2.0),
    Entry("wheels", "radius_front", "rolling radius of the front wheels, for wheel speeds", "m", 0.3, 0.0, 0.005,
          "relative", 0.0, 3.0),
    Entry("wheels", "radius_rear", "rolling radius of the rear wheels", "m", 0.3, 0.0, 0.005, "relative", 0.0, 3.0),
    *(
        Entry("wheels", f"unequal_{axle}", f"rolling radius of the left {axle} wheel over that of the right, minus 1",
              "1", 0.0, 0.0, 0.003, "absolute", -0.1, 0.1)
        for axle in ("front", "rear")
    ),
    Entry("wheels", "wheel_inertia", "moment of inertia of a wheel over its radius squared and the mass of the car",
          "1", 0.008, 0.008, 0.4, "relative", 0.0, 1.0),
    Entry("wheels", "relaxation", "lateral relaxation lengths over those of the tire files", "1", 1.0, 1.0, 0.2,
          "relative", 0.0, 10.0),
    *(
        Entry("wheels", f"{name}_{axle}", f"longitudinal over lateral {meaning} of the {axle} tires, over that of "
              "their file", "1", 1.0, 1.0, 0.2, "relative", 0.0, 10.0)
        for name, meaning in (("grip", "friction"), ("slip_stiffness", "slip stiffness"))
        for axle in ("front", "rear")
    ),
    Entry("wheels", "brake_front", "share of the braking force at the front axle", "1", 0.65, 0.6, 0.1,
          "absolute", 0.0, 1.0),
    Entry("sensors", "x", "position of the accelerometer ahead of the center of gravity", "m", 0.0, 0.0, 0.02,
          "wheelbase", -10.0, 10.0),
    Entry("sensors", "y", "position of the accelerometer to the left of the center of gravity", "m", 0.0, 0.0, 0.02,
          "wheelbase", -10.0, 10.0),
    Entry("sensors", "roll_gradient", "roll angle over lateral acceleration", "rad s^2/m", 0.0, 0.0, 0.3, "relative",
          0.0, 0.1),
    Entry("sensors", "misalignment", "angle of the accelerometer about the vertical axis, to the left", "rad", 0.0, 0.0,
          0.01, "absolute", -0.5, 0.5),
    Entry("sensors", "ay_gain", "reading of ay over its true value", "1", 1.0, 1.0, 0.005, "absolute", 0.5, 2.0),
    Entry("sensors", "yaw_rate_gain", "reading of the yaw rate over its true value", "1", 1.0, 1.0, 0.005, "absolute",
          0.5, 2.0),
    Entry("sensors", "wheel_delay", "delay of the wheel speeds behind the accelerometer", "s", 0.0, 0.0, 0.02,
          "absolute", -1.0, 1.0),
    Entry("sensors", "yaw_rate_offset", "reading of the yaw rate at rest", "rad/s", 0.0, 0.0, 0.01),
    Entry("sensors", "ax_offset", "reading of ax at rest on a level road", "m/s^2", 0.0, 0.0, 0.3),
    Entry("sensors", "ay_offset", "reading of ay at rest on a level road; a road bank of 1 rad adds 9.81", "m/s^2", 0.0,
          0.0, 0.3),
    Entry("sensors", "reference_x", "position ahead of the center of gravity whose speed, sideslip and pose are logged",
          "m", 0.0, 0.0, 0.01, "wheelbase", -10.0, 10.0),
    Entry("sensors", "reference_y", "position to the left of the center of gravity of the same point", "m", 0.0, 0.0,
          0.01, "wheelbase", -10.0, 10.0),
    Entry("sensors", "heading_offset", "logged heading or sideslip minus that of the car", "rad", 0.0, 0.0, 0.01),
    Entry("sensors", "motion_delay", "delay of speed, sideslip and pose behind the accelerometer", "s", 0.0, 0.0, 0.02,
          "absolute", -1.0, 1.0),
)  # fmt: skip
ENTRIES: dict[str, Entry] = {entry.name: entry for entry in _ENTRIES}
LAYOUTS = ("front", "rear", "all")
#: Keys of each section that are no numbers with an uncertainty: an example and its meaning.
OTHERS: dict[str, dict[str, tuple[str, str]]] = {
    "body": {
        "front_mass": ("600.0", "kg, with rear_mass in place of mass and cg_to_front"),
        "rear_mass": ("500.0", "kg"),
    },
    "steering": {"map": ("[[-1.0, -0.4], [1.0, 0.4]]", "pairs of channel and wheel angle (rad) in place of ratio")},
    "wheels": {"driven": ('"rear"', "axle that is driven: front, rear or all")},
    "sensors": {},
    "columns": {"yaw_rate": (toml_string("W (IMU) [deg/s]"), "header of a channel that has another name in the log")},
}
_UNCERTAIN = {"relative": " of the value", "time": " of the value", "wheelbase": " of the wheelbase", "absolute": ""}


def example_text() -> str:
    """Return a commented car file.

    >>> print(example_text().splitlines()[4])
    mass = 1100.0  # kg; mass with driver and fuel; uncertainty 0.03 of the value
    """
    lines = [
        "# The car of a drive, in SI units. A number may have its own standard deviation, such as",
        "# mass = {value = 1100.0, uncertainty = 10.0}; without it, the one in the comment applies.",
    ]
    for section, others in OTHERS.items():
        lines.append(f"[{section}]")
        for entry in (entry for entry in _ENTRIES if entry.section == section):
            assumed = "" if entry.default is None else f"; default {entry.default:g}"
            lines.append(
                f"{entry.name} = {entry.example!r}  # {entry.unit}; {entry.meaning}{assumed}; "
                f"uncertainty {entry.uncertainty:g}{_UNCERTAIN[entry.scale]}"
            )
        for key, (text, meaning) in others.items():
            lines.append(f"{'' if key == 'driven' else '# '}{key} = {text}  # {meaning}")
    return "\n".join(lines) + "\n"


def car_schema() -> dict[str, Any]:
    """Return the JSON Schema of a car file.

    >>> car_schema()["properties"]["body"]["properties"]["mass"]["description"]
    'mass with driver and fuel, kg'
    """
    sections: dict[str, Any] = {}
    for section in OTHERS:
        properties: dict[str, Any] = {
            entry.name: {"description": f"{entry.meaning}, {entry.unit}", "oneOf": _number(entry)}
            for entry in _ENTRIES
            if entry.section == section
        }
        sections[section] = object_schema(properties)
    sections["body"]["properties"] |= {name: {"type": "number", "exclusiveMinimum": 0} for name in OTHERS["body"]}
    pair = {"type": "array", "items": {"type": "number"}, "minItems": 2, "maxItems": 2}
    sections["steering"]["properties"]["map"] = {"type": "array", "items": pair, "minItems": 2}
    sections["wheels"]["properties"]["driven"] = {"enum": list(LAYOUTS)}
    sections["columns"] = {"type": "object", "additionalProperties": {"type": "string"}}
    return document("car", "1.5", "Car of a drive", object_schema(sections, ["body"]))


def _number(entry: Entry) -> list[dict[str, Any]]:
    value = {"type": "number", "minimum": entry.lower, "maximum": entry.upper}
    pair = {"value": value, "uncertainty": {"type": "number", "minimum": 0}}
    return [value, object_schema(pair, ["value"])]
