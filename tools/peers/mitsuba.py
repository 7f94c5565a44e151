#!/usr/bin/env python3
"""Compares the stored references with Mitsuba 3, an independent renderer.

    pip install mitsuba numpy
    python tools/peers/mitsuba.py [SCENE...] [--minutes 10] [--images FOLDER]

Needs LLVM as a shared library. Writes reference/SCENE.mitsuba.ron; see README.md here.
"""

import argparse
import json
import math
import re
import struct
import sys
import tempfile
import time
from pathlib import Path

# This file has the name of the package it imports.
sys.path[:] = [folder for folder in sys.path if Path(folder or ".").resolve() != Path(__file__).resolve().parent]

import numpy as np
import mitsuba as mi

VARIANT = "llvm_ad_rgb"
mi.set_variant(VARIANT)

import drjit as dr

ROOT = Path(__file__).resolve().parents[2]
SCENES = ["cornell", "ring", "pool", "glass", "ajar"]
# Paths have at most this many edges in the references: the renderer's default.
MAX_EDGES = 16
REPLICAS = 32
BLOCK = 16
LUMINANCE = np.array([0.2126, 0.7152, 0.0722])
# Mitsuba starts rays 9e-5 (1 + |p|) off a surface at p, which moves the edges of shadows by as much. The scene is centred and
# enlarged, so that |p| is small for what is seen and the 1 is nothing.
ENLARGED = 1000.0
# Samples of one call, bounded by memory.
MOST_SAMPLES = 1 << 23
LARGEST_T = 5.0
LARGEST_MEAN_DIFFERENCE = 0.003
RESOLVED_BLOCK_ERROR = 0.03


# ---- glTF ----------------------------------------------------------------------------------------------------------


class Gltf:
    """A .glb file: its JSON and its binary chunk. What our scenes use, and an error for all else that would matter."""

    COMPONENTS = {5121: np.uint8, 5123: np.uint16, 5125: np.uint32, 5126: np.float32}
    WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}

    def __init__(self, path):
        data = Path(path).read_bytes()
        magic, _, length = struct.unpack_from("<4sII", data, 0)
        assert magic == b"glTF", path
        at, chunks = 12, {}
        while at < length:
            size, kind = struct.unpack_from("<I4s", data, at)
            chunks[kind] = data[at + 8 : at + 8 + size]
            at += 8 + size
        self.json = json.loads(chunks[b"JSON"])
        self.binary = chunks[b"BIN\0"]
        assert not self.json.get("textures") and "KHR_lights_punctual" not in self.json.get("extensions", {})

    def accessor(self, index):
        accessor = self.json["accessors"][index]
        view = self.json["bufferViews"][accessor["bufferView"]]
        assert "byteStride" not in view and "sparse" not in accessor
        width = self.WIDTHS[accessor["type"]]
        start = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
        values = np.frombuffer(self.binary, self.COMPONENTS[accessor["componentType"]], accessor["count"] * width, start)
        return values.reshape(-1, width) if width > 1 else values

    def nodes(self):
        """Every node of the scene with its matrix to world space."""

        def visit(index, parent):
            node = self.json["nodes"][index]
            assert not {"translation", "rotation", "scale"} & node.keys()
            matrix = parent @ np.array(node.get("matrix", np.eye(4).ravel()), float).reshape(4, 4).T
            yield node, matrix
            for child in node.get("children", []):
                yield from visit(child, matrix)

        for index in self.json["scenes"][self.json.get("scene", 0)]["nodes"]:
            yield from visit(index, np.eye(4))

    def primitives(self):
        """Name, positions, normals, triangles and material of every primitive, in world space."""
        for node, matrix in self.nodes():
            if "mesh" not in node:
                continue
            for primitive in self.json["meshes"][node["mesh"]]["primitives"]:
                assert primitive.get("mode", 4) == 4
                positions = self.accessor(primitive["attributes"]["POSITION"]).astype(float)
                normals = self.accessor(primitive["attributes"]["NORMAL"]).astype(float)
                positions = positions @ matrix[:3, :3].T + matrix[:3, 3]
                normals = normals @ np.linalg.inv(matrix[:3, :3])
                normals /= np.linalg.norm(normals, axis=1, keepdims=True)
                triangles = self.accessor(primitive["indices"]).reshape(-1, 3)
                material = Material(self.json["materials"][primitive["material"]])
                yield node["name"], positions, normals, triangles, material

    def camera(self):
        """Matrix and vertical field of view in radians of the first camera."""
        node, matrix = next((node, matrix) for node, matrix in self.nodes() if "camera" in node)
        return matrix, self.json["cameras"][node["camera"]]["perspective"]["yfov"]


class Material:
    """Numbers of a glTF material with its extensions."""

    KNOWN = {"emissive_strength", "ior", "specular", "transmission", "volume"}

    def __init__(self, json):
        extensions = {name.removeprefix("KHR_materials_"): values for name, values in json.get("extensions", {}).items()}
        assert extensions.keys() <= self.KNOWN, extensions.keys()
        pbr = json["pbrMetallicRoughness"]
        self.base = np.array(pbr["baseColorFactor"][:3])
        self.metallic = pbr["metallicFactor"]
        self.alpha = pbr["roughnessFactor"] ** 2
        strength = extensions.get("emissive_strength", {}).get("emissiveStrength", 1.0)
        self.radiance = np.array(json.get("emissiveFactor", [0, 0, 0])) * strength
        self.ior = extensions.get("ior", {}).get("ior", 1.5)
        self.specular = extensions.get("specular", {}).get("specularFactor", 1.0)
        transmission = extensions.get("transmission", {}).get("transmissionFactor", 0.0)
        volume = extensions.get("volume", {})
        self.solid = transmission > 0 and volume.get("thicknessFactor", 0.0) > 0
        self.absorption = np.zeros(3)
        if volume:
            self.absorption = -np.log(volume["attenuationColor"]) / volume["attenuationDistance"]
        # What the mapping below knows: opaque surfaces, and clear smooth solids.
        assert not transmission or (transmission == 1 and self.solid and self.alpha == 0 and (self.base == 1).all())
        assert self.metallic in (0, 1) and self.specular in (0, 1) and not json.get("doubleSided")
        assert transmission or self.alpha > 1e-3 or (self.metallic == 0 and self.specular == 0)


# ---- Scattering that Mitsuba lacks -----------------------------------------------------------------------------------


def clear_of(si, w):
    """Whether the shading and the geometric normal see the local direction `w` on one side. Ours asks this everywhere."""
    return w.z * dr.dot(si.to_local(si.n), w) > 1e-20


class SmoothSolid(mi.BSDF):
    """Mitsuba's own `dielectric`, dark where the two normals disagree about a direction's side."""

    def __init__(self, props):
        mi.BSDF.__init__(self, props)
        self.inner = mi.load_dict({"type": "dielectric", "int_ior": props["int_ior"], "ext_ior": 1.0})
        components = [self.inner.flags(i) for i in range(self.inner.component_count())]
        self.m_components = components
        self.m_flags = components[0] | components[1]

    def sample(self, ctx, si, sample1, sample2, active=True):
        sample, weight = self.inner.sample(ctx, si, sample1, sample2, active)
        good = clear_of(si, si.wi) & clear_of(si, sample.wo)
        return sample, weight & good

    def eval(self, ctx, si, wo, active=True):
        return mi.Color3f(0)

    def pdf(self, ctx, si, wo, active=True):
        return mi.Float(0)

    def eval_pdf(self, ctx, si, wo, active=True):
        return mi.Color3f(0), mi.Float(0)


def microfacets(wi, wo, alpha, facets):
    """D V of glTF 2.0, appendix B, and Schlick's (1 - cos)^5 at the half vector, for directions above."""
    sum = wi + wo
    length = dr.maximum(dr.norm(sum), 1e-8)
    h, cos = sum / length, 0.5 * length
    a2 = alpha * alpha
    root = lambda w: dr.sqrt(a2 * (w.x * w.x + w.y * w.y) + w.z * w.z)
    lobe = facets.eval(h) * 0.5 / (wi.z * root(wo) + wo.z * root(wi))
    return lobe, h, cos, dr.power(dr.clip(1 - cos, 0, 1), 5)


class Opaque(mi.BSDF):
    """glTF 2.0, appendix B, for surfaces that do not transmit; the same on both sides.

    A metal is F_m D V with Schlick's F_m from the base colour. A dielectric is F D V over base (1 - F) / pi, with Schlick's F
    from 0.04 at an index of 1.5. F is taken at the half vector. D is GGX, V Smith's with masking and shadowing correlated by
    height (Heitz 2014, eq. 99).
    """

    def __init__(self, props):
        mi.BSDF.__init__(self, props)
        self.base = mi.Color3f(props["base"])
        self.metallic = props["metallic"]
        self.specular = props["specular"]
        self.alpha = props["alpha"]
        self.f0 = ((props["int_ior"] - 1) / (props["int_ior"] + 1)) ** 2 * self.specular
        glossy = self.metallic or self.specular
        # Share of the samples that follow the microfacets.
        self.share = 1.0 if self.metallic else 0.5 if self.specular else 0.0
        both = mi.BSDFFlags.FrontSide | mi.BSDFFlags.BackSide
        self.m_components = [(mi.BSDFFlags.GlossyReflection if glossy else mi.BSDFFlags.DiffuseReflection) | both]
        self.m_flags = self.m_components[0]
        self.facets = mi.MicrofacetDistribution(mi.MicrofacetType.GGX, self.alpha, True)

    def value(self, wi, wo):
        """The scattering function times the cosine, both directions above."""
        lobe, _, _, schlick = microfacets(wi, wo, self.alpha, self.facets)
        if self.metallic:
            f = (self.base + (1 - self.base) * schlick) * lobe
        elif self.specular:
            fresnel = self.f0 + (self.specular - self.f0) * schlick
            f = self.base * ((1 - fresnel) * dr.inv_pi) + fresnel * lobe
        else:
            f = self.base * dr.inv_pi
        return f * wo.z

    def density(self, wi, wo):
        h = dr.normalize(wi + wo)
        return (1 - self.share) * wo.z * dr.inv_pi + (
            self.share * self.facets.pdf(wi, h) / (4 * dr.dot(wo, h)) if self.share else 0
        )

    def eval_pdf(self, ctx, si, wo, active=True):
        good = clear_of(si, si.wi) & clear_of(si, wo) & (si.wi.z * wo.z > 0) & active
        turn = lambda w: mi.Vector3f(w.x, w.y, dr.abs(w.z))
        wi, wo = turn(si.wi), turn(wo)
        value, density = self.value(wi, wo), self.density(wi, wo)
        return dr.select(good, value, 0), dr.select(good, density, 0)

    def eval(self, ctx, si, wo, active=True):
        return self.eval_pdf(ctx, si, wo, active)[0]

    def pdf(self, ctx, si, wo, active=True):
        return self.eval_pdf(ctx, si, wo, active)[1]

    def sample(self, ctx, si, sample1, sample2, active=True):
        wi = mi.Vector3f(si.wi.x, si.wi.y, dr.abs(si.wi.z))
        h, _ = self.facets.sample(wi, sample2)
        wo = dr.select(sample1 < self.share, mi.reflect(wi, h), mi.warp.square_to_cosine_hemisphere(sample2))
        above = wo.z > 0
        wo.z = dr.mulsign(wo.z, si.wi.z)
        value, density = self.eval_pdf(ctx, si, wo, active)
        good = above & (density > 0)
        sample = dr.zeros(mi.BSDFSample3f)
        sample.wo = wo
        sample.pdf = dr.select(good, density, 0)
        sample.eta = 1.0
        sample.sampled_type = mi.UInt32(+self.m_components[0])
        sample.sampled_component = 0
        return sample, dr.select(good, value / density, 0)


mi.register_bsdf("smooth_solid", SmoothSolid)
mi.register_bsdf("opaque", Opaque)


# ---- The scene -------------------------------------------------------------------------------------------------------


def rgb(values):
    return {"type": "rgb", "value": [float(v) for v in values]}


def is_flat(positions, normals, triangles):
    """Whether every corner's normal is that of its triangle."""
    a, b, c = (positions[triangles[:, i]] for i in range(3))
    face = np.cross(b - a, c - a)
    face /= np.linalg.norm(face, axis=1, keepdims=True)
    return all(np.einsum("ij,ij->i", face, normals[triangles[:, i]]).min() > 1 - 1e-6 for i in range(3))


def bsdf(material, flat):
    """The material for Mitsuba: its own plugins wherever they are exact."""
    if material.solid:
        return {"type": "smooth_solid", "int_ior": material.ior}
    if material.metallic == 0 and material.specular == 0 and flat:
        return {"type": "twosided", "bsdf": {"type": "diffuse", "reflectance": rgb(material.base)}}
    return {
        "type": "opaque",
        "base": mi.ScalarColor3f(*material.base),
        "metallic": float(material.metallic),
        "specular": float(material.specular),
        "alpha": float(material.alpha),
        "int_ior": float(material.ior),
    }


def distance(primitives, origin, direction):
    """How far along a ray the first triangle is (Möller and Trumbore 1997)."""
    nearest = math.inf
    for _, positions, _, triangles, _ in primitives:
        a, b, c = (positions[triangles[:, i]] for i in range(3))
        p = np.cross(direction, c - a)
        with np.errstate(divide="ignore", invalid="ignore"):
            inverse = 1 / np.einsum("ij,ij->i", b - a, p)
            u = np.einsum("ij,ij->i", origin - a, p) * inverse
            q = np.cross(origin - a, b - a)
            v = q @ direction * inverse
            t = np.einsum("ij,ij->i", c - a, q) * inverse
            hits = t[(u >= 0) & (v >= 0) & (u + v <= 1) & (t > 0)]
        nearest = min([nearest, *hits])
    return nearest


def write_ply(path, positions, normals, triangles, uv=None):
    """A mesh for Mitsuba, with texture coordinates if there are any."""
    names, columns = ["x", "y", "z", "nx", "ny", "nz"], [positions, normals]
    if uv is not None:
        names, columns = names + ["u", "v"], columns + [uv]
    vertices = np.hstack(columns).astype("<f4")
    faces = np.empty(len(triangles), [("count", "u1"), ("corners", "<i4", 3)])
    faces["count"], faces["corners"] = 3, triangles
    properties = "".join(f"property float {name}\n" for name in names)
    header = (
        f"ply\nformat binary_little_endian 1.0\nelement vertex {len(vertices)}\n{properties}"
        f"element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    path.write_bytes(header.encode() + vertices.tobytes() + faces.tobytes())


def frame_of_scene(integrator, edges, eye, forward, up, fov, size):
    """A scene without anything in it: integrator and camera, with a box filter of one pixel. `eye` is enlarged, `fov` vertical."""
    return {
        "type": "scene",
        "integrator": {"type": integrator, "max_depth": edges, "rr_depth": 5},
        "sensor": {
            "type": "perspective",
            "to_world": mi.ScalarTransform4f().look_at(origin=eye, target=eye + forward * ENLARGED, up=up),
            "fov": math.degrees(fov),
            "fov_axis": "y",
            "near_clip": 1e-3 * ENLARGED,
            "far_clip": 1e3 * ENLARGED,
            "film": {
                "type": "hdrfilm",
                "width": size[0],
                "height": size[1],
                "pixel_format": "rgb",
                "component_format": "float32",
                "rfilter": {"type": "box"},
            },
            "sampler": {"type": "independent"},
        },
    }


def load(name, size):
    """The Mitsuba scene, and a line on what stands for each material."""
    gltf = Gltf(ROOT / "scenes" / name / "scene.glb")
    matrix, fov = gltf.camera()
    primitives = list(gltf.primitives())
    forward, up = -matrix[:3, 2], matrix[:3, 1]
    centre = matrix[:3, 3] + forward * distance(primitives, matrix[:3, 3], forward)
    eye = (matrix[:3, 3] - centre) * ENLARGED
    integrator = "volpath" if any(material.solid for *_, material in primitives) else "path"
    scene = frame_of_scene(integrator, MAX_EDGES, eye, forward, up, fov, size)
    mapped = []
    with tempfile.TemporaryDirectory() as folder:
        for i, (label, positions, normals, triangles, material) in enumerate(primitives):
            path = Path(folder) / f"{i}.ply"
            write_ply(path, (positions - centre) * ENLARGED, normals, triangles)
            flat = is_flat(positions, normals, triangles)
            shape = {"type": "ply", "filename": str(path), "bsdf": bsdf(material, flat)}
            if material.radiance.any():
                shape["emitter"] = {"type": "area", "radiance": rgb(material.radiance)}
            if material.solid:
                shape["interior"] = {"type": "homogeneous", "albedo": 0.0, "sigma_t": rgb(material.absorption / ENLARGED)}
            mapped.append(f"{label}: {shape['bsdf'].get('bsdf', shape['bsdf'])['type']}")
            scene[f"shape{i}"] = shape
        return mi.load_dict(scene), integrator, ", ".join(mapped)


# ---- Rendering and comparing -----------------------------------------------------------------------------------------


def read_reference(name):
    """Mean and variances of a stored reference, and what its provenance says."""
    bitmap = mi.Bitmap(str(ROOT / "reference" / f"{name}.exr"))
    values = np.array(bitmap, dtype=float)
    channels = {field.name: values[:, :, i] for i, field in enumerate(bitmap.struct_())}
    image = np.stack([channels[c] for c in "RGB"], axis=-1)
    text = (ROOT / "reference" / f"{name}.ron").read_text()
    method = re.search(r'method: "(\w+)"', text)[1]
    # One value for each 8 x 8 block.
    return image, channels["block.Y"][::8, ::8], float(bitmap.metadata()["ergodic.total_variance"]), method


def blocks(luminance, side=BLOCK):
    rows, columns = luminance.shape
    return luminance.reshape(rows // side, side, columns // side, side).mean(axis=(1, 3))


def render_replicas(scene, size, seconds):
    """Means of independent replicas, and samples a pixel in each."""
    seed = 0

    def call(samples):
        nonlocal seed
        seed += 1
        return np.array(mi.render(scene, spp=samples, seed=seed), dtype=float)

    call(16)  # compiles
    start = time.monotonic()
    call(256)
    rate = 256 / (time.monotonic() - start)
    most = MOST_SAMPLES // (size[0] * size[1])
    wanted = max(rate * seconds / REPLICAS, 16)
    calls = math.ceil(wanted / most)
    samples = math.ceil(wanted / calls)
    start = time.monotonic()
    replicas = []
    while len(replicas) < REPLICAS and (len(replicas) < 16 or time.monotonic() - start < seconds):
        replicas.append(np.mean([call(samples) for _ in range(calls)], axis=0))
    return np.array(replicas), samples * calls, time.monotonic() - start


def compare(name, minutes, images):
    ours, our_small_blocks, our_total_variance, method = read_reference(name)
    size = (ours.shape[1], ours.shape[0])
    scene, integrator, mapped = load(name, size)
    replicas, samples, seconds = render_replicas(scene, size, 60 * minutes)
    n = len(replicas)

    total = lambda image: (image @ LUMINANCE).mean()
    our_mean = total(ours)
    their_means = np.array([total(replica) for replica in replicas])
    their_mean = their_means.mean()
    their_error = their_means.std(ddof=1) / math.sqrt(n) / their_mean
    our_error = math.sqrt(our_total_variance) / our_mean
    ratio = our_mean / their_mean
    ratio_error = ratio * math.hypot(our_error, their_error)

    our_blocks = blocks(ours @ LUMINANCE)
    our_variance = blocks(our_small_blocks, 2) / 4
    if method == "mlt":
        # The four blocks of 8 x 8 pixels in each share b, whose error is at most that of the mean.
        shared = our_error * blocks(ours @ LUMINANCE, 8)
        pairs = (4 * blocks(shared, 2)) ** 2 - 4 * blocks(shared**2, 2)
        our_variance = our_variance + pairs / 16
    their_blocks = np.array([blocks(replica @ LUMINANCE) for replica in replicas])
    their_variance = their_blocks.var(axis=0, ddof=1) / n
    their_blocks = their_blocks.mean(axis=0)
    t = (our_blocks - their_blocks) / np.sqrt(our_variance + their_variance)
    block_error = float(np.median(np.sqrt(their_variance) / their_blocks))

    if images:
        mi.Bitmap(replicas.mean(axis=0).astype(np.float32)).write(str(Path(images) / f"{name}.mitsuba.exr"))
    listed = lambda values, form: "[\n" + "".join(
        "        " + ", ".join(format(v, form) for v in row) + ",\n" for row in values
    ) + "    ]"
    text = f"""// reference/{name}.exr compared with Mitsuba 3. Remake it with the command.
(
    command: "python tools/peers/mitsuba.py {name} --minutes {minutes:g}",
    mitsuba: "{mi.__version__}",
    variant: "{VARIANT}",
    integrator: "{integrator}",
    mapping: "{mapped}",
    samples_per_pixel: {samples},
    replicas: {n},
    seconds: {seconds:.0f},
    // mean luminance, ours over Mitsuba's; errors hold the noise of both
    mean_ratio: {ratio:.5f},
    mean_ratio_error: {ratio_error:.5f},
    mean_luminance: {their_mean:.7f},
    relative_error_of_the_mean: {their_error:.2e},
    // blocks of {BLOCK} x {BLOCK} pixels in row order: ours less Mitsuba's in standard errors, and relative to Mitsuba's
    largest_block_t: {np.abs(t).max():.2f},
    block_t: {listed(t, ".2f")},
    block_difference: {listed(our_blocks / their_blocks - 1, ".4f")},
    // relative standard errors, Mitsuba's and ours
    block_error: {listed(np.sqrt(their_variance) / their_blocks, ".4f")},
    our_block_error: {listed(np.sqrt(our_variance) / our_blocks, ".4f")},
    median_relative_error_of_a_block: {block_error:.2e},
    resolved: {str(block_error <= RESOLVED_BLOCK_ERROR).lower()},
)
"""
    (ROOT / "reference" / f"{name}.mitsuba.ron").write_text(text)
    agrees = abs(ratio - 1) <= max(LARGEST_MEAN_DIFFERENCE, 3 * ratio_error) and np.abs(t).max() <= LARGEST_T
    row, column = np.unravel_index(np.abs(t).argmax(), t.shape)
    print(
        f"{name}: mean ratio {ratio:.5f} +- {ratio_error:.5f}, largest |t| {np.abs(t).max():.2f} in row {row}, column "
        f"{column}, block error {block_error:.2e}, {n} x {samples} samples a pixel in {seconds:.0f} s: "
        f"{'agrees' if agrees else 'DIFFERS'}",
        flush=True,
    )
    return agrees


def main():
    parser = argparse.ArgumentParser(description="Compares the stored references with Mitsuba 3.")
    parser.add_argument("scenes", nargs="*", metavar="SCENE", default=SCENES)
    parser.add_argument("--minutes", type=float, default=10.0, help="time for each scene")
    parser.add_argument("--images", metavar="FOLDER", help="keep Mitsuba's pictures here")
    options = parser.parse_args()
    agreed = [compare(name, options.minutes, options.images) for name in options.scenes]
    return 0 if all(agreed) else 1


if __name__ == "__main__":
    sys.exit(main())
