"""A tire as a library with the Standard Tyre Interface (TYDEX-STI), for multibody programs."""
