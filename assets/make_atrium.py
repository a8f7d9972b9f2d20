#!/usr/bin/env python3
"""Writes atrium.glb: a hall with two galleries, made to hold what shading into an atlas finds hard and easy.

    python3 assets/make_atrium.py [OUTPUT]

Metres, y up. The hall is 24 long (x), 16 wide (z) and 10 high, its middle at the origin. The same script gives the
same bytes, so the file beside it can be checked against it. Standard library only.
"""
import math
import random
import sys
from pathlib import Path

from atrium import shapes, textures
from atrium.glb import Document
from atrium.shapes import Mesh, add, arch, beam, box, lathe, scaled, tube

GALLERY = 4.0     # height of the gallery floors
EDGE = 5.15       # |z| of the gallery edges
ROW = 5.4         # |z| of the columns and railings
LANDING = -8.5    # x of the edge of the gallery at the end, where the stairs arrive
SPRING = 7.8      # height at which the vault begins
BAYS = range(-12, 13, 3)


def turn_y(degrees):
    half = math.radians(degrees) / 2
    return (0.0, round(math.sin(half), 7), 0.0, round(math.cos(half), 7))


def aim(direction):
    """The rotation that takes -z to `direction`, as a unit quaternion (x, y, z, w)."""
    d = shapes.unit(direction)
    if d[2] > 0.999999:
        return (0.0, 1.0, 0.0, 0.0)
    q = add(shapes.cross((0.0, 0.0, -1.0), d) + (0.0,), (0.0, 0.0, 0.0, 1.0 - d[2]))
    return scaled(q, 1 / math.sqrt(shapes.dot(q, q)))


def make_materials(doc):
    """All materials by name."""
    def picture(image, name, repeat=True, **more):
        return dict(index=doc.texture(image, name, repeat), **more)

    brick = picture(textures.bricks(), "bricks")
    brick_normal = picture(textures.bricks_normal(), "bricks normal")
    plaster = picture(textures.plaster(), "plaster")
    plaster_normal = picture(textures.plaster_normal(), "plaster normal", scale=0.6)
    tile = picture(textures.tiles(), "tiles")
    tile_normal = picture(textures.tiles_normal(), "tiles normal")
    tile_surface = picture(textures.tiles_roughness(), "tiles roughness")
    wood = picture(textures.wood(), "wood")
    rug = picture(textures.rug(), "rug")
    brushed = picture(textures.brushed(), "brushed")
    glass = textures.stained_glass()
    pane = picture(glass, "stained glass")
    transform = doc.extension("KHR_texture_transform")
    edges = picture(textures.shade_of_edges(), "shade of edges", repeat=False, texCoord=1, strength=0.9,
                    extensions={transform: {"offset": [0.02, 0.02], "scale": [0.96, 0.96]}})
    strong = "KHR_materials_emissive_strength"
    unlit = {"KHR_materials_unlit": {}}
    make = doc.material
    made = {
        "brick wall": make("brick wall", base=brick, normalTexture=brick_normal, roughness=0.9, tangents=True),
        "brick arch": make("brick arch", base=brick, normalTexture=brick_normal, roughness=0.9),
        "plaster": make("plaster", base=plaster, roughness=0.95),
        "vault": make("vault", (0.86, 0.9, 0.96, 1), base=plaster, normalTexture=plaster_normal, roughness=0.95),
        "column": make("column", (0.93, 0.89, 0.8, 1), base=plaster, roughness=0.6),
        "tiles": make("tiles", base=tile, normalTexture=tile_normal, surface=tile_surface, roughness=1.0),
        "gallery floor": make("gallery floor", base=wood, roughness=0.5, occlusionTexture=edges),
        "wood": make("wood", base=wood, roughness=0.55),
        "dark wood": make("dark wood", (0.5, 0.42, 0.4, 1), base=wood, roughness=0.45),
        "stone": make("stone", (0.5, 0.49, 0.46, 1), roughness=0.75),
        "rug": make("rug", base=dict(rug, extensions={transform: {"rotation": 0.35, "scale": [2.0, 3.0]}}),
                    roughness=1.0),
        "iron": make("iron", (0.2, 0.21, 0.23, 1), metallic=1.0, roughness=0.5),
        "brass": make("brass", (0.91, 0.74, 0.42, 1), metallic=1.0, roughness=0.45),
        "copper": make("copper", (0.95, 0.64, 0.54, 1), metallic=1.0, roughness=0.35),
        "gold": make("gold", (1.0, 0.78, 0.34, 1), metallic=1.0, roughness=0.22),
        "brushed steel": make("brushed steel", (0.72, 0.73, 0.75, 1), metallic=1.0, roughness=1.0, surface=brushed),
        "painted duct": make("painted duct", (0.28, 0.42, 0.44, 1), roughness=0.4),
        "cable": make("cable", (0.05, 0.05, 0.055, 1), roughness=0.6),
        "blue glaze": make("blue glaze", (0.05, 0.16, 0.42, 1), roughness=0.12),
        "white glaze": make("white glaze", (0.85, 0.84, 0.8, 1), roughness=0.18),
        "clay": make("clay", (0.55, 0.27, 0.17, 1), roughness=0.85),
        "earth": make("earth", (0.09, 0.06, 0.04, 1), roughness=1.0),
        "leaf": make("leaf", base=picture(textures.leaf(), "leaf", repeat=False), roughness=0.6, alphaMode="MASK",
                     alphaCutoff=0.5, doubleSided=True),
        "books": make("books", roughness=0.8),
        "banner": make("banner", base=picture(textures.banner(), "banner", repeat=False), roughness=0.9),
        "notice": make("notice", base=picture(textures.notice(), "notice", repeat=False), roughness=0.7),
        "glass": make("glass", base=pane, roughness=0.15, alphaMode="BLEND", doubleSided=True,
                      emissiveTexture=dict(pane), emissiveFactor=[0.5, 0.5, 0.5]),
        "hall sign": make("hall sign", extensions=unlit, base=picture(
            textures.sign("TESSERA ATRIUM", (255, 226, 160), (22, 36, 58)), "hall sign", repeat=False)),
        "exit sign": make("exit sign", extensions=unlit, base=picture(
            textures.sign("EXIT", (240, 255, 244), (18, 110, 66)), "exit sign", repeat=False)),
        "lamp shade": make("lamp shade", (0.9, 0.8, 0.62, 1), roughness=0.7, doubleSided=True,
                           emissiveFactor=[1.0, 0.62, 0.3], extensions={strong: {"emissiveStrength": 1.3}}),
        "moving shade": make("moving shade", (0.6, 0.75, 0.9, 1), roughness=0.5, doubleSided=True,
                             emissiveFactor=[0.55, 0.78, 1.0], extensions={strong: {"emissiveStrength": 2.5}}),
    }
    for step in range(5):
        name = "steel %d" % step
        made[name] = make(name, (0.8, 0.8, 0.82, 1), metallic=1.0, roughness=round(0.05 + 0.18 * step, 2))
    return made


class Atrium:
    """The hall, built part by part into one document."""

    def __init__(self):
        self.doc = Document("tessera make_atrium.py")
        self.root = self.doc.node(name="atrium")
        self.materials = make_materials(self.doc)
        self.random = random.Random(2024)

    def group(self, name, **more):
        return self.doc.node(self.root, name=name, **more)

    def mesh(self, name, *parts):
        return self.doc.mesh(name, *((shape, self.materials[material]) for shape, material in parts))

    def place(self, parent, name, mesh, at=(0, 0, 0), **more):
        return self.doc.node(parent, name=name, mesh=mesh, translation=tuple(at), **more)

    def solid(self, parent, name, material, low, high, tile=2.0, skip=""):
        """A box of its own, standing where it is."""
        return self.doc.node(parent, name=name, mesh=self.mesh(name, (box(Mesh(), low, high, tile, skip), material)))

    # The shell: few, very large faces.

    def shell(self):
        shell = self.group("shell")
        self.solid(shell, "floor", "tiles", (-12.3, -0.3, -8.3), (12.3, 0.0, 8.3))
        self.solid(shell, "roof", "plaster", (-12.3, 10.0, -8.3), (12.3, 10.3, 8.3))
        for side, name in ((-1, "north wall"), (1, "south wall")):
            low, high = sorted((side * 8.0, side * 8.3))
            self.solid(shell, name, "brick wall", (-12.3, 0.0, low), (12.3, 10.0, high))
        self.solid(shell, "west wall", "plaster", (-12.3, 0.0, -8.0), (-12.0, 10.0, 8.0), tile=3.0)
        for side, name in ((-1, "east wall, north of window"), (1, "east wall, south of window")):
            low, high = sorted((side * 3.0, side * 8.0))
            self.solid(shell, name, "brick wall", (12.0, 0.0, low), (12.3, 10.0, high))
        self.solid(shell, "east wall, below window", "brick wall", (12.0, 0.0, -3.0), (12.3, 1.0, 3.0))
        above = arch(Mesh(), 3.0, 3.0, 4.6, 2.4, 10.0, 0.3, 24, 2.0)
        self.place(shell, "east wall, above window", self.mesh("east wall, above window", (above, "brick arch")),
                   (12.15, 0, 0), rotation=turn_y(90))
        vault = Mesh()
        rows = []
        for i in range(25):
            theta = math.pi * i / 24
            z, y = 8.0 * math.cos(theta), SPRING + 2.15 * math.sin(theta)
            normal = (0.0, -math.sin(theta) / 2.15, -math.cos(theta) / 8.0)
            rows.append([vault.vertex((x, y, z), normal, (x / 2.0, 10.0 * theta / math.pi)) for x in (-12.1, 12.1)])
        vault.grid(rows)
        self.place(shell, "vault", self.mesh("vault", (vault, "vault")))
        rib = self.rib()
        for x in BAYS[1:-1]:
            self.place(shell, "rib %+d" % x, rib, (x, 0, 0))
        # A small court outside the window, so that the glass shows something.
        self.solid(shell, "court floor", "stone", (12.3, -0.3, -6.0), (17.0, -0.05, 6.0))
        self.solid(shell, "court wall", "brick wall", (16.7, -0.05, -6.0), (17.0, 2.8, 6.0))

    def rib(self):
        shape = Mesh()
        sides = {-0.13: [], 0.13: []}
        soffit = []
        for i in range(25):
            theta = math.pi * i / 24
            outer = (SPRING + 2.18 * math.sin(theta), 8.03 * math.cos(theta))
            inner = (SPRING + 1.95 * math.sin(theta), 7.8 * math.cos(theta))
            along = 10.0 * i / 24
            for x, row in sides.items():
                normal = (math.copysign(1.0, x), 0.0, 0.0)
                row.append([shape.vertex((x,) + point, normal, (along, d)) for point, d in ((outer, 0), (inner, 0.22))])
            normal = (0.0, -math.sin(theta) / 1.95, -math.cos(theta) / 7.8)
            soffit.append([shape.vertex((x,) + inner, normal, (along, x)) for x in sides])
        for rows in list(sides.values()) + [soffit]:
            shape.grid(rows)
        return self.mesh("rib", (shape, "wood"))

    def window(self):
        window = self.group("window")
        frame = Mesh(textured=False)
        curve = shapes.arc_points(2.95, 4.6, 2.35, 24)
        for z in (-1.5, 0.0, 1.5):
            top = 4.6 + 2.4 * math.sqrt(1 - (z / 3.0) ** 2)
            box(frame, (-0.05, 1.0, z - 0.05), (0.05, top, z + 0.05), skip="-y+y")
        for y in (2.2, 3.4, 4.6):
            box(frame, (-0.04, y - 0.04, -3.0), (0.04, y + 0.04, 3.0), skip="-z+z")
        tube(frame, [(0.0, y, z) for z, y in curve], 0.08, 8, caps=False)
        self.place(window, "window frame", self.mesh("window frame", (frame, "iron")), (12.1, 0, 0))
        glass = Mesh()
        curve = shapes.arc_points(3.0, 4.6, 2.4, 24)
        normal = (-1.0, 0.0, 0.0)
        glass.grid([[glass.vertex((0.0, y, z), normal, (z / 3.0, -y / 3.0)) for z, y in curve],
                    [glass.vertex((0.0, 1.0, z), normal, (z / 3.0, -1.0 / 3.0)) for z, _ in curve]])
        self.place(window, "window glass", self.mesh("window glass", (glass, "glass")), (12.18, 0, 0))
        sill = self.solid(window, "window sill", "stone", (11.75, 0.94, -3.2), (12.05, 1.04, 3.2))
        return sill

    # Two rows of columns; what stands at +z is the mirror of what stands at -z.

    def columns(self):
        low, high = self.group("columns"), self.group("upper columns")
        profile = [(0.34, -0.02), (0.34, 0.12), (0.30, 0.14), (0.32, 0.18), (0.32, 0.22), (0.27, 0.28), (0.23, 0.34),
                   (0.225, 1.0), (0.21, 1.8), (0.19, 2.35), (0.22, 2.38), (0.22, 2.42), (0.19, 2.45), (0.20, 2.52),
                   (0.27, 2.62), (0.30, 2.66)]
        shape = lathe(Mesh(), profile, 20, 1.5, crease=0.9)
        box(shape, (-0.31, 2.655, -0.31), (0.31, 2.76, 0.31), 1.5)
        mesh = self.mesh("column", (shape, "column"))
        panel = arch(Mesh(), 1.5, 1.22, 2.75, 0.78, GALLERY - 0.2, 0.3, 16, 2.0)
        arch_mesh = self.mesh("arch", (panel, "brick arch"))
        arches = self.group("arches")
        for side, name in ((-1, "north"), (1, "south")):
            mirror = (1, 1, -side)
            for x in BAYS:
                self.place(low, "column %s %+d" % (name, x), mesh, (x, 0, side * ROW), scale=mirror)
                self.place(high, "upper column %s %+d" % (name, x), mesh, (x, GALLERY, side * ROW),
                           scale=(0.6, 1.94, -side * 0.6))
            for x in list(BAYS)[:-1]:
                self.place(arches, "arch %s %+.1f" % (name, x + 1.5), arch_mesh, (x + 1.5, 0, side * ROW), scale=mirror)
        for z in (-2.2, 2.2):
            self.place(low, "column of the landing %+.1f" % z, mesh, (-8.85, 0, z), scale=(0.8, 1.355, 0.8))
        self.solid(low, "beam of the landing", "wood", (-9.0, 3.5, -5.2), (-8.7, 3.78, 5.2))

    def galleries(self):
        galleries = self.group("galleries")
        floors = Mesh()
        box(floors, (-12.05, GALLERY - 0.25, EDGE), (12.05, GALLERY, 8.05))
        mesh = self.mesh("gallery", (floors, "gallery floor"))
        self.place(galleries, "gallery south", mesh)
        self.place(galleries, "gallery north", mesh, scale=(1, 1, -1))
        self.solid(galleries, "landing", "gallery floor", (-12.05, GALLERY - 0.25, -EDGE), (LANDING, GALLERY, EDGE), 1.0)
        rail = Mesh(textured=False)
        tube(rail, [(-1.5, 0.12, 0), (1.5, 0.12, 0)], 0.016, 6, caps=False)
        tube(rail, [(-1.5, 0.55, 0), (1.5, 0.55, 0)], 0.008, 6, caps=False)
        for i in range(20):
            x = -1.425 + 0.15 * i
            tube(rail, [(x, -0.01, 0), (x, 1.02, 0)], 0.009, 6, caps=False)
        mesh = self.mesh("railing", (rail, "iron"))
        hand = tube(Mesh(textured=False), [(-10.375, 0, 0), (10.375, 0, 0)], 0.032, 10)
        hand_mesh = self.mesh("handrail", (hand, "brass"))
        rails = self.group("railings")
        for side, name in ((-1, "north"), (1, "south")):
            for x in list(BAYS)[1:-1]:
                self.place(rails, "railing %s %+.1f" % (name, x + 1.5), mesh, (x + 1.5, GALLERY, side * ROW),
                           scale=(1, 1, -side))
            self.place(rails, "handrail " + name, hand_mesh, (1.625, GALLERY + 1.05, side * ROW))
            self.place(rails, "railing of the landing " + name, mesh, (-8.7, GALLERY, side * 3.325),
                       rotation=turn_y(90), scale=(4.05 / 3.0, 1, side))
            self.place(rails, "handrail of the landing " + name, hand_mesh, (-8.7, GALLERY + 1.05, side * 3.325),
                       rotation=turn_y(90), scale=(4.1 / 20.75, 1, 1))

    def stairs(self):
        stairs = self.group("stairs")
        count, rise, run = 22, GALLERY / 22, 0.26
        tread = self.mesh("tread", (box(Mesh(), (-0.15, -0.05, -1.15), (0.15, 0.0, 1.15)), "wood"))
        for i in range(1, count):
            self.place(stairs, "tread %d" % i, tread, (LANDING + run * (i - 0.5), GALLERY - rise * i, 0))
        foot = LANDING + run * (count - 0.5)
        side = Mesh(textured=False)
        beam(side, (LANDING - 0.05, GALLERY - 0.22, 1.2), (foot, -0.12, 1.2), 0.06, 0.3)
        rail = Mesh(textured=False)
        beam(rail, (LANDING, GALLERY + 0.95, 1.2), (foot - run, 1.0, 1.2), 0.05, 0.05)
        for i in range(1, count):
            x, y = LANDING + run * (i - 0.5), GALLERY - rise * i
            tube(rail, [(x, y - 0.05, 1.2), (x, y + 0.98, 1.2)], 0.01, 6, caps=False)
        box(rail, (LANDING - 0.08, GALLERY - 0.01, 1.16), (LANDING, GALLERY + 1.1, 1.24))
        box(rail, (foot - run, -0.01, 1.16), (foot - run + 0.08, 1.1, 1.24))
        mesh = self.mesh("stair side", (side, "iron"), (rail, "brass"))
        self.place(stairs, "stair side south", mesh)
        self.place(stairs, "stair side north", mesh, scale=(1, 1, -1))

    # Long slanted things.

    def pipes(self):
        pipes = self.group("pipes")
        duct = tube(Mesh(textured=False), [(-11.8, 7.5, 3.9), (11.8, 8.5, 3.9)], 0.22, 20)
        self.place(pipes, "duct", self.mesh("duct", (duct, "painted duct")))
        ring = lathe(Mesh(textured=False), [(0.22, -0.04), (0.27, -0.04), (0.27, 0.04), (0.22, 0.04)], 20)
        ring_mesh = self.mesh("duct ring", (ring, "brushed steel"))
        slant = math.atan2(1.0, 23.6)
        tilt = (0.0, 0.0, math.sin((slant - math.pi / 2) / 2), math.cos((slant - math.pi / 2) / 2))
        for i in range(8):
            x = -10.5 + 3.0 * i
            self.place(pipes, "duct ring %d" % i, ring_mesh, (x, 7.5 + (x + 11.8) / 23.6, 3.9), rotation=tilt)
        for i, (material, z, y) in enumerate((("copper", -7.82, 6.9), ("brushed steel", -7.80, 6.6), ("copper", -7.84, 6.3))):
            radius = (0.07, 0.09, 0.05)[i]
            path = [(-11.9, y - 0.9, z), (-9.0, y - 0.78, z), (10.2, y - 0.02, z)]
            bend = [(10.2 + 0.35 * math.sin(t), y - 0.02 - 0.35 * (1 - math.cos(t)), z)
                    for t in (math.pi / 12 * k for k in range(1, 7))]
            down = [(10.55, GALLERY + 0.9 + 0.2 * i, z), (10.55, GALLERY - 0.05, z)]
            shape = tube(Mesh(textured=material == "brushed steel"), path + bend + down, radius, 12)
            self.place(pipes, "wall pipe %d" % i, self.mesh("wall pipe %d" % i, (shape, material)), (0.12 * i, 0, 0))
        for i, ends in enumerate((((-9.0, 8.95, -5.3), (3.0, 9.15, 5.3)), ((-3.0, 9.25, 5.3), (9.0, 9.05, -5.3)))):
            rod = tube(Mesh(textured=False), ends, 0.02, 6)
            self.place(pipes, "tie rod %d" % i, self.mesh("tie rod %d" % i, (rod, "iron")))

    # Lamps and lights.

    def lamps(self):
        lamps = self.group("lamps")
        shade = lathe(Mesh(textured=False), [(0.30, -0.16), (0.27, -0.06), (0.17, 0.04), (0.05, 0.09)], 24)
        socket = lathe(Mesh(textured=False), [(0.0, -0.02), (0.045, -0.02), (0.05, 0.10), (0.02, 0.16), (0.0, 0.16)], 12)
        mesh = self.mesh("lamp", (shade, "lamp shade"), (socket, "brass"))
        cord = tube(Mesh(textured=False), [(0, 0, 0), (0, 1, 0)], 0.012, 6, caps=False)
        cord_mesh = self.mesh("cord", (cord, "cable"))
        sag = [(0.0, 0.9 * ((i / 12 - 1) ** 2 - 1), -5.4 + 0.45 * i) for i in range(25)]
        cable_mesh = self.mesh("cable", (tube(Mesh(textured=False), sag, 0.015, 6, caps=False), "cable"))
        warm = [1.0, 0.78, 0.5]
        for x in (-5.5, 5.5):
            self.place(lamps, "cable %+.1f" % x, cable_mesh, (x, 7.2, 0))
            for z in (-2.7, 0.0, 2.7):
                height = 7.2 + 0.9 * ((z / 5.4) ** 2 - 1)
                self.place(lamps, "cord %+.1f %+.1f" % (x, z), cord_mesh, (x, height - 0.6, z), scale=(1, 0.6, 1))
                self.place(lamps, "lamp %+.1f %+.1f" % (x, z), mesh, (x, height - 0.76, z))
            light = self.doc.light(name="lamps %+.1f" % x, type="point", color=warm, intensity=14.0, range=14.0)
            self.doc.node(lamps, name="light of lamps %+.1f" % x, translation=(x, 4.6, 0.0), extensions=light)
        for side, name in ((-1, "north"), (1, "south")):
            for x in (-7.5, -1.5, 4.5, 10.5):
                self.place(lamps, "cord %s %+.1f" % (name, x), cord_mesh, (x, 2.76, side * 6.8), scale=(1, 1.0, 1))
                self.place(lamps, "lamp %s %+.1f" % (name, x), mesh, (x, 2.6, side * 6.8))
            light = self.doc.light(name="lamps " + name, type="point", color=warm, intensity=9.0, range=12.0)
            self.doc.node(lamps, name="light of lamps " + name, translation=(1.5, 2.1, side * 6.8), extensions=light)
        casts = {"tessera_shadow": True}
        sun = self.doc.light(name="sun", type="directional", color=[1.0, 0.93, 0.8], intensity=6.0, extras=casts)
        self.doc.node(lamps, name="sun", translation=(14.0, 9.0, 1.0), rotation=aim((-0.76, -0.60, -0.20)),
                      extensions=sun)
        can = lathe(Mesh(textured=False), [(0.0, 0.16), (0.10, 0.16), (0.13, -0.14), (0.12, -0.14), (0.09, 0.12)][::-1], 16)
        can_mesh = self.mesh("spot can", (can, "iron"))
        for name, at, target, colour, power in (
                ("sculpture spot", (4.6, 8.9, -2.2), (1.6, 1.0, 0.0), [1.0, 0.86, 0.66], 150.0),
                ("stair spot", (-2.8, 9.0, 1.6), (-6.0, 2.0, 0.0), [0.75, 0.86, 1.0], 150.0)):
            way = aim(shapes.sub(target, at))
            light = self.doc.light(name=name, type="spot", color=colour, intensity=power, range=16.0, extras=casts,
                                   spot={"innerConeAngle": 0.25, "outerConeAngle": 0.5})
            holder = self.doc.node(lamps, name=name, translation=at, rotation=way, extensions=light)
            self.place(holder, name + " can", can_mesh, (0, 0, 0.15),
                       rotation=(math.sqrt(0.5), 0.0, 0.0, math.sqrt(0.5)))

    def moving_lamp(self):
        rails = self.group("lamp rail")
        self.solid(rails, "rail", "iron", (-6.2, 8.0, -4.26), (6.2, 8.12, -4.14))
        hanger = tube(Mesh(textured=False), [(0, 0, 0), (0, 1.75, 0)], 0.015, 6)
        for x in (-5.8, 0.0, 5.8):
            self.place(rails, "rail hanger %+.1f" % x, self.mesh("rail hanger", (hanger, "iron")), (x, 8.1, -4.2))
        trolley = Mesh(textured=False)
        box(trolley, (-0.18, -0.09, -0.11), (0.18, -0.02, 0.11))
        tube(trolley, [(0, -0.05, 0), (0, -1.25, 0)], 0.012, 6, caps=False)
        shade = lathe(Mesh(textured=False), [(0.34, -1.55), (0.30, -1.42), (0.16, -1.28), (0.03, -1.24)], 24)
        mesh = self.mesh("moving lamp", (trolley, "brass"), (shade, "moving shade"))
        lamp = self.place(rails, "moving lamp", mesh, (-4.8, 8.0, -4.2))
        light = self.doc.light(name="moving lamp", type="spot", color=[0.7, 0.85, 1.0], intensity=110.0, range=12.0,
                               extras={"tessera_shadow": True}, spot={"innerConeAngle": 0.35, "outerConeAngle": 0.62})
        self.doc.node(lamp, name="light of the moving lamp", translation=(0.0, -1.5, 0.0), rotation=aim((0, -1, 0)),
                      extensions=light)
        # There and back: at rest at both ends, fastest in the middle.
        keys = [(0.0, -4.8, 0.0), (2.0, 0.0, 3.2), (4.0, 4.8, 0.0), (6.0, 0.0, -3.2), (8.0, -4.8, 0.0)]
        values = []
        for _, x, speed in keys:
            values += [(speed, 0.0, 0.0), (x, 8.0, -4.2), (speed, 0.0, 0.0)]
        self.doc.animation("moving lamp", lamp, "translation", [k[0] for k in keys], values, "CUBICSPLINE")

    def fan(self):
        fan = self.group("ceiling fan", translation=(0.0, 8.55, 0.0))
        rod = tube(Mesh(textured=False), [(0, 0.1, 0), (0, 1.45, 0)], 0.03, 10)
        lathe(rod, [(0.0, -0.06), (0.16, -0.05), (0.18, 0.06), (0.12, 0.14), (0.0, 0.16)], 20)
        self.place(fan, "fan motor", self.mesh("fan motor", (rod, "brass")))
        blades = Mesh()
        for k in range(4):
            c, s = ((1, 0), (0, 1), (-1, 0), (0, -1))[k]

            def spun(x, y, z):
                return (c * x - s * z, y, s * x + c * z)
            for sign in (1, -1):
                rows = []
                for x in (0.2, 0.6, 1.0, 1.45):
                    half = 0.10 + 0.05 * x
                    rows.append([blades.vertex(spun(x, 0.05 * w + 0.008 * sign, half * w),
                                               spun(0.0, float(sign), -sign * 0.05 / half), (x, w * half))
                                 for w in (-1, 1)])
                blades.grid(rows)
        node = self.place(fan, "fan blades", self.mesh("fan blades", (blades, "dark wood")))
        turns = [turn_y(90 * k) for k in range(5)]
        self.doc.animation("fan", node, "rotation", [0.0, 1.0, 2.0, 3.0, 4.0], turns, "LINEAR")

    # Furniture and small things.

    def furniture(self):
        furniture = self.group("furniture")
        top = lathe(Mesh(), [(0.0, 0.70), (0.62, 0.70), (0.66, 0.73), (0.62, 0.76), (0.0, 0.76)], 32, 0.0)
        leg = lathe(Mesh(textured=False), [(0.34, -0.01), (0.34, 0.03), (0.06, 0.10), (0.05, 0.4), (0.09, 0.66), (0.3, 0.71)], 20)
        table = self.mesh("table", (top, "dark wood"), (leg, "iron"))
        chair = self.chair()
        vase, bowl = self.vases()
        for number, (x, z) in enumerate(((8.3, -3.3), (8.3, 3.3), (4.9, -3.5), (4.9, 3.5), (-0.8, -3.5), (-0.8, 3.5))):
            self.place(furniture, "table %d" % number, table, (x, 0, z))
            for seat in range(4):
                angle = 90 * seat + 25 + 17 * number
                away = (math.sin(math.radians(angle)) * 0.95, 0.0, math.cos(math.radians(angle)) * 0.95)
                self.place(furniture, "chair %d.%d" % (number, seat), chair, add((x, 0, z), away),
                           rotation=turn_y(angle), scale=(-1 if seat % 2 else 1, 1, 1))
            self.place(furniture, "vase on table %d" % number, (vase, bowl)[number % 2], (x, 0.76, z),
                       scale=(0.45, 0.5, 0.45))
        shelf, books = self.shelf()
        for side, name in ((-1, "north"), (1, "south")):
            for x in (-10.5, -4.5, 1.5, 7.5):
                self.place(furniture, "shelf %s %+.1f" % (name, x), shelf, (x, 0, side * 7.8), scale=(1, 1, side))
                self.place(furniture, "books %s %+.1f" % (name, x), books, (x, 0, side * 7.8), scale=(1, 1, side))
            for x in (-10.5, -1.5, 7.5):
                self.place(furniture, "vase %s %+.1f" % (name, x), vase, (x, GALLERY, side * 7.3),
                           rotation=turn_y(40 * x))
            bench = self.bench()
            for x in (-4.5, 4.5):
                self.place(furniture, "bench %s %+.1f" % (name, x), bench, (x, GALLERY, side * 7.3))
        rug = box(Mesh(), (-2.6, 0.0, -1.8), (2.6, 0.02, 1.8), 5.2, skip="-y")
        self.place(furniture, "rug", self.mesh("rug", (rug, "rug")), (1.6, 0.004, 0.0))

    def chair(self):
        seat = box(Mesh(), (-0.21, 0.43, -0.20), (0.21, 0.47, 0.22), 1.0)
        frame = Mesh(textured=False)
        for x in (-0.18, 0.18):
            tube(frame, [(x, -0.005, -0.17), (x, 0.44, -0.17)], 0.016, 8)
            tube(frame, [(x * 1.1, -0.005, 0.24), (x, 0.45, 0.20), (x, 0.70, 0.23), (x, 0.92, 0.30)], 0.016, 8)
        for y, z in ((0.60, 0.215), (0.72, 0.237), (0.84, 0.275)):
            curve = [(0.18 * i / 3, y, z + 0.04 * (1 - (i / 3) ** 2)) for i in range(-3, 4)]
            tube(frame, curve, 0.012, 6)
        return self.mesh("chair", (seat, "wood"), (frame, "iron"))

    def vases(self):
        outer = [(0.0, -0.004), (0.15, -0.004), (0.17, 0.03)]
        outer += [(0.17 + 0.12 * math.sin(math.pi * (i / 12) ** 0.8), 0.03 + 0.62 * i / 12) for i in range(1, 12)]
        outer += [(0.13, 0.67), (0.12, 0.74), (0.16, 0.82), (0.15, 0.83), (0.10, 0.74), (0.09, 0.55), (0.0, 0.5)]
        vase = self.mesh("vase", (lathe(Mesh(textured=False), outer, 24), "blue glaze"))
        bowl = [(0.0, -0.004), (0.16, -0.004), (0.16, 0.05), (0.10, 0.09)]
        bowl += [(0.10 + 0.32 * math.sin(math.pi / 2 * i / 8), 0.12 + 0.3 * (i / 8) ** 2) for i in range(1, 9)]
        bowl += [(0.40, 0.43)] + [(0.09 + 0.29 * math.sin(math.pi / 2 * i / 6), 0.15 + 0.25 * (i / 6) ** 2)
                                  for i in range(6, 0, -1)] + [(0.0, 0.14)]
        return vase, self.mesh("bowl", (lathe(Mesh(textured=False), bowl, 24), "white glaze"))

    def shelf(self):
        wood = Mesh()
        for x in (-0.95, 0.91):
            box(wood, (x, -0.01, -0.18), (x + 0.04, 2.1, 0.18), 1.0)
        levels = [0.10, 0.58, 1.06, 1.54]
        for y in levels + [2.02]:
            box(wood, (-0.91, y - 0.03, -0.17), (0.91, y, 0.175), 1.0, skip="-x+x")
        box(wood, (-0.93, 0.0, 0.16), (0.93, 2.1, 0.18), 1.0, skip="-x+x-y+y")
        books = Mesh(textured=False)
        covers = [(150, 46, 40), (44, 78, 120), (206, 178, 120), (60, 104, 74), (92, 60, 100), (38, 40, 48), (190, 120, 54)]
        for y in levels:
            x = -0.88
            while x < 0.80:
                width = 0.028 + 0.05 * self.random.random()
                height, depth = 0.24 + 0.17 * self.random.random(), 0.2 + 0.06 * self.random.random()
                colour = self.random.choice(covers) + (255,)
                if self.random.random() > 0.12:
                    box(books, (x, y, 0.12 - depth), (x + width, y + height, 0.12), skip="-y+z", colour=colour)
                x += width + 0.004
        return self.mesh("shelf", (wood, "wood")), self.mesh("books", (books, "books"))

    def bench(self):
        shape = Mesh()
        for z in (-0.18, -0.06, 0.06, 0.18):
            box(shape, (-0.9, 0.42, z - 0.05), (0.9, 0.46, z + 0.05), 1.0)
        legs = Mesh(textured=False)
        for x in (-0.75, 0.75):
            box(legs, (x - 0.03, 0.38, -0.2), (x + 0.03, 0.42, 0.2))
            for z in (-0.18, 0.14):
                box(legs, (x - 0.02, -0.005, z), (x + 0.02, 0.38, z + 0.04), skip="+y")
        return self.mesh("bench", (shape, "wood"), (legs, "iron"))

    def art(self):
        art = self.group("art")
        base = lathe(Mesh(textured=False), [(0.7, 0.0), (0.7, 0.12), (0.55, 0.16), (0.52, 0.9), (0.6, 0.96), (0.6, 1.02), (0.0, 1.02)], 32)
        self.place(art, "pedestal", self.mesh("pedestal", (base, "stone")), (1.6, 0.01, 0.0))
        knot = shapes.torus_knot(Mesh(textured=False), 2, 3, 0.52, 0.22, 0.105, 144, 14)
        self.place(art, "knot", self.mesh("knot", (knot, "gold")), (1.6, 1.85, 0.0),
                   rotation=(math.sqrt(0.5), 0.0, 0.0, math.sqrt(0.5)))
        self.solid(art, "plinth of the spheres", "stone", (10.9, -0.01, -2.6), (11.5, 0.8, 2.6), skip="-y")
        ball = [(0.27 * math.sin(math.pi * i / 14), -0.27 * math.cos(math.pi * i / 14)) for i in range(15)]
        sphere = lathe(Mesh(textured=False), ball, 24)
        for step in range(5):
            self.place(art, "sphere %d" % step, self.mesh("sphere %d" % step, (sphere, "steel %d" % step)),
                       (11.2, 1.065, -2.0 + step))

    def plants(self):
        plants = self.group("plants")
        pot = lathe(Mesh(textured=False), [(0.0, -0.005), (0.18, -0.005), (0.25, 0.36), (0.28, 0.37), (0.28, 0.43), (0.24, 0.43), (0.22, 0.36)], 20)
        soil = lathe(Mesh(textured=False), [(0.235, 0.37), (0.0, 0.38)], 20)
        pot_mesh = self.mesh("pot", (pot, "clay"), (soil, "earth"))
        leaves = Mesh()
        for i in range(44):
            angle, lean = 2.399963 * i, 0.25 + 0.95 * (i / 44)
            length, wide = 0.5 + 0.35 * self.random.random(), 0.10 + 0.05 * self.random.random()
            out, across = (math.cos(angle), 0.0, math.sin(angle)), (-math.sin(angle), 0.0, math.cos(angle))
            start, rows = (0.05 * out[0], 0.42 + 0.6 * (1 - i / 44), 0.05 * out[2]), []
            for k in range(4):
                t = k / 3
                bend = lean + 0.9 * t
                point = add(start, add(scaled(out, length * t * math.sin(bend)), (0, length * t * math.cos(bend), 0)))
                normal = add(scaled(out, -math.cos(bend)), (0.0, math.sin(bend), 0.0))
                rows.append([leaves.vertex(add(point, scaled(across, w * wide)), add(normal, scaled(across, 0.25 * w)),
                                           ((w + 1) / 2, 1 - t)) for w in (-1, 1)])
            leaves.grid(rows)
        stem = tube(Mesh(textured=False), [(0, 0.35, 0), (0.01, 0.7, 0.01), (0, 1.1, 0)], 0.02, 6, caps=False)
        leaf_mesh = self.mesh("leaves", (leaves, "leaf"), (stem, "earth"))
        places = [(-2.2, 0, -1.9), (-2.2, 0, 1.9), (-11.2, 0, -4.4), (-11.2, 0, 4.4), (11.2, 0, -6.6), (11.2, 0, 6.6),
                  (11.2, GALLERY, -7.2), (11.2, GALLERY, 7.2), (-11.2, GALLERY, -1.9), (-11.2, GALLERY, 1.9),
                  (15.6, -0.05, -2.0), (15.6, -0.05, 0.4), (15.6, -0.05, 2.3)]
        for number, at in enumerate(places):
            size = 1.0 + 0.25 * self.random.random()
            at = (at[0], at[1] + 0.004, at[2])
            self.place(plants, "pot %d" % number, pot_mesh, at, scale=(size,) * 3)
            self.place(plants, "leaves %d" % number, leaf_mesh, at, rotation=turn_y(67 * number),
                       scale=(-size if number % 2 else size, size * 1.15, size))

    def words(self):
        """Signs, notices and banners: pictures that must stay legible."""
        words = self.group("words")

        def panel(width, height):
            """A picture in the yz plane that is read from +x."""
            shape = Mesh()
            shape.grid([[shape.vertex((0.0, y, z), (1.0, 0.0, 0.0), (u, v)) for u, z in ((0, width / 2), (1, -width / 2))]
                        for v, y in ((0, height / 2), (1, -height / 2))])
            return shape

        sign = self.mesh("hall sign", (panel(4.8, 0.6), "hall sign"))
        self.place(words, "hall sign", sign, (11.96, 7.55, 0.0), rotation=turn_y(180))
        exit_sign = self.mesh("exit sign", (panel(0.77, 0.33), "exit sign"))
        notice = self.mesh("notice", (panel(1.5, 1.2), "notice"))
        board = box(Mesh(), (-0.06, -0.66, -0.81), (-0.004, 0.66, 0.81), 1.0)
        for z in (-0.7, 0.7):
            box(board, (-0.055, -1.45, z - 0.03), (-0.01, -0.6, z + 0.03), 1.0)
        board_mesh = self.mesh("board", (board, "dark wood"))
        for at, angle in (((-2.0, 1.44, -3.0), 20), ((-2.0, 1.44, 3.0), -20), ((-11.9, 5.6, -3.6), 0), ((-11.9, 5.6, 3.6), 0)):
            name = "%+.1f %+.1f" % (at[0], at[2])
            self.place(words, "notice " + name, notice, at, rotation=turn_y(angle))
            self.place(words, "board " + name, board_mesh, at, rotation=turn_y(angle))
        door = self.mesh("door", (box(Mesh(), (0.0, 0.0, -0.55), (0.06, 2.2, 0.55), 1.1, skip="-x-y"), "dark wood"))
        for z, y in ((-6.6, 0.0), (6.6, 0.0), (0.0, GALLERY)):
            self.place(words, "door %+.1f" % z, door, (-12.0, y, z))
            self.place(words, "exit sign %+.1f" % z, exit_sign, (-11.97, y + 2.5, z))
        cloth = Mesh()  # printed on both sides, a finger apart
        for side in (1, -1):
            rows = []
            for i in range(13):
                y = 1.6 - 3.2 * i / 12
                row = []
                for k in range(7):
                    z = side * (0.62 - 1.24 * k / 6)
                    x, slope = 0.05 * math.sin(4 * z + 1.3 * y), 0.2 * math.cos(4 * z + 1.3 * y)
                    row.append(cloth.vertex((x + 0.006 * side, y, z), (side, -0.325 * slope * side, -slope * side),
                                            (k / 6, i / 12)))
                rows.append(row)
            cloth.grid(rows)
        pole = tube(Mesh(textured=False), [(0, 1.62, -0.72), (0, 1.62, 0.72)], 0.025, 8)
        for z in (-0.6, 0.6):
            tube(pole, [(0, 1.62, z), (0, 3.2, z)], 0.006, 6, caps=False)
        banner = self.mesh("banner", (cloth, "banner"), (pole, "brass"))
        for x, z in ((-3.0, -2.9), (-3.0, 2.9), (3.0, -2.9), (3.0, 2.9)):
            self.place(words, "banner %+.1f %+.1f" % (x, z), banner, (x, 6.95, z), scale=(1, 0.85, 1))

    def cameras(self):
        views = self.group("cameras")
        for name, eye, target, fov in (("entrance", (10.2, 1.75, 3.9), (-4.0, 3.2, -0.6), 65),
                                       ("landing", (-10.6, 5.7, 0.4), (6.0, 3.6, -0.3), 65),
                                       ("gallery", (7.4, 5.6, 6.6), (-3.0, 4.0, -2.0), 60),
                                       ("reading", (0.2, 1.6, 2.3), (-2.0, 1.44, 3.0), 45)):
            camera = self.doc.camera(name, round(math.radians(fov), 5))
            self.doc.node(views, name=name, translation=eye, rotation=level_aim(shapes.sub(target, eye)), camera=camera)

    def build(self):
        for part in (self.shell, self.window, self.columns, self.galleries, self.stairs, self.pipes, self.lamps,
                     self.moving_lamp, self.fan, self.furniture, self.art, self.plants, self.words, self.cameras):
            part()
        return self.doc


def level_aim(direction):
    """As aim, but upright: first about y, then about the camera's own x."""
    d = shapes.unit(direction)
    yaw, pitch = math.atan2(-d[0], -d[2]) / 2, math.asin(d[1]) / 2
    return (math.cos(yaw) * math.sin(pitch), math.sin(yaw) * math.cos(pitch), -math.sin(yaw) * math.sin(pitch),
            math.cos(yaw) * math.cos(pitch))


def main():
    output = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).with_name("atrium.glb")
    doc = Atrium().build()
    data = doc.encode()
    output.write_bytes(data)
    instanced, unique = doc.triangles()
    objects = sum("mesh" in node for node in doc.json["nodes"])
    print("%s: %d triangles (%d unique) in %d objects, %d materials, %.2f MB"
          % (output.name, instanced, unique, objects, len(doc.json["materials"]), len(data) / 1e6))


if __name__ == "__main__":
    main()
