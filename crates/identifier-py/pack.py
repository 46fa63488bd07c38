"""Packs a wheel anew, as small as its format can be: python pack.py WHEEL. Needs the package zopfli."""

import sys
import zipfile
from pathlib import Path

import zopfli.zlib


class Packer:
    """A compressor of zipfile, which has no public way to another one."""

    def __init__(self, *_: object) -> None:
        self.content = b""

    def compress(self, data: bytes) -> bytes:
        self.content += data
        return b""

    def flush(self) -> bytes:
        # Without the header and the checksum of zlib.
        return zopfli.zlib.compress(self.content)[2:-4]


wheel = Path(sys.argv[1])
with zipfile.ZipFile(wheel) as loose:
    parts = [(part, loose.read(part)) for part in loose.infolist()]
zipfile._get_compressor = Packer
with zipfile.ZipFile(wheel, "w", zipfile.ZIP_DEFLATED) as packed:
    for part, content in parts:
        packed.writestr(part, content, zipfile.ZIP_DEFLATED)
