"""Effects for tirefmu: every TOML file of this package is one."""
