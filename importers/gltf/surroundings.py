"""How a file wants to be shown: `scenes[i].extras.lucarna`, in the words of a scene file.

    "extras": {"lucarna": {"environment": {"kind": "studio", "background": "color"}, "look": {"tone_map": "agx"}}}

Other programs ignore it; glTF has no word for it of its own. What is wrong in it is a finding, and the defaults stay.
"""

from __future__ import annotations

from engine.assets.records import Bad
from engine.assets.scene import EnvironmentAsset, LookAsset
from engine.assets.scene_json import read_surroundings as read
from importers.gltf.document import Document


def read_surroundings(doc: Document) -> tuple[EnvironmentAsset, LookAsset]:
    """Environment and look of the file's scene."""
    index = doc.root.get("scene", 0)
    scenes = doc.objects("scenes")
    scene = scenes[index] if type(index) is int and 0 <= index < len(scenes) else {}
    extras = scene.get("extras")
    wish = extras.get("lucarna") if isinstance(extras, dict) else None
    if wish is None:
        return EnvironmentAsset(), LookAsset()
    where = f"scenes[{index}].extras.lucarna"
    try:
        environment, look = read(wish)
        if environment.kind == "image":
            raise Bad("an image cannot come along in extras", "environment.kind", "choose the image in the scene file")
    except Bad as bad:
        doc.findings.warn("gltf.extras", bad.message, f"{where}.{bad.path}" if bad.path else where, bad.hint)
        return EnvironmentAsset(), LookAsset()
    return environment, look
