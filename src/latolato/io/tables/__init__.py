"""Tables of other programs: what a file holds, found from all of its lines.

A file passes through these steps, each of which is a module:

========================== ============== ==========================================
step                       module         result
========================== ============== ==========================================
open the file, decode it   `container`    texts: of the file, its members or sheets
tell apart kinds of lines  `shapes`       the few distinct shapes of its lines
take names out of rows     `keys`         lines of numbers below a line of names
choose the delimiter       `cells`        cells of a line and what each of them is
part header and rows       `layout`       blocks of header lines and rows
read the header            `headings`     columns with name, unit and track
set objects side by side   `joining`      one row for each time
choose the decimal sign    `numbers`      columns of numbers, or a refusal
read times on a clock      `clocks`       seconds
========================== ============== ==========================================

`read_source` in `source` calls one after the other and returns a `SourceTable`.
"""
