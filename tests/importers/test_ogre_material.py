"""Ogre material scripts: syntax, inheritance, variables; what the `surface` effect gets; finding scripts and images."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from PIL import Image

from engine.core.findings import Findings, Severity
from importers.model import ImportedMaterial, ImportedModel
from importers.ogre.folders import look_around
from importers.ogre.inheritance import Library
from importers.ogre.materials import map_material, roughness_of
from importers.ogre.reader import dependencies, load
from importers.ogre.script import Node, parse_script
from importers.settings import ImportSettings
from tests.support.ogre_builder import SQUARE_INDICES, OgreBytes

SETTINGS = ImportSettings()
B = OgreBytes()


def resolve(text: str, name: str) -> tuple[Node, list[str]]:
    library = Library([parse_script(text, "t.material")])
    problems: list[str] = []
    return library.resolve(library.find("material", name)[0], problems), problems


def mapped(text: str, name: str = "m") -> tuple[ImportedMaterial, dict[int, str], Findings]:
    images: dict[int, str] = {}

    def find(texture: str, where: str) -> int | None:
        del where
        return images.setdefault(len(images), texture) and len(images) - 1

    library = Library([parse_script(text, "t.material")])
    findings = Findings()
    node = library.resolve(library.find("material", name)[0], [])
    return map_material(node, name, {}, library, find, findings).material, images, findings


def one(body: str, unit: str = "") -> ImportedMaterial:
    units = f"texture_unit {{\n{unit}\n}}" if unit else ""
    return mapped(f"material m {{ technique {{ pass {{\n{body}\n{units}\n}} }} }}")[0]


def params(body: str) -> dict[str, Any]:
    return one(body).asset.params


def save_mesh(folder: Path, material: str, **rest: Any) -> Path:
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / "t.mesh"
    path.write_bytes(B.mesh(B.submesh(material, SQUARE_INDICES, B.square_geometry(), **rest)))
    return path


def save_image(path: Path) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    Image.new("RGB", (4, 4)).save(path)


def textures(model: ImportedModel) -> dict[str, str]:
    (number,) = model.slots[0]
    material = model.materials[number]
    return {slot: model.images[use.image].path for slot, use in material.images.items()}


# --- syntax ---


def test_syntax() -> None:
    script = parse_script(
        """
        // a comment { with a brace
        import Base from "base.material"
        material "2 - Default" : Base { /* inline
            over lines */ technique T1 {
                pass
                { diffuse 1 0 0 // tail
                  texture_unit u { texture "my file.png" } } }
        }
        material A/B: C/D {}
        abstract pass Some/Pass { lighting off }
        """,
        "t.material",
    )
    assert not script.problems
    assert script.imports == ["base.material"]
    first, second, third = script.objects
    assert (first.name, first.bases, first.line) == ("2 - Default", ("Base",), 4)
    assert (second.name, second.bases) == ("A/B", ("C/D",))
    assert (third.kind, third.name, third.abstract) == ("pass", "Some/Pass", True)
    one_pass = first.of("technique")[0].of("pass")[0]
    assert one_pass.properties[0].values == ("1", "0", "0")
    texture = one_pass.of("texture_unit")[0].get("texture")
    assert texture is not None
    assert texture.values == ("my file.png",)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("material m { technique {", "not closed"),
        ("material m { } }", "too many"),
        ("stray words\nmaterial m { }", "outside"),
        ("material m " + "{ a " * 60, "levels"),
    ],
)
def test_mistakes_are_noted_and_the_rest_is_kept(text: str, says: str) -> None:
    script = parse_script(text, "t.material")
    assert any(says in what for _, what in script.problems)
    assert [node.name for node in script.objects] == ["m"]


# --- inheritance ---

FAMILY = """
abstract material Base {
    set $skin base.png
    technique {
        pass first { diffuse 1 0 0\n specular 1 1 1 10\n texture_unit { texture $skin\n tex_address_mode clamp } }
        pass second { lighting off }
    }
}
material Child : Base { set $skin child.png }
material Grandchild : Child { technique { pass { diffuse 0 1 0\n texture_unit { filtering none } } } }
material Named : Base { technique { pass second { diffuse 0 0 1 }\n pass third { } } }
"""


def test_inheritance_overrides_by_place_and_by_name() -> None:
    node, problems = resolve(FAMILY, "Grandchild")
    assert not problems
    first, second = node.of("technique")[0].of("pass")
    diffuse = first.get("diffuse")
    assert diffuse is not None
    assert diffuse.values == ("0", "1", "0")
    assert first.get("specular") is not None
    (unit,) = first.of("texture_unit")
    assert [(p.name, p.values[0]) for p in unit.properties] == [
        ("texture", "child.png"), ("tex_address_mode", "clamp"), ("filtering", "none"),
    ]  # fmt: skip
    assert second.name == "second"
    node, _ = resolve(FAMILY, "Named")
    passes = node.of("technique")[0].of("pass")
    assert [p.name for p in passes] == ["first", "second", "third"]
    assert [p.name for p in passes[1].properties] == ["lighting", "diffuse"]
    # the parents themselves stay as they are
    node, _ = resolve(FAMILY, "Child")
    assert [p.name for p in node.of("technique")[0].of("pass")] == ["first", "second"]


def test_circles_missing_parents_and_unset_variables_are_told() -> None:
    assert any("itself" in p for p in resolve("material A : B {}\nmaterial B : A {}", "A")[1])
    assert any("'Gone'" in p for p in resolve("material A : Gone {}", "A")[1])
    text = "material A { technique { pass { texture_unit { texture $none } } } }"
    assert any("$none" in p for p in resolve(text, "A")[1])


def test_doubling_parents_come_to_an_end() -> None:
    lines = ["material m0 { technique { pass { diffuse 1 1 1 } } }"]
    lines += [f"material m{k} : m{k - 1} m{k - 1} {{ }}" for k in range(1, 60)]
    _, problems = resolve("\n".join(lines), "m59")
    assert any("parts" in p for p in problems)


# --- mapping ---


def test_defaults_are_a_white_matt_dielectric() -> None:
    material = one("")
    assert material.asset.params == {"metallic": 0.0, "roughness": 1.0}
    assert (material.asset.queue, material.asset.features) == ("opaque", [])


def test_diffuse_is_display_referred() -> None:
    assert params("diffuse 0.5 1 0 0.25")["base_color"] == pytest.approx((0.21404114, 1, 0, 0.25))


def test_shininess_becomes_roughness() -> None:
    assert roughness_of(0) == 1.0
    assert roughness_of(30) == pytest.approx(0.5)  # alpha = 0.25: 2 / 0.25^2 - 2 = 30
    assert params("specular 1 1 1 30")["roughness"] == pytest.approx(0.5)
    assert params("specular 1 1 1 0.5 30")["roughness"] == pytest.approx(0.5)
    assert params("specular 1 1 1 7\nshininess 30")["roughness"] == pytest.approx(0.5)
    tinted = params("specular 0.5 0.25 0.5 30")
    assert tinted["specular"] == 0.5
    assert tinted["specular_color"] == pytest.approx((1, 0.21404114, 1))
    assert params("specular 0 0 0 30")["roughness"] == 1.0


def test_metal_roughness_stage() -> None:
    plain = params("specular 0.3 0.9 0\nrtshader_system { lighting_stage metal_roughness }")
    assert (plain["roughness"], plain["metallic"]) == (0.3, 0.9)
    material = one(
        "rtshader_system {\nlighting_stage metal_roughness texture mr.png\nlighting_stage normal_map n.png\n}"
    )
    assert sorted(material.images) == ["metal_rough_map", "normal_map"]
    assert (material.asset.params["roughness"], material.asset.params["metallic"]) == (1.0, 1.0)


def test_emissive_over_one_becomes_strength() -> None:
    found = params("emissive 1 0.5 0")
    assert found["emissive"] == pytest.approx((1, 0.21404114, 0))
    assert "emissive_strength" not in found
    found = params("self_illumination 2 0 0")
    assert found["emissive"] == (1, 0, 0)
    assert found["emissive_strength"] > 4


@pytest.mark.parametrize(
    ("body", "queue", "cutoff"),
    [
        ("alpha_rejection greater 127", "alpha_test", 0.5),
        ("alpha_rejection greater_equal 51", "alpha_test", 0.2),
        ("alpha_rejection always_pass 0", "opaque", None),
        ("scene_blend alpha_blend", "transparent", None),
        ("scene_blend src_alpha one_minus_src_alpha", "transparent", None),
        ("scene_blend one zero", "opaque", None),
        ("scene_blend add", "transparent", None),
    ],
)
def test_alpha(body: str, queue: str, cutoff: float | None) -> None:
    asset = one(body).asset
    assert (asset.queue, asset.params.get("alpha_cutoff")) == (queue, cutoff and pytest.approx(cutoff))


def test_alpha_tested_textures_keep_their_coverage() -> None:
    use = one("alpha_rejection greater_equal 51", "texture leaf.png").images["base_color_map"]
    assert use.alpha_cutoff == pytest.approx(0.2)


def test_features() -> None:
    assert one("cull_hardware none\nlighting off").asset.features == ["unlit", "double_sided"]


def test_texture_units() -> None:
    reference = one(
        "", "texture a.png 2d 5\ntex_address_mode clamp mirror\nfiltering none\ntex_coord_set 1"
    ).asset.textures
    assert reference["base_color_map"].wrap_u == "clamp"
    assert reference["base_color_map"].wrap_v == "mirror"
    assert reference["base_color_map"].mag_filter == "nearest"
    assert reference["base_color_map"].uv_set == 1
    scaled = one("", "texture a.png\nscale 0.5 0.25\nscroll 0.1 0").asset.textures["base_color_map"]
    # about the centre: 0.5 goes to 0.5 + scroll
    assert scaled.scale == (2.0, 4.0)
    assert scaled.offset == pytest.approx((-0.5 + 0.1, -1.5))
    turned = one("", "texture a.png\nrotate 90").asset.textures["base_color_map"]
    assert turned.rotation == pytest.approx(-1.5707963)
    assert turned.offset == pytest.approx((1.0, 0.0))


def test_normal_map_glow_and_the_rest_is_told() -> None:
    text = """
    sampler S { tex_address_mode clamp }
    material m { technique { scheme Other\n pass { lighting off } }
     technique { pass { depth_write off
        texture_unit { texture a.png }
        texture_unit { texture n.tga\n sampler_ref S\n rtshader_system { normal_map tangent_space } }
        texture_unit { texture glow_emissive.png\n colour_op add }
        texture_unit { texture sky.png cubic }
        texture_unit { texture s.png\n env_map spherical }
     } pass { scene_blend add } } }
    """
    material, images, findings = mapped(text)
    shown = {slot: images[use.image] for slot, use in material.images.items()}
    assert shown == {"base_color_map": "a.png", "normal_map": "n.tga", "emissive_map": "glow_emissive.png"}
    assert material.images["normal_map"].role == "normal"
    assert material.asset.textures["normal_map"].wrap_u == "clamp"
    assert material.asset.params["emissive"] == (1.0, 1.0, 1.0)
    (said,) = [f.message for f in findings if f.code == "ogre.material"]
    for what in ("depth_write off", "sky.png (cubic)", "env_map spherical", "2 techniques", "2 passes"):
        assert what in said


def test_ambient_only_passes_do_not_paint_the_material_black() -> None:
    text = """material m { technique {
        pass ambient { diffuse 0 0 0\n max_lights 0 }
        pass lighting { iteration once_per_light\n scene_blend add\n specular 1 1 1 30
            texture_unit { texture n.png\n rtshader_system { normal_map tangent_space } } }
        pass decal { lighting off\n scene_blend modulate\n texture_unit { texture d.png } } } }"""
    material, images, _ = mapped(text)
    assert {slot: images[use.image] for slot, use in material.images.items()} == {
        "normal_map": "n.png", "base_color_map": "d.png",
    }  # fmt: skip
    assert material.asset.queue == "opaque"
    assert material.asset.features == []
    assert "base_color" not in material.asset.params


def test_children_of_missing_pbr_parents_show_their_variables() -> None:
    text = 'material m : glTF2/PBR { set $Albedo "a b.jpg"\n set $Normal n.jpg\n set $MetalRoughness mr.jpg }'
    material, images, findings = mapped(text)
    shown = {slot: images[use.image] for slot, use in material.images.items()}
    assert shown == {"base_color_map": "a b.jpg", "metal_rough_map": "mr.jpg", "normal_map": "n.jpg"}
    assert "ogre.guess" in {f.code for f in findings}


# --- finding things ---


def test_scripts_and_images_in_sibling_folders(tmp_path: Path) -> None:
    path = save_mesh(tmp_path / "media" / "models", "Some/Name")
    script = tmp_path / "media" / "materials" / "scripts" / "all.material"
    script.parent.mkdir(parents=True)
    script.write_bytes(
        b"\xef\xbb\xbfmaterial Some/Name { technique { pass { texture_unit { texture skin.png } } } }\r\n"
    )
    save_image(tmp_path / "media" / "materials" / "textures" / "skin.png")
    model = load(path, SETTINGS)
    assert textures(model) == {"base_color_map": "skin.png"}
    assert not [f for f in model.findings if f.severity is not Severity.INFO]
    assert sorted(name for name, _ in dependencies(path, SETTINGS)) == ["all.material", "skin.png"]
    assert sorted(p.name for p in model.dependencies) == ["all.material", "skin.png"]


def test_the_nearest_script_counts(tmp_path: Path) -> None:
    path = save_mesh(tmp_path / "models", "M")
    for folder, image in ((tmp_path / "models", "near.png"), (tmp_path / "materials", "far.png")):
        save_image(folder / image)
        text = f"material M {{ technique {{ pass {{ texture_unit {{ texture {image} }} }} }} }}"
        (folder / "a.material").write_text(text)
    assert textures(load(path, SETTINGS)) == {"base_color_map": "near.png"}


def test_images_of_another_case_extension_or_spelling(tmp_path: Path) -> None:
    path = save_mesh(tmp_path, "M")
    save_image(tmp_path / "Skin_Diffuse.PNG")

    def with_texture(name: str) -> ImportedModel:
        text = f"material M {{ technique {{ pass {{ texture_unit {{ texture {name} }} }} }} }}"
        (tmp_path / "a.material").write_text(text)
        return load(path, SETTINGS)

    assert textures(with_texture("skin_diffuse.png")) == {"base_color_map": "Skin_Diffuse.PNG"}
    model = with_texture("skin_diffuse.dds")
    assert textures(model) == {"base_color_map": "Skin_Diffuse.PNG"}
    assert [f.code for f in model.findings if f.severity is Severity.WARNING] == ["ogre.guess"]
    model = with_texture("skin_difuse.png")
    assert textures(model) == {}
    assert model.materials[0].asset.textures["base_color_map"].path == ""
    (said,) = [f for f in model.findings if f.severity is Severity.ERROR]
    assert "skin_diffuse.png" in said.hint


def test_missing_materials_are_white_or_guessed_by_name(tmp_path: Path) -> None:
    (tmp_path / "a.material").write_text("material Wood { }")
    model = load(save_mesh(tmp_path, "Woood"), SETTINGS)
    (said,) = [f for f in model.findings if f.severity is Severity.WARNING]
    assert "did you mean 'Wood'" in said.hint
    assert model.materials[0].asset.params == {"metallic": 0.0, "roughness": 1.0}
    save_image(tmp_path / "grass.jpg")
    model = load(save_mesh(tmp_path, "level/TEXFACE/Grass.jpg"), SETTINGS)
    assert textures(model) == {"base_color_map": "grass.jpg"}
    assert not load(save_mesh(tmp_path, "BaseWhite"), SETTINGS).findings.has_errors


def test_texture_aliases_of_a_submesh(tmp_path: Path) -> None:
    for name in ("a.png", "b.png"):
        save_image(tmp_path / name)
    (tmp_path / "m.material").write_text("material M { technique { pass { texture_unit Main { texture a.png } } } }")
    alias = B.chunk(0x4200, B.text("Main"), B.text("b.png"))
    assert textures(load(save_mesh(tmp_path, "M", extra=alias), SETTINGS)) == {"base_color_map": "b.png"}


def test_vertex_colours_only_where_the_material_shows_them(tmp_path: Path) -> None:
    raw = b"".join(B.pack("3fI", x, y, 0, 0xFF8000FF) for x, y in ((0, 0), (1, 0), (0, 1)))
    data = B.mesh(B.submesh("M", [0, 1, 2], B.geometry(3, [([(2, 1, 0), (11, 5, 0)], raw)])))
    (tmp_path / "t.mesh").write_bytes(data)
    for body, there in (("diffuse vertexcolour", True), ("lighting off", True), ("diffuse 1 1 1", False)):
        (tmp_path / "m.material").write_text(f"material M {{ technique {{ pass {{ {body} }} }} }}")
        streams = load(tmp_path / "t.mesh", SETTINGS).meshes[0].streams
        assert ("color" in streams) is there
        if there:
            # 0xAABBGGRR: red 255, green 0, blue 128 decoded from sRGB
            assert streams["color"][0].tolist() == [65535, 0, 14146, 65535]


def test_looking_around_is_bounded(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("importers.ogre.folders.MAX_ENTRIES", 10)
    for k in range(20):
        (tmp_path / f"d{k:02}").mkdir()
        (tmp_path / f"d{k:02}" / "a.material").write_text("")
    (tmp_path / "loop").symlink_to(tmp_path)
    around = look_around(tmp_path, "t")
    assert not around.complete
    assert len(around.scripts) <= 10


def test_links_out_of_the_asset_are_not_followed(tmp_path: Path) -> None:
    deep = tmp_path / "a" / "b" / "c" / "d" / "models"
    deep.mkdir(parents=True)
    save_image(tmp_path / "secret.png")
    save_image(deep.parent / "textures" / "inside.png")
    (deep / "out.png").symlink_to(tmp_path / "secret.png")
    (deep / "in.png").symlink_to(deep.parent / "textures" / "inside.png")
    around = look_around(deep, "t")
    assert around.find("in.png") is not None
    assert around.find("out.png") is None
