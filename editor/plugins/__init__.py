"""Plug-ins: Python from outside that adds operations, panels, importers, passes and effects.

    entry points lucarna.plugins ─┐
    PROJECT/plugins/*.py ─────────┴─► discovery ─► manager: trusted? ─► its register(plugin) ─► registries
                                                      ^                     | raises
                                                      '── error file:line, off, the editor goes on

    api.py         Plugin: what `register` is given; everything it adds is taken back when it is switched off
    discovery.py   which there are
    manager.py     loads, guards, reloads what changed; a project's plug-ins only after the user has said so
    windows.py     the windows of their panels                                                              (imgui)

A plug-in runs with the user's rights: nothing here is a sandbox. What is guarded is the session: a plug-in that raises
is switched off and listed with the line, and no edit is lost.
"""
