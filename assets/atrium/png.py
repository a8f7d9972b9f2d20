"""Images as flat lists of 8-bit tuples, and PNG bytes of them."""
import struct
import zlib


class Image:
    """`pixels` holds rows from the top: (r, g, b), or (r, g, b, a), values 0 to 255."""

    def __init__(self, width, height, pixels):
        assert len(pixels) == width * height
        self.width, self.height, self.pixels = width, height, pixels

    @classmethod
    def of(cls, width, height, shade):
        """An image whose pixel at column x, row y is shade(x, y)."""
        return cls(width, height, [shade(x, y) for y in range(height) for x in range(width)])


def _chunk(kind, data):
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


def _filtered(row, above, step):
    """The row under the PNG filter (none, sub, up, average) whose residuals are smallest."""
    left = bytes(step) + row[:-step]
    options = [
        row,
        bytes((a - b) & 255 for a, b in zip(row, left)),
        bytes((a - b) & 255 for a, b in zip(row, above)),
        bytes((a - (b + c) // 2) & 255 for a, b, c in zip(row, left, above)),
    ]
    cost = [sum(min(v, 256 - v) for v in option) for option in options]
    best = cost.index(min(cost))
    return bytes([best]) + options[best]


def encode(image):
    """PNG bytes: indexed when there are at most 256 opaque colours, else 8-bit RGB or RGBA."""
    channels = len(image.pixels[0])
    palette = sorted(set(image.pixels))
    indexed = channels == 3 and len(palette) <= 256
    width, height = image.width, image.height
    body = bytearray()
    if indexed:
        index = {colour: i for i, colour in enumerate(palette)}
        depth = next(bits for bits in (1, 2, 4, 8) if len(palette) <= 1 << bits)
        for y in range(height):
            row, held, bits = bytearray([0]), 0, 0
            for pixel in image.pixels[y * width:(y + 1) * width]:
                held, bits = held << depth | index[pixel], bits + depth
                if bits == 8:
                    row.append(held)
                    held = bits = 0
            assert bits == 0, "width times depth must fill whole bytes"
            body += row
    else:
        depth = 8
        above = bytes(width * channels)
        for y in range(height):
            row = bytes(v for pixel in image.pixels[y * width:(y + 1) * width] for v in pixel)
            body += _filtered(row, above, channels)
            above = row
    colour_type = 3 if indexed else 2 if channels == 3 else 6
    chunks = [_chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, depth, colour_type, 0, 0, 0))]
    if indexed:
        chunks.append(_chunk(b"PLTE", bytes(v for colour in palette for v in colour)))
    chunks += [_chunk(b"IDAT", zlib.compress(bytes(body), 9)), _chunk(b"IEND", b"")]
    return b"\x89PNG\r\n\x1a\n" + b"".join(chunks)
