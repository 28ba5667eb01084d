# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Makes core/geometry/data/egm96_15min.npz of egm96_15.gtx (Debian package proj-data)."""

from __future__ import annotations

import struct
import sys
from pathlib import Path

import numpy as np

HEADER = struct.Struct(">4d2i")  # south, west, steps in deg; rows, columns


def main() -> int:
    """Convert the file given to the file given."""
    if len(sys.argv) != 3:
        sys.stderr.write("usage: make_geoid_grid.py egm96_15.gtx egm96_15min.npz\n")
        return 2
    data = Path(sys.argv[1]).read_bytes()
    south, west, dlat, dlon, rows, columns = HEADER.unpack_from(data)
    if (south, west, dlat, dlon, rows, columns) != (-90.0, -180.0, 0.25, 0.25, 721, 1440):
        sys.stderr.write(f"{sys.argv[1]} is not the global 15' grid.\n")
        return 2
    metres = np.frombuffer(data, ">f4", offset=HEADER.size).reshape(rows, columns)
    centimetres = np.round(metres.astype(np.float64) * 100.0).astype(np.int16)
    along = np.diff(centimetres, axis=1, prepend=np.int16(0))
    np.savez_compressed(sys.argv[2], differences=np.diff(along, axis=0, prepend=np.int16(0)))
    return 0


if __name__ == "__main__":
    sys.exit(main())
