"""The border of the package: its errors, the escaping of texts from files, bounded reading of TOML."""
