"""Collects meshes, materials, nodes and animations into a binary glTF 2.0 file."""
import json
import struct

from . import png

_FLOAT, _BYTE, _SHORT = 5126, 5121, 5123
_VERTEX_TARGET, _INDEX_TARGET = 34962, 34963
_KINDS = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4"}


def _single(value):
    """The value as the file holds it, so that the bounds of an accessor are exact."""
    return struct.unpack("<f", struct.pack("<f", value))[0]


class Document:
    def __init__(self, generator):
        self.json = {"asset": {"version": "2.0", "generator": generator}, "scene": 0}
        self._binary = bytearray()
        self._extensions = set()
        self._with_tangents = set()  # materials whose meshes bring tangents; for others the reader makes them
        self._meshes = {}
        self._shapes = {}

    def _append(self, key, value):
        self.json.setdefault(key, []).append(value)
        return len(self.json[key]) - 1

    def extension(self, name):
        self._extensions.add(name)
        return name

    def _view(self, data, **more):
        self._binary += bytes(-len(self._binary) % 4)
        offset = len(self._binary)
        self._binary += data
        return self._append("bufferViews", dict(buffer=0, byteOffset=offset, byteLength=len(data), **more))

    def _accessor(self, rows, kind, target=None, bounds=False, normalised=False):
        """An accessor of its own view over rows of numbers."""
        width = len(rows[0])
        code = {_FLOAT: "f", _BYTE: "B", _SHORT: "H"}[kind]
        data = struct.pack("<%d%s" % (width * len(rows), code), *(v for row in rows for v in row))
        more = {"target": target} if target else {}
        accessor = {"bufferView": self._view(data, **more), "componentType": kind, "count": len(rows),
                    "type": _KINDS[width]}
        if normalised:
            accessor["normalized"] = True
        if bounds:
            columns = list(zip(*rows))
            accessor["min"] = [_single(min(c)) for c in columns]
            accessor["max"] = [_single(max(c)) for c in columns]
        return self._append("accessors", accessor)

    def texture(self, image, name, repeat=True):
        wrap = 10497 if repeat else 33071
        sampler = {"magFilter": 9729, "minFilter": 9987, "wrapS": wrap, "wrapT": wrap}
        samplers = self.json.setdefault("samplers", [])
        if sampler not in samplers:
            samplers.append(sampler)
        view = self._view(png.encode(image))
        source = self._append("images", {"bufferView": view, "mimeType": "image/png", "name": name})
        return self._append("textures", {"sampler": samplers.index(sampler), "source": source, "name": name})

    def material(self, name, colour=(1.0, 1.0, 1.0, 1.0), metallic=0.0, roughness=0.8, tangents=False, **more):
        """`more` is glTF as it stands, but for "base" and "surface": textures of colour and of metal-roughness."""
        surface = {"baseColorFactor": list(colour), "metallicFactor": metallic, "roughnessFactor": roughness}
        for key, slot in (("base", "baseColorTexture"), ("surface", "metallicRoughnessTexture")):
            if key in more:
                surface[slot] = more.pop(key)
        for extension in more.get("extensions", {}):
            self.extension(extension)
        index = self._append("materials", dict(name=name, pbrMetallicRoughness=surface, **more))
        if tangents:
            self._with_tangents.add(index)
        return index

    def mesh(self, name, *parts):
        """A mesh of (shape, material) pairs. Shapes used twice share their data."""
        key = tuple((id(shape), material) for shape, material in parts)
        if key not in self._meshes:
            primitives = [self._primitive(shape, material) for shape, material in parts]
            self._meshes[key] = (self._append("meshes", {"name": name, "primitives": primitives}), parts)
        return self._meshes[key][0]

    def _primitive(self, shape, material):
        text = json.dumps(self.json["materials"][material])
        wants = {"TEXCOORD_0": '"index"' in text, "TEXCOORD_1": '"texCoord": 1' in text,
                 "TANGENT": material in self._with_tangents}
        makers = {
            "POSITION": lambda: self._accessor([v[0] for v in shape.vertices], _FLOAT, _VERTEX_TARGET, bounds=True),
            "NORMAL": lambda: self._accessor([v[1] for v in _renormalised(shape)], _FLOAT, _VERTEX_TARGET),
            "TEXCOORD_0": lambda: self._accessor([v[2] for v in shape.vertices], _FLOAT, _VERTEX_TARGET),
            "TEXCOORD_1": lambda: self._accessor(_unwrapped(shape), _FLOAT, _VERTEX_TARGET),
            "TANGENT": lambda: self._accessor(shape.tangents(), _FLOAT, _VERTEX_TARGET),
            "COLOR_0": lambda: self._accessor([v[3] for v in shape.vertices], _BYTE, _VERTEX_TARGET, normalised=True),
        }
        wants.update(POSITION=True, NORMAL=True, COLOR_0=shape.vertices[0][3] is not None)
        held = self._shapes.setdefault(id(shape), {"shape": shape})
        attributes = {}
        for name, make in makers.items():
            if not wants.get(name):
                continue
            if name not in held:
                held[name] = make()
            attributes[name] = held[name]
        if "indices" not in held:
            assert len(shape.vertices) < 65535
            held["indices"] = self._accessor([(i,) for t in shape.triangles for i in t], _SHORT, _INDEX_TARGET)
        return {"attributes": attributes, "indices": held["indices"], "material": material}

    def light(self, **light):
        self.extension("KHR_lights_punctual")
        lights = self.json.setdefault("extensions", {}).setdefault("KHR_lights_punctual", {"lights": []})["lights"]
        lights.append(light)
        return {"KHR_lights_punctual": {"light": len(lights) - 1}}

    def camera(self, name, fov_y, near=0.05, far=100.0):
        return self._append("cameras", {"name": name, "type": "perspective",
                                        "perspective": {"yfov": fov_y, "znear": near, "zfar": far}})

    def node(self, parent=None, **node):
        index = self._append("nodes", {k: list(v) if isinstance(v, tuple) else v for k, v in node.items()})
        if parent is None:
            self.json.setdefault("scenes", [{"nodes": []}])[0]["nodes"].append(index)
        else:
            self.json["nodes"][parent].setdefault("children", []).append(index)
        return index

    def animation(self, name, node, path, times, values, interpolation):
        source = self._accessor([(t,) for t in times], _FLOAT, bounds=True)
        result = self._accessor(values, _FLOAT)
        self._append("animations", {
            "name": name, "channels": [{"sampler": 0, "target": {"node": node, "path": path}}],
            "samplers": [{"input": source, "output": result, "interpolation": interpolation}]})

    def triangles(self):
        """As instanced, and unique."""
        count = [sum(self.json["accessors"][p["indices"]]["count"] // 3 for p in mesh["primitives"])
                 for mesh in self.json["meshes"]]
        return sum(count[node["mesh"]] for node in self.json["nodes"] if "mesh" in node), sum(count)

    def encode(self):
        if self._extensions:
            self.json["extensionsUsed"] = sorted(self._extensions)
        self._binary += bytes(-len(self._binary) % 4)
        self.json["buffers"] = [{"byteLength": len(self._binary)}]
        text = json.dumps(self.json, separators=(",", ":")).encode()
        text += b" " * (-len(text) % 4)
        chunks = struct.pack("<II", len(text), 0x4E4F534A) + text
        chunks += struct.pack("<II", len(self._binary), 0x004E4942) + bytes(self._binary)
        return struct.pack("<III", 0x46546C67, 2, 12 + len(chunks)) + chunks


def _renormalised(shape):
    """Normals at single precision are unit length to the last digits only if they are so in double."""
    from .shapes import unit
    return [(v[0], unit(v[1])) for v in shape.vertices]


def _unwrapped(shape):
    """A second UV set: the first one scaled to 0..1 over the whole shape."""
    us, vs = zip(*(v[2] for v in shape.vertices))
    low, size = (min(us), min(vs)), (max(us) - min(us), max(vs) - min(vs))
    return [((v[2][0] - low[0]) / size[0], (v[2][1] - low[1]) / size[1]) for v in shape.vertices]
