"""The scene as tables: numpy columns, one row per node, instance, light, camera. No GPU. May import core, math, assets.

    SceneAsset ─ convert ─> Scene ─ nodes ── parent, TRS ─ update() ─> world, visible_world
       ^                      │       ^ one batched product per level, touched subtrees only
       └───── to_asset ───────┤       │ node
                              ├─ instances (mesh, submesh, material, bounds) ─> world spheres ─ culling ─> bool[n]
                              ├─ lights, cameras (name a node) ───────────────> world() structured rows
                              └─ counts() ─> what there is, hashable

Row numbers stay until the row is removed; a removed row's number is used again with the next generation. `Node` views
hold (table, row, generation) and refuse to work once stale; a frame never uses them. Columns are read-only arrays:
write through the tables' methods, so that what changed is known.
"""
