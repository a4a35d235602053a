"""Shader sources in the editor: the files that are open as text. No imgui, no GL; the panel draws them.

document.py     CodeDocument: a file's text, unsaved changes, conflicts with changes made elsewhere
files.py        CodeFiles: the open documents, which one is in front, copying built-in files into the project
problems.py     errors of the engine -> Problem (file, line, column, message), one for each place
search.py       where something occurs, and the text with it replaced
gestures.py     what of many small edits is one step of undo
line_ends.py    a text without them <-> a file with the ones it had
completion.py   what could be meant at the cursor: includes, parameters, features, functions
glsl_words.py   what GLSL itself offers; toml_words.py  the keys and values of effect and material files
variant_rows.py the shader variants of an open runtime, as rows to show
feature_work.py which of their features never change a pixel
"""
