"""Shader sources in the editor: the files that are open as text. No imgui, no GL; the panel draws them.

document.py     CodeDocument: a file's text, unsaved changes, conflicts with changes made elsewhere
files.py        CodeFiles: the open documents, which one is in front, copying built-in files into the project
problems.py     errors of the engine -> Problem (file, line, column, message), one for each place
completion.py   what could be meant at the cursor: includes, parameters, features, functions
"""
