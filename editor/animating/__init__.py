"""Animation in the editor, without imgui: edits of an animation file, what the panels show of it, its operations.

panels ─> operations.py ─ new text ─> session.edit("animation", "text", …) ─> Runtime.set_animation
             │                             (one entry of the history a gesture; journalled; saved beside the scene)
             └─ edits.py: text -> text, comments and layout kept
time_scale.py: seconds <-> pixels, ticks, snapping      rows.py: what the dope sheet and the curves show, and where
following.py: the session's clock and log follow what drives the scene
"""
