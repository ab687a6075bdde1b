"""Writes and reads NumPy's npz.

The bytes are the same under any version of NumPy and of zlib: the arrays are stored uncompressed, without
times.
"""

import io
import math
import tokenize
import zipfile
from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

Arrays = Mapping[str, npt.NDArray[Any]]

_EARLIEST_TIME = (1980, 1, 1, 0, 0, 0)
"""The earliest time that a zip can express."""

_UNIX = 3
"""Zip's number of the system that made an entry."""

_ALIGNMENT = 64
"""NumPy's arrays begin at a multiple of this number [bytes]."""


class NotNpz(ValueError):
    """The error that bytes are not an uncompressed npz, or lack an array; its message says why."""


def npz(arrays: Arrays) -> bytes:
    """Returns the bytes of a file with the arrays by name, in their order."""
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_STORED) as archive:
        for name, array in arrays.items():
            entry = zipfile.ZipInfo(f"{name}.npy", _EARLIEST_TIME)
            entry.create_system = _UNIX
            entry.external_attr = 0o644 << 16
            archive.writestr(entry, _npy(array))
    return buffer.getvalue()


def arrays_of(data: bytes) -> dict[str, npt.NDArray[Any]]:
    """Returns the arrays of a file by name. Raises NotNpz for other files, or if an array does not have the
    size that its header announces."""
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            entries = archive.infolist()
            if any(entry.compress_type != zipfile.ZIP_STORED for entry in entries):
                msg = "it is compressed"
                raise NotNpz(msg)
            return {entry.filename.removesuffix(".npy"): _array(archive.read(entry)) for entry in entries}
    except (
        zipfile.BadZipFile,
        # NumPy parses the header of an array as Python.
        *(ValueError, TypeError, SyntaxError, tokenize.TokenError),
        *(EOFError, OSError, NotImplementedError, RuntimeError),
    ) as error:
        raise NotNpz(str(error)) from None


def _npy(array: npt.NDArray[Any]) -> bytes:
    """Returns an array in NumPy's format 1.0: NumPy's own headers differ between its versions."""
    contiguous = np.ascontiguousarray(array).reshape(array.shape)
    little = contiguous.astype(contiguous.dtype.newbyteorder("<"), copy=False)
    text = f"{{'descr': '{little.dtype.str}', 'fortran_order': False, 'shape': {array.shape!r}, }}"
    # The magic prefix, two bytes of the version, two of the header's length.
    header_start = len(np.lib.format.MAGIC_PREFIX) + 4
    header = text + " " * (-(header_start + len(text) + 1) % _ALIGNMENT) + "\n"
    start = np.lib.format.magic(1, 0) + len(header).to_bytes(2, "little")
    return start + header.encode("latin1") + little.tobytes()


def _array(data: bytes) -> npt.NDArray[Any]:
    """Returns an array from NumPy's format 1.0. Raises NotNpz, or an error of NumPy, for other bytes."""
    stream = io.BytesIO(data)
    if np.lib.format.read_magic(stream) != (1, 0):
        msg = "an array has another version than 1.0"
        raise NotNpz(msg)
    shape, is_fortran_order, dtype = np.lib.format.read_array_header_1_0(stream)
    if dtype.hasobject or math.prod(shape) * dtype.itemsize != len(data) - stream.tell():
        msg = "an array does not have the size that its header announces"
        raise NotNpz(msg)
    values = np.frombuffer(data, dtype, offset=stream.tell())
    return values.reshape(shape, order="F" if is_fortran_order else "C")
