"""One engine for one ball and for two: modes of motion, events between them, and the loop.

A *mode* (`flight`, `rest`, `joint`) plans a step up to the goal or to the first *event* in it
(`turn`, `contact`, `settle`, `release`), which changes the motion and perturbations of it.
Everything that a step reads and writes lies in one record, `run`; its layout is in `record`.
"""
