"""Computes the hashes of a universal library's signatures anew (Apple's TN3126). Argument: the library. Prints what is signed."""

import hashlib
import struct
import sys
from pathlib import Path

ARM64, LC_CODE_SIGNATURE, SHA256 = 0x0100000C, 0x1D, 2
CODE_DIRECTORY, AD_HOC = 0xFADE0C02, 0x2


def slices(file):
    """Processor and contents of each library in the file."""
    magic, count = struct.unpack_from(">2I", file)
    assert magic == 0xCAFEBABE, hex(magic)
    for k in range(count):
        processor, _, start, size, alignment = struct.unpack_from(">5I", file, 8 + 20 * k)
        assert start % (1 << alignment) == 0 and alignment == 14, (start, alignment)
        yield processor, file[start : start + size]


def signature(library):
    """Place and size of the signature, if there is one."""
    (commands,), place = struct.unpack_from("<I", library, 16), 32
    for _ in range(commands):
        command, size = struct.unpack_from("<2I", library, place)
        if command == LC_CODE_SIGNATURE:
            return struct.unpack_from("<2I", library, place + 8)
        place += size
    return None


def check(library, start, size):
    """Pages that are signed, all of them with the right hash."""
    assert start + size == len(library), "something follows the signature"
    blob = library[start:]
    assert struct.unpack_from(">3I", blob)[2] >= 1
    directory = blob[struct.unpack_from(">I", blob, 16)[0] :]
    magic, _, _, flags, hashes, _, _, pages, end = struct.unpack_from(">9I", directory)
    length, kind, _, exponent = directory[36:40]
    assert (magic, kind, length) == (CODE_DIRECTORY, SHA256, 32) and flags & AD_HOC and end == start
    for page in range(pages):
        contents = library[page << exponent : min((page + 1) << exponent, end)]
        at = hashes + 32 * page
        assert hashlib.sha256(contents).digest() == directory[at : at + 32], f"page {page} is not what was signed"
    assert pages << exponent >= end
    return pages


for processor, library in slices(Path(sys.argv[1]).read_bytes()):
    found = signature(library)
    assert found or processor != ARM64, "not signed: macOS on arm refuses it"
    if found:
        print("arm64" if processor == ARM64 else hex(processor), f"{check(library, *found)} pages are what was signed", sep=": ")
