"""Small ASCII FBX 7.4 files made by tests: a scene of nodes, meshes, materials, skins and curves, in any unit."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

#: FBX time units per second
SECOND = 46186158000

QUAD = [(0.0, 0.0, 0.0), (100.0, 0.0, 0.0), (100.0, 200.0, 0.0), (0.0, 200.0, 0.0)]


class FbxBuilder:
    """`unit`: centimetres per unit; `up`: y or z. Every method returns the new object's id; 0 is the scene's root."""

    def __init__(self, unit: float = 1.0, up: str = "y", application: str = "Test") -> None:
        self.unit, self.up, self.application = unit, up, application
        self.objects: list[str] = []
        self.links: list[str] = []

    def add(self, text: str) -> int:
        number = len(self.objects) + 1000
        self.objects.append(text.replace("@", str(number), 1))
        return number

    def link(self, child: int, parent: int, prop: str = "") -> None:
        self.links.append(f'C: "OP",{child},{parent}, "{prop}"' if prop else f'C: "OO",{child},{parent}')

    def node(self, name: str, parent: int = 0, kind: str = "Mesh", **properties: Sequence[float] | float) -> int:
        """`properties`: Lcl_Translation=(…), PreRotation=(…), RotationActive=1, …"""
        lines = [
            f'P: "{key.replace("_", " ")}", "", "", "A",{_list(value)}' for key, value in properties.items()
        ]  # fmt: skip
        number = self.add(
            f'Model: @, "Model::{name}", "{kind}" {{\nVersion: 232\nProperties70: {{\n{_join(lines)}\n}}\n}}'
        )
        self.link(number, parent)
        return number

    def mesh(
        self, node: int, points: Sequence[Sequence[float]] = QUAD,
        polygons: Sequence[Sequence[int]] = ((0, 1, 2, 3),), uv: Sequence[Sequence[float]] | None = None,
    ) -> int:  # fmt: skip
        """`uv`: one per corner, in the order of the polygons."""
        indices = [v if k + 1 < len(p) else -v - 1 for p in polygons for k, v in enumerate(p)]
        layers = ""
        if uv is not None:
            layers = (
                f'LayerElementUV: 0 {{\nName: "map1"\nMappingInformationType: "ByPolygonVertex"\n'
                f'ReferenceInformationType: "Direct"\n{_array("UV", [x for row in uv for x in row])}\n}}\n'
                'Layer: 0 {\nVersion: 100\nLayerElement: {\nType: "LayerElementUV"\nTypedIndex: 0\n}\n}'
            )
        number = self.add(
            f'Geometry: @, "Geometry::", "Mesh" {{\n{_array("Vertices", [x for p in points for x in p])}\n'
            f"{_array('PolygonVertexIndex', indices)}\n{layers}\n}}"
        )
        self.link(number, node)
        return number

    def material(self, node: int, name: str = "paint", **properties: Sequence[float] | float) -> int:
        lines = [f'P: "{key}", "Color", "", "A",{_list(value)}' for key, value in properties.items()]
        number = self.add(
            f'Material: @, "Material::{name}", "" {{\nVersion: 102\nShadingModel: "phong"\n'
            f"Properties70: {{\n{_join(lines)}\n}}\n}}"
        )
        self.link(number, node)
        return number

    def texture(self, material: int, file: str, prop: str = "DiffuseColor", relative: str = "") -> int:
        number = self.add(
            f'Texture: @, "Texture::image", "" {{\nType: "TextureVideoClip"\nFileName: "{file}"\n'
            f'RelativeFilename: "{relative or file}"\n}}'
        )
        self.link(number, material, prop)
        return number

    def skin(
        self, geometry: int, clusters: Sequence[tuple[int, Sequence[int], Sequence[float], Sequence[float]]]
    ) -> int:
        """`clusters`: (bone's node, points, weights, the bone's world matrix at bind, 16 numbers row by row of the
        transpose, as FBX has it); the mesh was bound at the origin."""
        skin = self.add('Deformer: @, "Deformer::", "Skin" {\nVersion: 101\n}')
        self.link(skin, geometry)
        for bone, points, weights, bind in clusters:
            inverse = [1.0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, *(-v for v in bind[12:15]), 1]
            cluster = self.add(
                f'Deformer: @, "SubDeformer::", "Cluster" {{\nVersion: 100\n{_array("Indexes", points)}\n'
                f"{_array('Weights', weights)}\n{_array('Transform', inverse)}\n{_array('TransformLink', bind)}\n}}"
            )
            self.link(cluster, skin)
            self.link(bone, cluster)
        return skin

    def shape(self, geometry: int, name: str, points: Sequence[int], offsets: Sequence[Sequence[float]]) -> int:
        """A blend shape at weight 0; returns its channel."""
        blend = self.add('Deformer: @, "Deformer::", "BlendShape" {\nVersion: 100\n}')
        channel = self.add(
            f'Deformer: @, "SubDeformer::{name}", "BlendShapeChannel" {{\nVersion: 100\nDeformPercent: 0\n'
            f"{_array('FullWeights', [100.0])}\n}}"
        )
        shape = self.add(
            f'Geometry: @, "Geometry::{name}", "Shape" {{\nVersion: 100\n{_array("Indexes", points)}\n'
            f"{_array('Vertices', [x for row in offsets for x in row])}\n}}"
        )
        self.link(blend, geometry)
        self.link(channel, blend)
        self.link(shape, channel)
        return channel

    def stack(self, name: str, start: float, stop: float) -> int:
        """An animation stack with one layer; returns the layer."""
        span = "\n".join(
            f'P: "{key}", "KTime", "Time", "",{round(value * SECOND)}'
            for key, value in (("LocalStart", start), ("LocalStop", stop))
        )
        stack = self.add(f'AnimationStack: @, "AnimStack::{name}", "" {{\nProperties70: {{\n{span}\n}}\n}}')
        layer = self.add('AnimationLayer: @, "AnimLayer::Base", "" {\n}')
        self.link(layer, stack)
        return layer

    def curve(self, layer: int, target: int, prop: str, channel: str, keys: Sequence[tuple[float, float]]) -> None:
        """Linear keys (seconds, value) for `prop` of `target`; `channel`: d|X, d|Y, d|Z or d|DeformPercent."""
        value = f'P: "{channel}", "Number", "", "A",0'
        node = self.add(f'AnimationCurveNode: @, "AnimCurveNode::T", "" {{\nProperties70: {{\n{value}\n}}\n}}')
        times = _array("KeyTime", [round(t * SECOND) for t, _ in keys])
        values = _array("KeyValueFloat", [v for _, v in keys])
        curve = self.add(
            f'AnimationCurve: @, "AnimCurve::", "" {{\nDefault: 0\nKeyVer: 4009\n{times}\n{values}\n'
            f"{_array('KeyAttrFlags', [4])}\n{_array('KeyAttrDataFloat', [0.0, 0, 0, 0])}\n"
            f"{_array('KeyAttrRefCount', [len(keys)])}\n}}"
        )
        self.link(node, layer)
        self.link(node, target, prop)
        self.link(curve, node, channel)

    def text(self) -> str:
        axes = {"y": ((1, 1), (2, 1), (0, 1)), "z": ((2, 1), (1, -1), (0, 1))}[self.up]
        settings = [
            f'P: "{name}", "int", "Integer", "",{axis}\nP: "{name}Sign", "int", "Integer", "",{sign}'
            for name, (axis, sign) in zip(("UpAxis", "FrontAxis", "CoordAxis"), axes, strict=True)
        ]
        settings += [f'P: "UnitScaleFactor", "double", "Number", "",{self.unit}', 'P: "TimeMode", "enum", "", "",11']
        return (
            "; FBX 7.4.0 project file\n"
            'FBXHeaderExtension: {\nFBXHeaderVersion: 1003\nFBXVersion: 7400\nCreator: "test"\n'
            f'SceneInfo: "SceneInfo::GlobalInfo", "UserData" {{\nProperties70: {{\n'
            f'P: "Original|ApplicationName", "KString", "", "", "{self.application}"\n}}\n}}\n}}\n'
            f"GlobalSettings: {{\nVersion: 1000\nProperties70: {{\n{_join(settings)}\n}}\n}}\n"
            f"Objects: {{\n{_join(self.objects)}\n}}\nConnections: {{\n{_join(self.links)}\n}}\n"
        )

    def write(self, path: Path) -> Path:
        path.write_text(self.text(), encoding="utf-8")
        return path


def _array(name: str, values: Sequence[float]) -> str:
    return f"{name}: *{len(values)} {{\na: {_list(values)}\n}}"


def _list(values: Sequence[float] | float) -> str:
    return repr(values) if isinstance(values, (int, float)) else ",".join(map(repr, values))


def _join(lines: Sequence[str]) -> str:
    return "\n".join(lines)


def rich_scene() -> str:
    """A bit of everything that the reader reads."""
    fbx = FbxBuilder(unit=2.54, up="z", application="Maya")
    root = fbx.node("root", kind="Null", Lcl_Rotation=(10.0, 20.0, 30.0))
    node = fbx.node("plate", root, GeometricTranslation=(1.0, 2.0, 3.0))
    corners = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0), (0.0, 0.0), (1.0, 0.0), (1.0, 1.0)]
    geometry = fbx.mesh(node, [*QUAD, (50.0, 300.0, 0.0)], ((0, 1, 2, 3), (3, 2, 4)), corners)
    fbx.texture(fbx.material(node, DiffuseColor=(1.0, 0.5, 0.0)), "x.png")
    bone = fbx.node("bone", kind="LimbNode")
    bind = [1.0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]
    fbx.skin(geometry, [(bone, [0, 1, 2], [1.0, 0.5, 0.25], bind), (root, [2, 3], [0.75, 1.0], bind)])
    channel = fbx.shape(geometry, "up", [4], [(0.0, 0.0, 10.0)])
    layer = fbx.stack("go", 0.0, 1.0)
    fbx.curve(layer, bone, "Lcl Rotation", "d|Y", [(0.0, 0.0), (1.0, 90.0)])
    fbx.curve(layer, node, "Lcl Translation", "d|X", [(0.0, 0.0), (1.0, 9.0)])
    fbx.curve(layer, channel, "DeformPercent", "d|DeformPercent", [(0.0, 0.0), (1.0, 100.0)])
    return fbx.text()
