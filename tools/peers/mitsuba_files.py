#!/usr/bin/env python3
"""Renders a .glb file with Mitsuba 3 and compares the picture with ours.

    pip install mitsuba numpy pillow
    python tools/peers/mitsuba_files.py SCENE.glb --ours OURS.exr [--camera N] [--size WxH] [--spp N] [-o STEM]

Needs LLVM as a shared library; see README.md here.
"""

import argparse
import importlib.util
import math
import sys
import tempfile
from pathlib import Path

HERE = Path(__file__).resolve().parent
# The other script here has the name of the package that both import.
named = importlib.util.spec_from_file_location("peer", HERE / "mitsuba.py")
peer = importlib.util.module_from_spec(named)
named.loader.exec_module(peer)

import drjit as dr
import mitsuba as mi
import numpy as np

sys.path.append(str(HERE))
from gltf import EFFECTS, Gltf, intensity_scale, spot_profile
import pictures

# Masks are made of texels this many times finer, because ours asks after interpolation which side of the cutoff alpha is on.
MASK_DETAIL = 16
SPOT_DETAIL = 2048
ALBEDO_DETAIL = 64
# A microfacet distribution of Mitsuba's needs some width.
LEAST_ALPHA = 1e-3


def reflected(ior, alpha, samples=1 << 14):
    """What F D V reflects of light from ALBEDO_DETAIL cosines from 0 to 1, by sampling visible normals (Heitz 2018)."""
    random = np.random.default_rng(1)
    u1, u2 = random.random((2, samples))
    result = []
    for z in np.linspace(1e-4, 1, ALBEDO_DETAIL):
        x = math.sqrt(max(1 - z * z, 0))
        # The view, stretched; t1 is y, t2 its normal in the plane of incidence.
        vx, vz = np.array([alpha * x, z]) / math.hypot(alpha * x, z)
        r, phi = np.sqrt(u1), 2 * math.pi * u2
        p1, p2 = r * np.cos(phi), r * np.sin(phi)
        p2 = (1 - 0.5 * (1 + vz)) * np.sqrt(np.maximum(1 - p1**2, 0)) + 0.5 * (1 + vz) * p2
        p3 = np.sqrt(np.maximum(1 - p1**2 - p2**2, 0))
        h = np.array([alpha * (-vz * p2 + vx * p3), alpha * p1, np.maximum(vx * p2 + vz * p3, 0)])
        h /= np.linalg.norm(h, axis=0)
        cos = h[0] * x + h[2] * z
        wo_z = 2 * cos * h[2] - z
        sine = (1 - cos**2) / ior**2
        inner = np.sqrt(1 - sine)
        fresnel = 0.5 * (((cos - ior * inner) / (cos + ior * inner)) ** 2 + ((inner - ior * cos) / (inner + ior * cos)) ** 2)
        smith = lambda w: (np.sqrt(1 + alpha**2 * np.maximum(1 / np.maximum(w, 1e-6) ** 2 - 1, 0)) - 1) / 2
        result.append(np.where(wo_z > 0, fresnel * (1 + smith(z)) / (1 + smith(z) + smith(wo_z)), 0).mean())
    return result


class GltfSurface(mi.BSDF):
    """glTF 2.0, appendix B, with textures and a normal map, the same on both sides.

    The mix by `metallic` of a metal, F D V with Schlick's F from the base colour, and of a dielectric, F D V over
    base (1 - F) / pi with Schlick's F at the half vector. It is dark where shading and geometric normal disagree about a side.

    With `principled`, a dielectric is as Blender's Principled BSDF has it: F D V with Fresnel's own F, over
    base (1 - E) / pi, where E is the share of light from the viewer's direction that F D V reflects.
    """

    def __init__(self, props):
        mi.BSDF.__init__(self, props)
        self.base, self.rough, self.normals = (props[n] if n in props else None for n in ["base", "rough", "normals"])
        self.factors = mi.ScalarColor3f(props["factors"])
        self.metallic = props["metallic"]
        self.roughness = props["roughness"]
        self.specular = props["specular"]
        self.ior = props["int_ior"]
        self.albedo = None
        if props["principled"] and self.specular == 1:
            self.albedo = mi.Float(reflected(self.ior, max(self.roughness**2, LEAST_ALPHA)))
        self.f0 = min(((props["int_ior"] - 1) / (props["int_ior"] + 1)) ** 2, 1) * self.specular
        glossy = self.metallic > 0 or self.specular > 0
        both = mi.BSDFFlags.FrontSide | mi.BSDFFlags.BackSide
        kind = mi.BSDFFlags.GlossyReflection if glossy else mi.BSDFFlags.DiffuseReflection
        self.m_components = [kind | both]
        self.m_flags = self.m_components[0]
        self.glossy = glossy

    def frame(self, si):
        """The frame of the normal map in the local one of the interpolated normal."""
        if self.normals is None:
            return mi.Frame3f(mi.Vector3f(1, 0, 0), mi.Vector3f(0, 1, 0), mi.Vector3f(0, 0, 1))
        u = si.to_local(si.dp_du)
        tangent = dr.normalize(mi.Vector3f(u.x, u.y, 0))
        up = mi.Vector3f(-tangent.y, tangent.x, 0)
        n = 2 * self.normals.eval(si) - 1
        n = dr.normalize(tangent * n.x + up * n.y + mi.Vector3f(0, 0, 1) * n.z)
        # Normals are turned to the side that is seen.
        return mi.Frame3f(n)

    def surface(self, si):
        base = mi.Color3f(self.factors) * (self.base.eval(si) if self.base else 1)
        rough = self.rough.eval(si) if self.rough else mi.Color3f(1)
        roughness, metallic = self.roughness * rough.y, self.metallic * rough.z
        return base, metallic, dr.maximum(roughness * roughness, LEAST_ALPHA)

    def directions(self, si, wo):
        """Both directions in the normal map's frame, turned above it, and whether they are on one side of everything."""
        frame = self.frame(si)
        # Back faces see the mirrored geometry: turn before the map is applied.
        turn = dr.mulsign(mi.Float(1), si.wi.z)
        wi_shading, wo_shading = si.wi * turn, wo * turn
        wi, wo_mapped = frame.to_local(wi_shading), frame.to_local(wo_shading)
        geometric = si.to_local(si.n) * turn
        good = (wi.z > 1e-6) & (wo_mapped.z > 1e-6)
        good &= (dr.dot(geometric, wi_shading) > 0) & (dr.dot(geometric, wo_shading) > 0)
        return frame, turn, wi, wo_mapped, good

    def lobes(self, si, wi, wo):
        base, metallic, alpha = self.surface(si)
        facets = mi.MicrofacetDistribution(mi.MicrofacetType.GGX, alpha, True)
        lobe, h, cos, schlick = peer.microfacets(wi, wo, alpha, facets)
        fresnel = self.f0 + (self.specular - self.f0) * schlick
        kept = 1 - fresnel
        if self.albedo is not None:
            fresnel = mi.fresnel(cos, self.ior)[0]
            at = dr.clip(wi.z, 0, 1) * (ALBEDO_DETAIL - 1)
            low = dr.minimum(mi.UInt32(at), ALBEDO_DETAIL - 2)
            of = lambda i: dr.gather(mi.Float, self.albedo, i)
            kept = 1 - dr.lerp(of(low), of(low + 1), at - mi.Float(low))
        dielectric = base * (kept * dr.inv_pi) + fresnel * lobe
        metal = (base + (1 - base) * schlick) * lobe
        value = (dielectric + (metal - dielectric) * metallic) * wo.z
        share = 0.5 + 0.5 * metallic if self.glossy else mi.Float(0)
        density = (1 - share) * wo.z * dr.inv_pi + share * facets.pdf(wi, h) / (4 * dr.maximum(dr.dot(wo, h), 1e-8))
        return value, density, share, facets

    def eval_pdf(self, ctx, si, wo, active=True):
        _, _, wi, wo, good = self.directions(si, wo)
        value, density, _, _ = self.lobes(si, wi, wo)
        good &= active
        return dr.select(good, value, 0), dr.select(good, density, 0)

    def eval(self, ctx, si, wo, active=True):
        return self.eval_pdf(ctx, si, wo, active)[0]

    def pdf(self, ctx, si, wo, active=True):
        return self.eval_pdf(ctx, si, wo, active)[1]

    def sample(self, ctx, si, sample1, sample2, active=True):
        frame, turn, wi, _, _ = self.directions(si, si.wi)
        _, _, share, facets = self.lobes(si, wi, mi.Vector3f(0, 0, 1))
        h, _ = facets.sample(mi.Vector3f(wi.x, wi.y, dr.maximum(wi.z, 1e-6)), sample2)
        wo = dr.select(sample1 < share, mi.reflect(wi, h), mi.warp.square_to_cosine_hemisphere(sample2))
        wo = frame.to_world(wo) * turn
        value, density = self.eval_pdf(ctx, si, wo, active)
        good = density > 0
        sample = dr.zeros(mi.BSDFSample3f)
        sample.wo = wo
        sample.pdf = dr.select(good, density, 0)
        sample.eta = 1.0
        sample.sampled_type = mi.UInt32(+self.m_components[0])
        sample.sampled_component = 0
        return sample, dr.select(good, value / density, 0)


mi.register_bsdf("gltf_surface", GltfSurface)


def linear(rgb):
    return np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)


WRAPS = {10497: "repeat", 33071: "clamp", 33648: "mirror"}


class Textures:
    def __init__(self, gltf):
        self.gltf = gltf

    def sampler(self, info):
        texture = self.gltf.json["textures"][info["index"]]
        return self.gltf.json["samplers"][texture["sampler"]] if "sampler" in texture else {}

    def bitmap(self, info, pixels, nearest=False):
        wrap = WRAPS[self.sampler(info).get("wrapS", 10497)]
        result = {
            "type": "bitmap",
            "bitmap": mi.Bitmap(np.ascontiguousarray(pixels, dtype=np.float32)),
            "raw": True,
            "filter_type": "nearest" if nearest else "bilinear",
            "wrap_mode": wrap,
        }
        transform = info.get("extensions", {}).get("KHR_texture_transform")
        if transform:
            s, (x, y) = transform.get("scale", [1, 1]), transform.get("offset", [0, 0])
            r = transform.get("rotation", 0)
            matrix = np.array([
                [math.cos(r) * s[0], math.sin(r) * s[1], x],
                [-math.sin(r) * s[0], math.cos(r) * s[1], y],
                [0, 0, 1],
            ])
            result["to_uv"] = mi.ScalarTransform3f(matrix)
        return result

    def mask(self, info, factor, cutoff):
        """Whether alpha after bilinear interpolation reaches the cutoff, at MASK_DETAIL places a texel and direction."""
        alpha = self.gltf.image(info["index"])[:, :, 3]
        for axis in range(2):
            n = alpha.shape[axis]
            at = (np.arange(n * MASK_DETAIL) + 0.5) / MASK_DETAIL - 0.5
            low = np.floor(at).astype(int)
            share = (at - low).reshape([-1 if i == axis else 1 for i in range(2)])
            index = (lambda i: i % n) if self.sampler(info).get("wrapS", 10497) == 10497 else (lambda i: np.clip(i, 0, n - 1))
            alpha = np.take(alpha, index(low), axis) * (1 - share) + np.take(alpha, index(low + 1), axis) * share
        return self.bitmap(info, (alpha * factor >= cutoff)[:, :, None].astype(np.float32), nearest=True)


def uv_set(material):
    """The set of coordinates of all its textures, which Mitsuba allows one of."""
    pbr = material.get("pbrMetallicRoughness", {})
    infos = [pbr.get("baseColorTexture"), pbr.get("metallicRoughnessTexture"), material.get("normalTexture")]
    sets = {info.get("texCoord", 0) for info in infos if info}
    if len(sets) > 1:
        raise SystemExit(f"{material.get('name')}: more than one set of texture coordinates")
    return sets.pop() if sets else 0


KNOWN = {"emissive_strength", "ior", "specular", "transmission", "volume"}


def surface(material, gltf, principled):
    """Mitsuba's BSDF, radiance, and absorption of a solid or None."""
    name = material.get("name", "material")
    extensions = {k.removeprefix("KHR_materials_"): v for k, v in material.get("extensions", {}).items()}
    if extensions.keys() - KNOWN:
        raise SystemExit(f"{name}: {', '.join(extensions.keys() - KNOWN)} is not known here")
    if "emissiveTexture" in material:
        raise SystemExit(f"{name}: textured emission is not known here")
    pbr = material.get("pbrMetallicRoughness", {})
    radiance = np.array(material.get("emissiveFactor", [0, 0, 0])) * extensions.get("emissive_strength", {}).get("emissiveStrength", 1)
    ior = extensions.get("ior", {}).get("ior", 1.5)
    specular = extensions.get("specular", {})
    if specular.get("specularColorFactor", [1, 1, 1]) != [1, 1, 1] or "specularTexture" in specular:
        raise SystemExit(f"{name}: coloured or textured specular is not known here")
    factor = pbr.get("baseColorFactor", [1, 1, 1, 1])
    textures = Textures(gltf)

    if extensions.get("transmission", {}).get("transmissionFactor", 0) > 0:
        volume = extensions.get("volume", {})
        if extensions["transmission"]["transmissionFactor"] != 1 or not volume.get("thicknessFactor") or pbr.get("metallicFactor", 1) != 0:
            raise SystemExit(f"{name}: of what transmits, only solids that do so wholly are known here")
        if pbr.get("roughnessFactor", 1) > 0:
            raise SystemExit(f"{name}: rough transmission is not known here")
        absorption = np.zeros(3)
        if "attenuationColor" in volume and "attenuationDistance" in volume:
            absorption = -np.log(volume["attenuationColor"]) / volume["attenuationDistance"]
        return {"type": "smooth_solid", "int_ior": ior}, radiance, absorption

    result = {
        "type": "gltf_surface",
        "factors": mi.ScalarColor3f(*factor[:3]),
        "metallic": float(pbr.get("metallicFactor", 1)),
        "roughness": float(pbr.get("roughnessFactor", 1)),
        "specular": float(specular.get("specularFactor", 1)),
        "int_ior": float(ior),
        "principled": principled,
    }
    if "baseColorTexture" in pbr:
        info = pbr["baseColorTexture"]
        result["base"] = textures.bitmap(info, linear(gltf.image(info["index"])[:, :, :3]))
    if "metallicRoughnessTexture" in pbr:
        info = pbr["metallicRoughnessTexture"]
        result["rough"] = textures.bitmap(info, gltf.image(info["index"])[:, :, :3])
    if "normalTexture" in material:
        info = material["normalTexture"]
        pixels = gltf.image(info["index"])[:, :, :3].copy()
        pixels[:, :, :2] = (pixels[:, :, :2] - 0.5) * info.get("scale", 1) + 0.5
        result["normals"] = textures.bitmap(info, pixels)
    if material.get("alphaMode") == "BLEND":
        raise SystemExit(f"{name}: alphaMode BLEND is not known here")
    if material.get("alphaMode") == "MASK" and "baseColorTexture" in pbr:
        opacity = textures.mask(pbr["baseColorTexture"], factor[3], material.get("alphaCutoff", 0.5))
        result = {"type": "mask", "opacity": opacity, "bsdf": result}
    return result, radiance, None


def emitter(light, matrix, centre, units):
    pointlike, parallel = intensity_scale(units)
    colour = np.array(light.get("color", [1, 1, 1])) * light.get("intensity", 1)
    position = (matrix[:3, 3] - centre) * peer.ENLARGED
    axis = -matrix[:3, 2] / np.linalg.norm(matrix[:3, 2])
    if light["type"] == "directional":
        return {"type": "directional", "direction": axis.tolist(), "irradiance": peer.rgb(colour * parallel)}
    # Irradiance goes with the square of the distance.
    strength = peer.rgb(colour * pointlike * peer.ENLARGED**2)
    if light["type"] == "point":
        return {"type": "point", "position": position.tolist(), "intensity": strength}
    outer = light.get("spot", {}).get("outerConeAngle", math.pi / 4)
    # Mitsuba's profile is linear in the angle. A texture over the cone carries glTF's.
    edge = outer * 1.001
    at = ((np.arange(SPOT_DETAIL) + 0.5) / SPOT_DETAIL * 2 - 1) * math.tan(edge)
    cos = 1 / np.sqrt(1 + at[:, None] ** 2 + at[None, :] ** 2)
    profile = spot_profile(light, cos)[:, :, None].repeat(3, axis=2).astype(np.float32)
    return {
        "type": "spot",
        "to_world": mi.ScalarTransform4f().look_at(origin=position, target=position + axis * peer.ENLARGED, up=matrix[:3, 1]),
        "intensity": strength,
        "cutoff_angle": math.degrees(edge),
        "beam_width": math.degrees(edge) * 0.9999,
        "texture": {"type": "bitmap", "bitmap": mi.Bitmap(profile), "raw": True, "wrap_mode": "clamp"},
    }


def load(gltf, camera, size, edges, units, principled, folder):
    matrix, fov = gltf.camera(camera)
    primitives = list(gltf.primitives())
    eye, forward, up = matrix[:3, 3], -matrix[:3, 2], matrix[:3, 1]
    away = peer.distance([(n, p, None, t, None) for n, p, _, _, t, _ in primitives], eye, forward)
    centre = eye + forward * (away if math.isfinite(away) else 1)
    origin = (eye - centre) * peer.ENLARGED
    solid = any("KHR_materials_transmission" in p[-1].get("extensions", {}) for p in primitives)
    scene = peer.frame_of_scene("volpath" if solid else "path", edges, origin, forward, up, fov, size)
    for i, (_, positions, normals, uvs, triangles, material) in enumerate(primitives):
        path = Path(folder) / f"{i}.ply"
        uv = uvs.get(uv_set(material))
        uv = np.zeros((len(positions), 2)) if uv is None else uv
        peer.write_ply(path, (positions - centre) * peer.ENLARGED, normals, triangles, uv)
        bsdf, radiance, absorption = surface(material, gltf, principled)
        shape = {"type": "ply", "filename": str(path), "bsdf": bsdf}
        if radiance.any():
            shape["emitter"] = {"type": "area", "radiance": peer.rgb(radiance)}
        if absorption is not None:
            shape["interior"] = {"type": "homogeneous", "albedo": 0.0, "sigma_t": peer.rgb(absorption / peer.ENLARGED)}
        scene[f"shape{i}"] = shape
    for i, (light, placed) in enumerate(gltf.lights()):
        scene[f"light{i}"] = emitter(light, placed, centre, units)
    # In parallel, plugins written in Python wait for each other forever at times.
    return mi.load_dict(scene, parallel=False)


def main():
    parser = argparse.ArgumentParser(description="Compares a picture of ours with Mitsuba 3.")
    parser.add_argument("scene", metavar="SCENE.glb")
    parser.add_argument("--ours", required=True, metavar="OURS.exr")
    parser.add_argument("--camera", type=int, default=0)
    parser.add_argument("--size", default="256x192", metavar="WxH")
    parser.add_argument("--spp", type=int, default=256)
    parser.add_argument("--edges", type=int, default=16, help="our max_edges")
    parser.add_argument("--units", default="radiometric", choices=["radiometric", "photometric", "watts"], help="our light_units")
    parser.add_argument("--without", default="", help=", ".join(f"{k}: {v}" for k, v in EFFECTS.items()))
    parser.add_argument("--principled", action="store_true", help="layer dielectrics as Blender does, not as glTF does")
    parser.add_argument("--replicas", type=int, default=4)
    parser.add_argument("-o", "--output", metavar="STEM")
    options = parser.parse_args()
    size = tuple(int(x) for x in options.size.split("x"))
    gltf = Gltf(options.scene)
    gltf.without(list(filter(None, options.without.split(","))))
    with tempfile.TemporaryDirectory() as folder:
        scene = load(gltf, options.camera, size, options.edges, options.units, options.principled, folder)
        each = max(options.spp // options.replicas, 1)
        most = max(peer.MOST_SAMPLES // 4 // (size[0] * size[1]), 1)
        calls = math.ceil(each / most)
        seeds = iter(range(1 << 30))
        replicas = [
            np.mean([np.array(mi.render(scene, spp=math.ceil(each / calls), seed=next(seeds)), dtype=float) for _ in range(calls)], axis=0)
            for _ in range(options.replicas)
        ]
    facts = {
        "peer": f"Mitsuba {mi.__version__}",
        "scene": options.scene,
        "camera": options.camera,
        "spp": each * options.replicas,
        "without": options.without,
        "principled": options.principled,
    }
    pictures.compare(options.ours, np.array(replicas), facts, options.output)


if __name__ == "__main__":
    main()
