"""Edits as values: what changed in which table column, and the history of it. Imports the standard library only.

command.py   Command(table, column, rows, before, after): can be inverted, merged, printed
history.py   History: do, undo, redo; a drag becomes one entry; knows whether the document is dirty
"""
