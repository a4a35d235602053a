"""How deep an orthographic view is drawn: no deeper than what is there, so that depth is fine where things are.

Its depth is even in distance: over a range of 10^6 m, float32 tells 6 cm apart, and what is rebuilt from depth
(deferred light, light lists, occlusion) would be as coarse. A perspective view has no such range: it ends nowhere.
"""

from __future__ import annotations

import math
from dataclasses import replace

from engine.render.view import View
from engine.scene.scene import Scene

#: of the depth in use; things may stand out of their bounds a little (displaced by an effect of their own)
MARGIN = 1.25


def fit_depth(view: View, scene: Scene) -> View:
    """`view`, or, where that is orthographic and ends far behind all that is drawn, one that ends sooner. Depths go in
    powers of two, so that a thing that moves does not change the range in every frame."""
    camera = view.camera
    drawn = scene.instances.drawn
    if camera.ymag <= 0.0 or not drawn.any():
        return view
    ahead = -camera.world_from_camera[:3, 2]
    reach = (scene.instances.world_center[drawn] - camera.position) @ ahead + scene.instances.world_radius[drawn]
    depth = (float(reach.max()) - camera.znear) * MARGIN
    if not (math.isfinite(depth) and depth > 0.0):
        return view
    zfar = camera.znear + 2.0 ** math.ceil(math.log2(max(depth, 1e-6)))
    return view if zfar >= camera.zfar else replace(view, camera=replace(camera, zfar=zfar))
