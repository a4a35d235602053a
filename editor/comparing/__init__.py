"""Comparing: any earlier state of the view, A, beside what shows now. No imgui; drawn by editor.compare_overlay.

    operations.py   take A, show it, wipe, difference, swap, render path against render path
      v
    comparing.py    Comparing (of the session): A, how it is shown, the numbers
      |-- moment.py     Moment: render settings + a place in the undo history, rendered with the present camera
      '-- numbers.py    FLIP of two pictures by a worker process: half a second that no frame waits for

A is rendered again when the camera, the size or time changes, and only while it is looked at; what cannot be reached
any more (its branch of the history is gone) stays as the last picture of it.
"""
