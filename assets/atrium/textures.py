"""The pictures of the atrium, each a function that returns an Image. Colours are sRGB unless said otherwise."""
import math
import random

from . import font
from .png import Image


def _lattice(period, seed):
    generator = random.Random(seed)
    return [[generator.random() for _ in range(period)] for _ in range(period)]


def noise(size, period, seed, octaves=1):
    """A tiling size x size field of smooth noise, 0 to 1; `period` lattice cells a side in the first octave."""
    field = [[0.0] * size for _ in range(size)]
    total = sum(0.5 ** o for o in range(octaves))
    for octave in range(octaves):
        cells = period << octave
        lattice = _lattice(cells, seed * 31 + octave)
        steps = []
        for i in range(size):
            place = i * cells / size
            f = place - int(place)
            steps.append((int(place) % cells, (int(place) + 1) % cells, f * f * (3 - 2 * f)))
        for y, (y0, y1, fy) in enumerate(steps):
            row, upper, lower = field[y], lattice[y0], lattice[y1]
            for x, (x0, x1, fx) in enumerate(steps):
                a = upper[x0] + (upper[x1] - upper[x0]) * fx
                b = lower[x0] + (lower[x1] - lower[x0]) * fx
                row[x] += (a + (b - a) * fy) * 0.5 ** octave / total
    return field


def _mixed(a, b, t):
    return tuple(round(p + (q - p) * t) for p, q in zip(a, b))


def _level(value, levels):
    """`value` in 0 to 1 rounded to one of a few levels: keeps the pictures within a palette."""
    return min(levels - 1, max(0, int(value * levels))) / (levels - 1)


def normal_map(height, strength):
    """Tangent-space normals (linear, +y up the picture) of a tiling height field; strength in pixels."""
    size = len(height)

    def shade(x, y):
        dx = (height[y][(x + 1) % size] - height[y][x - 1]) * 0.5 * strength
        dy = (height[(y + 1) % size][x] - height[y - 1][x]) * 0.5 * strength
        scale = 1 / math.sqrt(dx * dx + dy * dy + 1)
        return tuple(round(127.5 + 127.5 * v * scale) for v in (-dx, dy, 1.0))

    return Image.of(size, size, shade)


# Bricks: 8 x 24 in a square of two metres.
_BRICKS_X, _BRICKS_Y = 8, 24


def _brick_at(x, y, size):
    """Row and column of the brick, and the distance in pixels from its joint."""
    row = y * _BRICKS_Y // size
    across = (x * _BRICKS_X / size + 0.5 * (row % 2)) % _BRICKS_X
    down = y * _BRICKS_Y / size - row
    from_side = min(across % 1, 1 - across % 1) * size / _BRICKS_X
    from_bed = min(down, 1 - down) * size / _BRICKS_Y
    return row, int(across), min(from_side, from_bed)


def bricks(size=512):
    grain = noise(size, 64, 1, 2)
    tints = [(150, 78, 58), (163, 88, 64), (139, 70, 55), (171, 99, 72), (128, 66, 54)]
    generator = random.Random(11)
    tint = [[generator.choice(tints) for _ in range(_BRICKS_X)] for _ in range(_BRICKS_Y)]

    def shade(x, y):
        row, column, joint = _brick_at(x, y, size)
        light = _level(grain[y][x], 12)
        if joint < 1.6:
            return _mixed((168, 160, 148), (196, 189, 178), light)
        return tuple(min(255, round(c * (0.82 + 0.3 * light))) for c in tint[row][column])

    return Image.of(size, size, shade)


def bricks_normal(size=256):
    grain = noise(size, 64, 1)
    height = [[min(_brick_at(x, y, size)[2], 2.0) / 2.0 + 0.12 * grain[y][x] for x in range(size)]
              for y in range(size)]
    return normal_map(height, 1.6)


# Floor: 4 x 4 tiles in a square of two metres, light and dark in turn.
_TILES = 4


def _tile_joint(x, y, size):
    side = size / _TILES
    return min(x % side, side - x % side, y % side, side - y % side)


def tiles(size=512):
    veins = noise(size, 8, 3, 4)
    cloud = noise(size, 4, 4, 3)

    def shade(x, y):
        if _tile_joint(x, y, size) < 1.5:
            return (92, 86, 80)
        dark = (x * _TILES // size + y * _TILES // size) % 2
        vein = _level(max(0.0, 1 - abs(veins[y][x] - 0.5) * 14), 8)
        light = _level(cloud[y][x], 12)
        if dark:
            return _mixed(_mixed((74, 82, 84), (98, 106, 106), light), (176, 178, 170), 0.55 * vein)
        return _mixed(_mixed((196, 186, 170), (222, 214, 200), light), (146, 132, 118), 0.5 * vein)

    return Image.of(size, size, shade)


def tiles_normal(size=256):
    height = [[min(_tile_joint(x, y, size), 2.0) / 2.0 for x in range(size)] for y in range(size)]
    return normal_map(height, 0.9)


def tiles_roughness(size=256):
    """Linear: green roughness, blue metal. Polished stone, worn in patches, rough joints."""
    wear = noise(size, 4, 5, 3)

    def shade(x, y):
        rough = 0.85 if _tile_joint(x, y, size) < 1.0 else 0.22 + 0.3 * _level(wear[y][x], 24)
        return (255, round(255 * rough), 0)

    return Image.of(size, size, shade)


def plaster(size=256):
    cloud = noise(size, 8, 6, 4)
    return Image.of(size, size, lambda x, y: _mixed((222, 218, 210), (250, 248, 243), _level(cloud[y][x], 40)))


def plaster_normal(size=128):
    return normal_map(noise(size, 16, 7, 3), 2.2)


def wood(size=256):
    """Four planks side by side, grain upright."""
    wobble = noise(size, 4, 8, 2)
    fine = noise(size, 64, 9)

    def shade(x, y):
        plank = x * 4 // size
        if x % (size // 4) < 1:
            return (62, 40, 26)
        ring = math.sin((x + 26 * wobble[y][x] + 17 * plank) * 0.9) * 0.5 + 0.5
        light = _level(0.55 * ring + 0.25 * fine[y][x] + 0.2 * (plank * 37 % 5) / 4, 40)
        return _mixed((112, 72, 44), (178, 126, 80), light)

    return Image.of(size, size, shade)


def rug(size=256):
    """Fine stripes, one to four pixels wide, with wider bands."""
    colours = [(178, 58, 48), (236, 224, 198), (38, 62, 92), (214, 156, 62)]

    def shade(x, y):
        band = y // 32 % 4
        stripe = (y // (1 + band)) % 2
        fringe = x % 64 < 2
        return (60, 40, 36) if fringe else colours[(band + 2 * stripe) % 4]

    return Image.of(size, size, shade)


def brushed(width=128, height=128):
    """Linear: metal with roughness in thin horizontal lines."""
    generator = random.Random(12)
    lines = [generator.random() for _ in range(height)]
    return Image.of(width, height, lambda x, y: (255, round(255 * (0.28 + 0.34 * _level(lines[y], 32))), 255))


def shade_of_edges(size=64):
    """Linear, occlusion in red: a surface that is darker towards its border."""

    def shade(x, y):
        edge = min(x, y, size - 1 - x, size - 1 - y) / (size / 2)
        value = round(255 * (0.45 + 0.55 * min(1.0, edge * 2.0) ** 0.5))
        return (value, value, value)

    return Image.of(size, size, shade)


def leaf(size=128):
    """A leaf on clear ground, stem at the bottom middle. Alpha cuts it out; green reaches past it for the mips."""

    def shade(x, y):
        u, v = (x + 0.5) / size - 0.5, 1 - (y + 0.5) / size
        half = 0.40 * math.sin(math.pi * min(1.0, v * 1.02)) ** 0.8 * (1.15 - 0.6 * v) if v > 0 else 0.0
        vein = abs(u) < 0.012 or abs((v * 9 - abs(u) * 5) % 1 - 0.5) < 0.06
        notch = 0.02 * math.sin(v * 60)
        inside = abs(u) < half + notch * (half > 0.05) or (abs(u) < 0.015 and v < 0.1)
        base = (122, 160, 78) if vein else _mixed((44, 96, 40), (84, 136, 58), _level(0.5 + u, 8))
        return base + (255 if inside else 0,)

    return Image.of(size, size, shade)


def stained_glass(size=256):
    """Leaded panes in warm and cool colours; the lead is nearly opaque, the panes let light through."""
    colours = [(226, 196, 120), (120, 170, 196), (200, 108, 88), (138, 178, 120), (222, 222, 204), (92, 112, 170)]

    def shade(x, y):
        u, v = x / size * 6, y / size * 6
        lattice_a, lattice_b = (u + v) % 1, (u - v) % 1
        ring = math.hypot(x / size - 0.5, y / size - 0.5) * 8
        lead = min(lattice_a, 1 - lattice_a, lattice_b, 1 - lattice_b) < 0.05 or (ring < 4 and ring % 1 < 0.08)
        if lead:
            return (36, 36, 40, 235)
        pick = (math.floor(u + v) * 3 + math.floor(u - v) * 5 + (int(ring) if ring < 4 else 4)) % len(colours)
        return colours[pick] + (165,)

    return Image.of(size, size, shade)


def _page(width, height, paper):
    return [paper] * (width * height)


_NOTICE = [
    "THE HALL IS 24 METRES LONG, 16 WIDE AND 10 HIGH.",
    "EIGHTEEN COLUMNS CARRY TWO GALLERIES, AND",
    "EIGHTEEN MORE, THE SAME BUT SLIMMER, CARRY THE",
    "RIBS OF THE VAULT. WHAT STANDS ON THE NORTH SIDE",
    "IS THE MIRROR OF WHAT STANDS ON THE SOUTH SIDE.",
    "",
    "A LAMP TRAVELS ALONG ITS RAIL, THERE AND BACK IN",
    "EIGHT SECONDS. THE FAN TURNS ONCE IN FOUR.",
    "",
    "SMALL PRINT IS WHAT A TEXTURE LOSES FIRST:",
    "IF YOU CAN READ THIS LINE FROM THE STAIRS, THE",
    "PICTURE HAS ENOUGH SAMPLES. IF NOT, COME CLOSER",
    "AND THEY WILL HAVE BEEN SPENT SOMEWHERE ELSE.",
    "",
    "COPPER    ROUGHNESS 0.35      STEEL   0.25 - 0.60",
    "GOLD      ROUGHNESS 0.22      BRASS   0.45",
    "",
    "0123456789  ABCDEFGHIJKLMNOPQRSTUVWXYZ",
]


def notice(width=320, height=256):
    """A printed page: a title and small text, with a ruler of fine lines at the foot."""
    ink, accent, paper = (34, 36, 44), (150, 40, 34), (240, 234, 218)
    pixels = _page(width, height, paper)
    font.draw(pixels, width, (width - font.width_of("THE ATRIUM", 3)) // 2, 10, "THE ATRIUM", accent, 3)
    for number, line in enumerate(_NOTICE):
        font.draw(pixels, width, 12, 42 + number * 10, line, ink)
    for x in range(12, width - 12):
        step = 1 + (x - 12) // 60
        if (x // step) % 2:
            for y in range(height - 26, height - 10):
                pixels[y * width + x] = ink
    return Image(width, height, pixels)


def sign(text, ink, ground, size=4, margin=8):
    """A line of large text on one colour; the width is rounded up to a multiple of 8."""
    width = (font.width_of(text, size) + 2 * margin + 7) // 8 * 8
    height = 7 * size + 2 * margin
    pixels = _page(width, height, ground)
    font.draw(pixels, width, (width - font.width_of(text, size)) // 2, margin, text, ink, size)
    return Image(width, height, pixels)


def banner(width=128, height=320):
    """Upright letters between fine stripes."""
    cloth, stripe, ink = (32, 60, 96), (222, 186, 96), (240, 232, 214)
    pixels = _page(width, height, cloth)
    for y in range(height):
        for x in list(range(4, 28)) + list(range(width - 28, width - 4)):
            if x % 4 < 2:
                pixels[y * width + x] = stripe
        if y < 8 or y >= height - 8:
            pixels[y * width:(y + 1) * width] = [stripe] * width
    for place, letter in enumerate("TESSERA"):
        font.draw(pixels, width, width // 2 - 12, 20 + place * 41, letter, ink, 5)
    return Image(width, height, pixels)
