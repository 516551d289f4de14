"""Files read up to a size: what is larger than any sensible file of its kind is refused before it fills the memory."""

from __future__ import annotations

import errno
from pathlib import Path


def read_bounded(path: Path, most: int) -> bytes:
    """Return the content of a file that is not larger than a limit.

    Parameters
    ----------
    path : pathlib.Path
    most : int
        Bytes; also of what has no size to ask for, such as a device.

    Returns
    -------
    bytes

    Raises
    ------
    OSError
        If it cannot be read; with EFBIG and the limit in words if it is larger.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = Path(folder) / "file"
    ...     _ = file.write_bytes(bytes(2_000_001))
    ...     try:
    ...         read_bounded(file, 2_000_000)
    ...     except OSError as error:
    ...         print(error.strerror)
    larger than 2 MB
    """
    with path.open("rb") as file:
        content = file.read(most + 1)
    if len(content) > most:
        raise OSError(errno.EFBIG, f"larger than {most / 1e6:g} MB", str(path))
    return content
