"""How an FMU is built: C sources, binaries for each platform, the Python variant, the archive."""
