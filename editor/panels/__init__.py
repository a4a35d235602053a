"""The dockable panels, one a file. A panel reads the session, proposes edits and runs operations; it owns only its
own view state (what is unfolded, what is typed in its filter).

    registry.py  the list; base.py  what a panel is
    A new panel: one file with a class, its module's name in registry.PANELS.
"""
