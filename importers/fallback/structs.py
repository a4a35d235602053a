"""Assimp's C structures as ctypes: those we read, for the library versions whose layout is known.

Source: the headers scene.h, mesh.h, anim.h, material.h, texture.h, light.h and camera.h of Assimp 5.2 and 6.0. Between
the two only aiQuatKey changed its size (24 to 32 bytes: 5.3 added an interpolation to every key).
"""

from __future__ import annotations

import ctypes as c

#: (major, minor) that `layout_for` knows
OLDEST, NEWEST = (5, 1), (6, 0)


class String(c.Structure):
    _fields_ = [("length", c.c_uint32), ("data", c.c_char * 1024)]

    def text(self) -> str:
        """What it holds; bytes that are no UTF-8 are read as Latin-1."""
        raw = c.string_at(c.addressof(self) + 4, min(int(self.length), 1024))
        try:
            return raw.decode("utf-8")
        except UnicodeDecodeError:
            return raw.decode("latin-1")


class Vector2(c.Structure):
    _fields_ = [("x", c.c_float), ("y", c.c_float)]


class Vector3(c.Structure):
    _fields_ = [("x", c.c_float), ("y", c.c_float), ("z", c.c_float)]


Matrix4 = c.c_float * 16


class Node(c.Structure):
    pass


Node._fields_ = [
    ("name", String), ("matrix", Matrix4), ("parent", c.POINTER(Node)), ("child_count", c.c_uint),
    ("children", c.POINTER(c.POINTER(Node))), ("mesh_count", c.c_uint), ("meshes", c.POINTER(c.c_uint)),
    ("metadata", c.c_void_p),
]  # fmt: skip


class Bone(c.Structure):
    _fields_ = [
        ("name", String), ("weight_count", c.c_uint), ("armature", c.c_void_p), ("node", c.c_void_p),
        ("weights", c.c_void_p), ("offset", Matrix4),
    ]  # fmt: skip


class AnimMesh(c.Structure):
    _fields_ = [
        ("name", String), ("positions", c.c_void_p), ("normals", c.c_void_p), ("tangents", c.c_void_p),
        ("bitangents", c.c_void_p), ("colors", c.c_void_p * 8), ("uvs", c.c_void_p * 8), ("vertex_count", c.c_uint),
        ("weight", c.c_float),
    ]  # fmt: skip


class Mesh(c.Structure):
    _fields_ = [
        ("primitive_types", c.c_uint), ("vertex_count", c.c_uint), ("face_count", c.c_uint),
        ("positions", c.c_void_p), ("normals", c.c_void_p), ("tangents", c.c_void_p), ("bitangents", c.c_void_p),
        ("colors", c.c_void_p * 8), ("uvs", c.c_void_p * 8), ("uv_components", c.c_uint * 8),
        ("faces", c.c_void_p), ("bone_count", c.c_uint), ("bones", c.POINTER(c.POINTER(Bone))),
        ("material", c.c_uint), ("name", String), ("anim_mesh_count", c.c_uint),
        ("anim_meshes", c.POINTER(c.POINTER(AnimMesh))), ("method", c.c_uint), ("box", c.c_float * 6),
        ("uv_names", c.c_void_p),
    ]  # fmt: skip


class Property(c.Structure):
    _fields_ = [
        ("key", String), ("semantic", c.c_uint), ("index", c.c_uint), ("size", c.c_uint), ("type", c.c_uint),
        ("data", c.c_void_p),
    ]  # fmt: skip


class Material(c.Structure):
    _fields_ = [("properties", c.POINTER(c.POINTER(Property))), ("count", c.c_uint), ("allocated", c.c_uint)]


class NodeAnim(c.Structure):
    _fields_ = [
        ("name", String), ("position_count", c.c_uint), ("positions", c.c_void_p), ("rotation_count", c.c_uint),
        ("rotations", c.c_void_p), ("scale_count", c.c_uint), ("scales", c.c_void_p), ("before", c.c_uint),
        ("after", c.c_uint),
    ]  # fmt: skip


class MorphKey(c.Structure):
    _fields_ = [
        ("time", c.c_double), ("values", c.POINTER(c.c_uint)), ("weights", c.POINTER(c.c_double)), ("count", c.c_uint),
    ]  # fmt: skip


class MorphAnim(c.Structure):
    _fields_ = [("name", String), ("count", c.c_uint), ("keys", c.POINTER(MorphKey))]


class Animation(c.Structure):
    _fields_ = [
        ("name", String), ("duration", c.c_double), ("rate", c.c_double), ("channel_count", c.c_uint),
        ("channels", c.POINTER(c.POINTER(NodeAnim))), ("mesh_channel_count", c.c_uint), ("mesh_channels", c.c_void_p),
        ("morph_count", c.c_uint), ("morphs", c.POINTER(c.POINTER(MorphAnim))),
    ]  # fmt: skip


class Texture(c.Structure):
    _fields_ = [
        ("width", c.c_uint), ("height", c.c_uint), ("hint", c.c_char * 9), ("data", c.c_void_p), ("name", String),
    ]  # fmt: skip


class Light(c.Structure):
    _fields_ = [
        ("name", String), ("type", c.c_uint), ("position", Vector3), ("direction", Vector3), ("up", Vector3),
        ("constant", c.c_float), ("linear", c.c_float), ("quadratic", c.c_float), ("diffuse", Vector3),
        ("specular", Vector3), ("ambient", Vector3), ("inner", c.c_float), ("outer", c.c_float), ("size", Vector2),
    ]  # fmt: skip


class Camera(c.Structure):
    _fields_ = [
        ("name", String), ("position", Vector3), ("up", Vector3), ("look", Vector3), ("fov", c.c_float),
        ("near", c.c_float), ("far", c.c_float), ("aspect", c.c_float), ("ortho_width", c.c_float),
    ]  # fmt: skip


class Scene(c.Structure):
    _fields_ = [
        ("flags", c.c_uint), ("root", c.POINTER(Node)), ("mesh_count", c.c_uint),
        ("meshes", c.POINTER(c.POINTER(Mesh))), ("material_count", c.c_uint),
        ("materials", c.POINTER(c.POINTER(Material))), ("animation_count", c.c_uint),
        ("animations", c.POINTER(c.POINTER(Animation))), ("texture_count", c.c_uint),
        ("textures", c.POINTER(c.POINTER(Texture))), ("light_count", c.c_uint),
        ("lights", c.POINTER(c.POINTER(Light))), ("camera_count", c.c_uint), ("cameras", c.POINTER(c.POINTER(Camera))),
    ]  # fmt: skip


def quat_key_size(version: tuple[int, int]) -> int:
    """Bytes of one aiQuatKey in that version."""
    return 24 if version < (5, 3) else 32


#: bytes on 64-bit machines, as a C compiler says; checked when the library is opened
SIZES = {
    Node: 1144, Bone: 1120, AnimMesh: 1200, Mesh: 1320, Property: 1056, Material: 16, NodeAnim: 1080, MorphKey: 32,
    MorphAnim: 1040, Animation: 1096, Texture: 1064, Light: 1132, Camera: 1084,
}  # fmt: skip
