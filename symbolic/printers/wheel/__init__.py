"""Functions of the wheel at its hub as code: its kinematics, the effective rolling radius."""
