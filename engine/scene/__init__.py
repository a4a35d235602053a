"""The scene as tables: numpy columns, one row per node, instance, light, camera. No GPU. May import core, math, assets.

    SceneAsset ─ convert ─> Scene ─ nodes ── parent, TRS ─ update() ─> world, visible_world
       ^                      │       ^ one batched product per level, touched subtrees only
       └───── to_asset ───────┤       │ node
                              ├─ instances (mesh, submesh, material, bounds) ─> world spheres ─ culling ─> bool[n]
                              ├─ skins (joints, bind; linear or dual) ─> palettes; morphs (weights by node): both grow
                              │    the spheres of what they bend
                              ├─ lights, cameras (name a node) ───────────────> world() structured rows
                              │    light_order: one order whatever the rows'; scatter: many at once, which drift;
                              │    arrays: lines, grids, rings of what there is; light_profiles
                              └─ counts() ─> what there is, hashable

Row numbers stay until the row is removed; a removed row's number is used again with the next generation. `Node` views
hold (table, row, generation) and refuse to work once stale; a frame never uses them. Columns are read-only arrays:
write through the tables' methods, so that what changed is known.
"""
