#!/usr/bin/env python3
"""Reads .glb files for the peers, independently of the renderer, and writes copies that lack one effect.

    python tools/peers/gltf.py SCENE.glb COPY.glb --without normal,specular

All three renderers can be given the copy. That is how a difference is traced to its cause.
"""

import argparse
import io
import json
import math
import struct
from pathlib import Path

import numpy as np

EFFECTS = {
    "normal": "normal maps",
    "specular": "dielectric reflection of opaque surfaces: specularFactor 0",
    "metal": "metals become Lambertian",
    "glass": "transmission: such surfaces become Lambertian",
    "absorption": "absorption in solids",
    "mask": "alpha masks: opaque",
    "textures": "base colour textures",
    "animation": "animations: the scene is at rest",
}


def reflects_nothing(material):
    material.setdefault("extensions", {})["KHR_materials_specular"] = {"specularFactor": 0}


class Gltf:
    COMPONENTS = {5120: np.int8, 5121: np.uint8, 5122: np.int16, 5123: np.uint16, 5125: np.uint32, 5126: np.float32}
    WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}

    def __init__(self, path):
        data = Path(path).read_bytes()
        magic, _, length = struct.unpack_from("<4sII", data, 0)
        if magic != b"glTF":
            raise SystemExit(f"{path}: is not a .glb file")
        at, chunks = 12, {}
        while at < length:
            size, kind = struct.unpack_from("<I4s", data, at)
            chunks[kind] = data[at + 8 : at + 8 + size]
            at += 8 + size
        self.json = json.loads(chunks[b"JSON"])
        self.binary = chunks.get(b"BIN\0", b"")

    def write(self, path):
        text = json.dumps(self.json).encode()
        text += b" " * (-len(text) % 4)
        binary = self.binary + b"\0" * (-len(self.binary) % 4)
        chunks = struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(binary), b"BIN\0") + binary
        Path(path).write_bytes(struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks)

    def without(self, effects):
        """Takes effects away; see EFFECTS."""
        for effect in effects:
            if effect not in EFFECTS:
                raise SystemExit(f"--without {effect}: not one of {', '.join(EFFECTS)}")
        for material in self.json.get("materials", []):
            pbr = material.setdefault("pbrMetallicRoughness", {})
            extensions = material.get("extensions", {})
            transmits = "KHR_materials_transmission" in extensions
            metal = pbr.get("metallicFactor", 1) > 0
            if "normal" in effects:
                material.pop("normalTexture", None)
            if "specular" in effects and not transmits and not metal:
                reflects_nothing(material)
            if "metal" in effects and metal:
                pbr["metallicFactor"] = 0
                reflects_nothing(material)
            if "glass" in effects and transmits:
                extensions.pop("KHR_materials_transmission")
                extensions.pop("KHR_materials_volume", None)
                reflects_nothing(material)
            if "absorption" in effects:
                volume = extensions.get("KHR_materials_volume", {})
                volume.pop("attenuationColor", None)
                volume.pop("attenuationDistance", None)
            if "mask" in effects:
                material.pop("alphaMode", None)
                material.pop("alphaCutoff", None)
            if "textures" in effects:
                pbr.pop("baseColorTexture", None)
        if "animation" in effects:
            self.json.pop("animations", None)

    def accessor(self, index):
        accessor = self.json["accessors"][index]
        if "sparse" in accessor or "bufferView" not in accessor:
            raise SystemExit(f"accessors[{index}]: sparse and empty ones are not known here")
        view = self.json["bufferViews"][accessor["bufferView"]]
        if "extensions" in view:
            raise SystemExit(f"bufferViews[{accessor['bufferView']}]: compression is not known here")
        width = self.WIDTHS[accessor["type"]]
        kind = np.dtype(self.COMPONENTS[accessor["componentType"]])
        start = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
        stride = view.get("byteStride", width * kind.itemsize)
        values = np.ndarray((accessor["count"], width), kind, self.binary, start, (stride, kind.itemsize))
        if accessor.get("normalized"):
            values = values / np.iinfo(kind).max
        return values if width > 1 else values[:, 0]

    def image(self, index):
        """Pixels of a texture's image, RGBA in [0, 1] as stored, the top row first."""
        from PIL import Image

        texture = self.json["textures"][index]
        view = self.json["bufferViews"][self.json["images"][texture["source"]]["bufferView"]]
        start = view.get("byteOffset", 0)
        image = Image.open(io.BytesIO(self.binary[start : start + view["byteLength"]]))
        return np.asarray(image.convert("RGBA"), dtype=np.float32) / 255

    def nodes(self):
        """Index, node and matrix to world space of every node of the scene."""

        def visit(index, parent):
            node = self.json["nodes"][index]
            if "matrix" in node:
                local = np.array(node["matrix"], float).reshape(4, 4).T
            else:
                local = np.eye(4)
                x, y, z, w = node.get("rotation", [0, 0, 0, 1])
                local[:3, :3] = np.array([
                    [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                    [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                    [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
                ]) * np.array(node.get("scale", [1, 1, 1]))
                local[:3, 3] = node.get("translation", [0, 0, 0])
            matrix = parent @ local
            yield index, node, matrix
            for child in node.get("children", []):
                yield from visit(child, matrix)

        for index in self.json["scenes"][self.json.get("scene", 0)]["nodes"]:
            yield from visit(index, np.eye(4))

    def camera(self, number):
        """Matrix without scale, and vertical field of view in radians, of the camera with a number in the file."""
        for _, node, matrix in self.nodes():
            if node.get("camera") == number:
                matrix = matrix.copy()
                back = matrix[:3, 2] / np.linalg.norm(matrix[:3, 2])
                right = np.cross(matrix[:3, 1], back)
                right /= np.linalg.norm(right)
                matrix[:3, :3] = np.array([right, np.cross(back, right), back]).T
                return matrix, self.json["cameras"][number]["perspective"]["yfov"]
        raise SystemExit(f"no node of the scene has camera {number}")

    def lights(self):
        """Light and matrix of every punctual light."""
        for _, node, matrix in self.nodes():
            reference = node.get("extensions", {}).get("KHR_lights_punctual")
            if reference:
                yield self.json["extensions"]["KHR_lights_punctual"]["lights"][reference["light"]], matrix

    def primitives(self):
        """Name, positions, normals, texture coordinates, triangles and material of every primitive, in world space."""
        placed = list(self.nodes())
        matrices = {index: matrix for index, _, matrix in placed}
        for _, node, matrix in placed:
            if "mesh" not in node:
                continue
            for primitive in self.json["meshes"][node["mesh"]]["primitives"]:
                if primitive.get("mode", 4) != 4:
                    raise SystemExit(f"{node.get('name')}: only triangles are known here")
                attributes = primitive["attributes"]
                positions = self.accessor(attributes["POSITION"]).astype(float)
                count = len(positions)
                triangles = (
                    self.accessor(primitive["indices"]) if "indices" in primitive else np.arange(count)
                ).reshape(-1, 3)
                normals = self.accessor(attributes["NORMAL"]).astype(float) if "NORMAL" in attributes else None
                uvs = {
                    i: self.accessor(attributes[f"TEXCOORD_{i}"]).astype(float)
                    for i in range(4) if f"TEXCOORD_{i}" in attributes
                }
                placement = np.broadcast_to(matrix, (count, 4, 4))
                if "skin" in node and "JOINTS_0" in attributes:
                    skin = self.json["skins"][node["skin"]]
                    inverse = self.accessor(skin["inverseBindMatrices"]).astype(float).reshape(-1, 4, 4)
                    joints = np.array([matrices[j] @ m.T for j, m in zip(skin["joints"], inverse)])
                    weights = self.accessor(attributes["WEIGHTS_0"]).astype(float)
                    placement = np.einsum("vk,vkij->vij", weights, joints[self.accessor(attributes["JOINTS_0"])])
                positions = np.einsum("vij,vj->vi", placement[:, :3, :3], positions) + placement[:, :3, 3]
                if np.linalg.det(placement[0, :3, :3]) < 0:
                    triangles = triangles[:, ::-1]
                if normals is None:
                    corners = triangles.ravel()
                    positions, uvs = positions[corners], {i: uv[corners] for i, uv in uvs.items()}
                    triangles = np.arange(len(corners)).reshape(-1, 3)
                    a, b, c = positions[0::3], positions[1::3], positions[2::3]
                    normals = np.repeat(np.cross(b - a, c - a), 3, axis=0)
                else:
                    normals = np.einsum("vij,vi->vj", np.linalg.inv(placement[:, :3, :3]), normals)
                length = np.linalg.norm(normals, axis=1, keepdims=True)
                normals /= np.where(length > 0, length, 1)
                material = self.json["materials"][primitive["material"]] if "material" in primitive else {}
                yield node.get("name", ""), positions, normals, uvs, triangles, material


def intensity_scale(units):
    """What the numbers of point and spot lights, and of directional ones, are multiplied by to be W/sr and W/m2."""
    return {
        "radiometric": (1, 1),
        "photometric": (1 / 683, 1 / 683),
        "watts": (1 / (4 * math.pi), 1),
    }[units]


def spot_profile(light, cos):
    """KHR_lights_punctual's recommended angular attenuation."""
    spot = light.get("spot", {})
    inner, outer = math.cos(spot.get("innerConeAngle", 0)), math.cos(spot.get("outerConeAngle", math.pi / 4))
    return np.clip((cos - outer) / max(inner - outer, 1e-6), 0, 1) ** 2


def main():
    parser = argparse.ArgumentParser(description="Copies a .glb file without some effects.")
    parser.add_argument("scene")
    parser.add_argument("copy")
    parser.add_argument("--without", required=True, help=", ".join(f"{k}: {v}" for k, v in EFFECTS.items()))
    options = parser.parse_args()
    gltf = Gltf(options.scene)
    gltf.without(options.without.split(","))
    gltf.write(options.copy)


if __name__ == "__main__":
    main()
