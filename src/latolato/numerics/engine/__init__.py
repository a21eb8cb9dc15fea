"""One engine for one ball and for two: modes of motion, events between them, and the loop.

A *mode* (`flight`, `rest`, `joint`) plans a step up to the goal or to the first *event* in it
(`contact`, `release`, `turn`); an event says what it does to the motion and to small deviations.
Everything that a step reads and writes lies in one record, `run`; its layout is in `record`.
"""
