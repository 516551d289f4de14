"""From the log of a drive to the forces of the axles: what a tire on the road differs in from its file."""
