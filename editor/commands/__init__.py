"""Edits as values, and the history of them. No imgui, no GPU.

command.py    Command(table, column, rows, before, after): can be inverted, merged, printed
structure.py  StructureCommand(patch): nodes added, removed, hung elsewhere; restores the tables row by row
replacement.py  Replacement: the whole scene became another one; FileStep: files changed beside it
lights.py     lights scattered over a box; whatever is selected, in an array
history.py    History: do, undo, redo, go to; a drag becomes one entry; tells a listener (the journal) what happened
"""
