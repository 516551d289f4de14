"""Many tires: fits of a list of jobs, on processes of this machine or on a Dask cluster.

Nothing is imported here: a process that runs tasks imports what they need.
"""
