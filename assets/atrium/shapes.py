"""Triangle meshes. A vertex is (position, normal, uv[, colour]); equal vertices are one, as exporters write them."""
import math

TAU = 2 * math.pi


def add(a, b):
    return tuple(p + q for p, q in zip(a, b))


def sub(a, b):
    return tuple(p - q for p, q in zip(a, b))


def scaled(a, s):
    return tuple(p * s for p in a)


def dot(a, b):
    return sum(p * q for p, q in zip(a, b))


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def unit(a):
    length = math.sqrt(dot(a, a))
    return scaled(a, 1 / length)


def _rounded(values, digits):
    return tuple(round(v, digits) + 0.0 for v in values)


class Mesh:
    """Vertices and triangles. Triangles wind to agree with their normals, whichever way round they are given."""

    def __init__(self, textured=True):
        self._textured = textured  # without, vertices that differ in uv alone are one
        self.vertices = []
        self.triangles = []
        self._index = {}

    def vertex(self, position, normal, uv=(0.0, 0.0), colour=None):
        uv = _rounded(uv, 4) if self._textured else (0.0, 0.0)
        key = (_rounded(position, 4), _rounded(unit(normal), 4), uv, colour)
        if key not in self._index:
            self._index[key] = len(self.vertices)
            self.vertices.append(key)
        return self._index[key]

    def triangle(self, a, b, c):
        pa, pb, pc = (self.vertices[i][0] for i in (a, b, c))
        face = cross(sub(pb, pa), sub(pc, pa))
        if dot(face, face) < 1e-14:
            return
        toward = add(add(self.vertices[a][1], self.vertices[b][1]), self.vertices[c][1])
        self.triangles.append((a, b, c) if dot(face, toward) > 0 else (a, c, b))

    def quad(self, a, b, c, d):
        self.triangle(a, b, c)
        self.triangle(a, c, d)

    def grid(self, rows):
        """Quads between neighbouring rows of vertex indices."""
        for upper, lower in zip(rows, rows[1:]):
            for i in range(len(upper) - 1):
                self.quad(upper[i], upper[i + 1], lower[i + 1], lower[i])

    def tangents(self):
        """One (x, y, z, w) a vertex from the UVs, w the sign of the bitangent; v grows down the picture in glTF."""
        sums = [((0.0,) * 3, (0.0,) * 3) for _ in self.vertices]
        for triangle in self.triangles:
            p, q, r = (self.vertices[i] for i in triangle)
            e1, e2 = sub(q[0], p[0]), sub(r[0], p[0])
            (u1, v1), (u2, v2) = sub(q[2], p[2]), sub(r[2], p[2])
            area = u1 * v2 - u2 * v1
            along_u = scaled(sub(scaled(e1, v2), scaled(e2, v1)), 1 / area)
            along_v = scaled(sub(scaled(e2, u1), scaled(e1, u2)), 1 / area)
            for i in triangle:
                sums[i] = (add(sums[i][0], along_u), add(sums[i][1], along_v))
        result = []
        for (_, normal, _, _), (along_u, along_v) in zip(self.vertices, sums):
            tangent = unit(sub(along_u, scaled(normal, dot(normal, along_u))))
            sign = -1.0 if dot(cross(normal, tangent), along_v) > 0 else 1.0
            result.append(_rounded(tangent, 5) + (sign,))
        return result


def box(mesh, low, high, tile=1.0, skip="", colour=None):
    """An axis-aligned box; uv in units of `tile` metres. `skip` names faces to leave out: "-y+y", …"""
    for axis in range(3):
        for side in (-1, 1):
            if ("+" if side > 0 else "-") + "xyz"[axis] in skip:
                continue
            normal = tuple(float(side) if i == axis else 0.0 for i in range(3))
            # u runs along the horizontal, v down: over x and z on level faces.
            u_axis, v_axis = ((2, 1), (0, 2), (0, 1))[axis]
            corners = []
            for u_end, v_end in ((0, 0), (1, 0), (1, 1), (0, 1)):
                p = [0.0, 0.0, 0.0]
                p[axis] = (low, high)[side > 0][axis]
                p[u_axis] = (low, high)[u_end][u_axis]
                p[v_axis] = (low, high)[v_end][v_axis]
                v = p[v_axis] if axis == 1 else -p[v_axis]
                corners.append(mesh.vertex(p, normal, (p[u_axis] / tile, v / tile), colour))
            mesh.quad(*corners)
    return mesh


def beam(mesh, start, end, width, height, tile=1.0):
    """A bar of rectangular section between two points that differ in x or z as well as y; `height` is upright."""
    along = unit(sub(end, start))
    side = unit(cross(along, (0.0, 1.0, 0.0)))
    up = cross(side, along)
    length = math.sqrt(dot(sub(end, start), sub(end, start)))
    offsets = [(-1, -1), (1, -1), (1, 1), (-1, 1)]
    rings = [[add(centre, add(scaled(side, i * width / 2), scaled(up, j * height / 2))) for i, j in offsets]
             for centre in (start, end)]
    for i in range(4):
        j = (i + 1) % 4
        normal = (scaled(up, -1), side, up, scaled(side, -1))[i]
        across = (width, height)[i % 2] / tile
        mesh.quad(mesh.vertex(rings[0][i], normal, (0, 0)), mesh.vertex(rings[0][j], normal, (across, 0)),
                  mesh.vertex(rings[1][j], normal, (across, length / tile)),
                  mesh.vertex(rings[1][i], normal, (0, length / tile)))
    for ring, normal in ((rings[0], scaled(along, -1)), (rings[1], along)):
        mesh.quad(*(mesh.vertex(p, normal, ((i + 1) * width / 2 / tile, (j + 1) * height / 2 / tile))
                    for p, (i, j) in zip(ring, offsets)))
    return mesh


def lathe(mesh, profile, segments, tile=0.0, colour=None, crease=0.8):
    """Turns a profile of (radius, y), from the bottom up with the outside to its right, about the y axis.

    Corners sharper than `crease` radians are split. uv: around the axis, and along the profile; in units of `tile`
    metres, or 0 to 1 where tile is 0.
    """
    slopes = [math.atan2(b[1] - a[1], b[0] - a[0]) for a, b in zip(profile, profile[1:])]
    lengths = [math.hypot(b[0] - a[0], b[1] - a[1]) for a, b in zip(profile, profile[1:])]
    total, around = sum(lengths), max(r for r, _ in profile) * TAU
    turns = max(1, round(around / tile)) if tile else 1
    place = 0.0
    for i, ((a, b), slope, length) in enumerate(zip(zip(profile, profile[1:]), slopes, lengths)):
        rows = []
        for (radius, y), other, distance in ((a, i - 1, place), (b, i + 1, place + length)):
            angle = slope
            if 0 <= other < len(slopes):
                turn = (slopes[other] - slope + math.pi) % TAU - math.pi
                if abs(turn) < crease:
                    angle = slope + turn / 2
            row = []
            for s in range(segments + 1):
                theta = TAU * (s % segments) / segments
                normal = (math.sin(angle) * math.cos(theta), -math.cos(angle), math.sin(angle) * math.sin(theta))
                v = -distance / tile if tile else 1 - distance / total
                row.append(mesh.vertex((radius * math.cos(theta), y, radius * math.sin(theta)), normal,
                                       (turns * s / segments, v), colour))
            rows.append(row)
        mesh.grid(rows)
        place += length
    return mesh


def tube(mesh, points, radius, segments, caps=True, closed=False):
    """A round pipe along points, smooth around and along; uv: once around, metres along."""
    count = len(points)
    directions = []
    for i in range(count):
        before = points[i - 1] if closed or i > 0 else points[i]
        after = points[(i + 1) % count] if closed or i + 1 < count else points[i]
        directions.append(unit(sub(after, before)))
    first = (0.0, 1.0, 0.0) if abs(directions[0][1]) < 0.9 else (1.0, 0.0, 0.0)
    side = unit(cross(directions[0], first))
    rows, along = [], 0.0
    for i in range(count + (1 if closed else 0)):
        direction, centre = directions[i % count], points[i % count]
        side = unit(sub(side, scaled(direction, dot(side, direction))))
        up = cross(side, direction)
        if i:
            step = sub(points[i % count], points[i - 1])
            along += math.sqrt(dot(step, step))
        row = []
        for s in range(segments + 1):
            theta = TAU * (s % segments) / segments
            normal = add(scaled(side, math.cos(theta)), scaled(up, math.sin(theta)))
            row.append(mesh.vertex(add(centre, scaled(normal, radius)), normal, (s / segments, along)))
        rows.append(row)
    if closed:  # the frame comes back turned: join the last ring to the corner of the first that is nearest
        rows[-1] = _turned_to_match(mesh, rows[0], rows[-1])
    mesh.grid(rows)
    if caps and not closed:
        for centre, direction in ((points[0], scaled(directions[0], -1)), (points[-1], directions[-1])):
            ring = rows[0] if centre is points[0] else rows[-1]
            middle = mesh.vertex(centre, direction, (0.5, 0.5))
            rim = [mesh.vertex(mesh.vertices[v][0], direction, (0, 0)) for v in ring]
            for a, b in zip(rim, rim[1:]):
                mesh.triangle(middle, a, b)
    return mesh


def _turned_to_match(mesh, first, last):
    target = mesh.vertices[last[0]][0]
    ring = first[:-1]
    distance = [dot(sub(mesh.vertices[v][0], target), sub(mesh.vertices[v][0], target)) for v in ring]
    start = distance.index(min(distance))
    turned = ring[start:] + ring[:start]
    return turned + turned[:1]


def arc_points(half_span, spring, rise, segments):
    """Points (x, y) of half an ellipse over an opening, from right to left."""
    return [(half_span * math.cos(math.pi * i / segments), spring + rise * math.sin(math.pi * i / segments))
            for i in range(segments + 1)]


def arch(mesh, half_width, half_span, spring, rise, top, thickness, segments, tile=1.0):
    """A wall panel in the xy plane over a half-elliptic opening, with piers down to the spring beside it."""
    curve = arc_points(half_span, spring, rise, segments)
    half = thickness / 2
    for z, normal in ((half, (0.0, 0.0, 1.0)), (-half, (0.0, 0.0, -1.0))):
        def point(x, y):
            return mesh.vertex((x, y, z), normal, (x / tile, -y / tile))
        outline = list(curve)
        upper = [(x, top) for x, _ in curve]
        if half_width > half_span:
            outline = [(half_width, spring)] + outline + [(-half_width, spring)]
            upper = [(half_width, top)] + upper + [(-half_width, top)]
        mesh.grid([[point(x, y) for x, y in upper], [point(x, y) for x, y in outline]])
    rows, along = [], 0.0
    for i, (x, y) in enumerate(curve):
        theta = math.pi * i / segments
        normal = (-math.cos(theta) / half_span, -math.sin(theta) / rise, 0.0)
        if i:
            along += math.hypot(x - curve[i - 1][0], y - curve[i - 1][1])
        rows.append([mesh.vertex((x, y, z), normal, (along / tile, z / tile)) for z in (-half, half)])
    mesh.grid(rows)
    if half_width > half_span:
        for side in (-1, 1):
            a, b = side * half_span, side * half_width
            mesh.quad(*(mesh.vertex((x, spring, z), (0.0, -1.0, 0.0), (x / tile, z / tile))
                        for x, z in ((a, -half), (b, -half), (b, half), (a, half))))
    return mesh


def torus_knot(mesh, p, q, radius, inner, thickness, steps, segments):
    points = []
    for i in range(steps):
        t = TAU * i / steps
        r = radius + inner * math.cos(q * t)
        points.append((r * math.cos(p * t), inner * 1.6 * math.sin(q * t), r * math.sin(p * t)))
    return tube(mesh, points, thickness, segments, closed=True)
