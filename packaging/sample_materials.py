"""The materials of the sample: painted by sample_textures."""

from __future__ import annotations

from typing import Any

import numpy as np
import sample_textures as textures
from sample_workshop import FLOOR_RADIUS, PEDESTAL_HEIGHT, PEDESTAL_RADIUS, Workshop


def add_materials(shop: Workshop) -> None:
    png, jpeg, glb = textures.png, textures.jpeg, shop.glb

    def add(name: str, color: str, rough: float, metal: float, alpha: float = 1.0, **more: Any) -> None:
        """`color` is sRGB as painters give it; factors in the file are linear."""
        pbr: dict[str, Any] = {"metallicFactor": metal, "roughnessFactor": rough}
        srgb = textures.rgb(color)
        linear = np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)
        if alpha < 1 or np.any(linear < 1):
            pbr["baseColorFactor"] = [*(round(float(v), 5) for v in linear), alpha]
        for slot in ("baseColorTexture", "metallicRoughnessTexture"):
            if slot in more:
                pbr[slot] = more.pop(slot)
        shop.materials[name] = glb.add_material(name, pbrMetallicRoughness=pbr, **more)

    def use(name: str, data: bytes, **options: Any) -> dict[str, Any]:
        return {"index": glb.add_texture(name, data), **options}

    brushed_normal, brushed_rough = textures.brushed()
    hammered_normal, hammered_rough = textures.hammered()
    walnut_color, walnut_rough = textures.walnut()
    floor_color, floor_normal, floor_rough = textures.stone_floor()
    clay_color, clay_normal, clay_rough = textures.clay(256)
    scale_color, scale_normal, scale_rough = textures.engraved_scale()
    occlusion = textures.floor_occlusion(256, FLOOR_RADIUS, PEDESTAL_RADIUS, PEDESTAL_HEIGHT)

    add("polished brass", "#f0c674", 0.14, 1.0)
    add("brushed brass", "#eebf69", 1.0, 1.0,
        normalTexture=use("brushed normal", png(brushed_normal)),
        metallicRoughnessTexture=use("brushed roughness", png(brushed_rough)))  # fmt: skip
    add("engraved brass", "#ffffff", 1.0, 1.0,
        baseColorTexture=use("scale", png(scale_color)),
        normalTexture=use("scale normal", png(scale_normal)),
        metallicRoughnessTexture=use("scale roughness", png(scale_rough)))  # fmt: skip
    add("gold", "#ffdc9d", 0.10, 1.0)
    add("dark steel", "#5d6067", 0.32, 1.0)
    add("hammered iron", "#6b645e", 1.0, 1.0,
        normalTexture=use("hammered normal", png(hammered_normal)),
        metallicRoughnessTexture=use("hammered roughness", jpeg(hammered_rough)))  # fmt: skip
    add("marble", "#ffffff", 0.13, 0.0, baseColorTexture=use("marble", jpeg(textures.marble(), 88)))
    add("black marble", "#17181b", 0.11, 0.0)
    add("walnut", "#ffffff", 1.0, 1.0,
        baseColorTexture=use("walnut", jpeg(walnut_color, 88)),
        metallicRoughnessTexture=use("walnut roughness", jpeg(walnut_rough, 85)))  # fmt: skip
    add("stone floor", "#ffffff", 1.0, 1.0,
        baseColorTexture=use("floor", jpeg(floor_color, 88)),
        normalTexture=use("floor normal", png(floor_normal)),
        metallicRoughnessTexture=use("floor roughness", jpeg(floor_rough, 85)),
        occlusionTexture=use("floor occlusion", png(occlusion), texCoord=1))  # fmt: skip
    add("terracotta", "#ffffff", 1.0, 1.0,
        baseColorTexture=use("terracotta", jpeg(clay_color, 88)),
        normalTexture=use("terracotta normal", png(clay_normal)),
        metallicRoughnessTexture=use("terracotta roughness", jpeg(clay_rough, 85)))  # fmt: skip
    add("porcelain", "#ffffff", 0.06, 0.0, baseColorTexture=use("porcelain", jpeg(textures.porcelain(768), 88)))
    add("painted", "#ffffff", 0.36, 0.0)
    add("pearl", "#e9e2d6", 0.28, 0.0)
    add("sun", "#000000", 1.0, 0.0,
        emissiveFactor=[1.0, 1.0, 1.0],
        emissiveTexture=use("sun", jpeg(textures.sun_surface(), 88)),
        extensions={"KHR_materials_emissive_strength": {"emissiveStrength": 3.0}})  # fmt: skip
    add("glass", "#20262c", 0.03, 0.0, alpha=0.16, alphaMode="BLEND")
    add("filigree", "#ffffff", 0.22, 1.0, alphaMode="MASK", alphaCutoff=0.5, doubleSided=True,
        baseColorTexture=use("filigree", png(textures.filigree())))  # fmt: skip
    add("planet ring", "#ffffff", 0.16, 1.0, alphaMode="MASK", alphaCutoff=0.5, doubleSided=True,
        baseColorTexture=use("planet ring", png(textures.planet_ring())))  # fmt: skip
