"""Where the numbers of lanes lie: rows of a flat workspace and of the table of a step.

Row R of lane j is ``w[R * LANES + j]``: constants, so that the compiler sees which rows cannot
overlap.
"""

from __future__ import annotations

# Lanes that step together: several vectors in flight hide the latency of the sine's polynomial.
LANES = 128
# Lanes are used in blocks of so many: with few points, the blocks behind them are left out.
BLOCK = 32

# Rows of the workspace, each LANES wide. First the motion: angle, velocity, restoring, the drive's
# pull and its quadrature, work, loss. Then its copy at the start of the step.
X, V, S, C, D, WORK, LOSS = 0, 1, 2, 3, 4, 5, 6
COPY = 7
X0, V0, S0, C0 = X + COPY, V + COPY, S + COPY, C + COPY
G, LOW, HIGH = 14, 15, 16  # gravity's pull and the walls
T, N, HALT = 17, 18, 19  # start of the step pattern [s], steps since, steps until a halt
H, PER_H, RATE = 20, 21, 22  # step [s], its inverse, rate of the drag
TAKEN = 23  # 1 where the full step is taken, 0 where the lane is put back
X1, V1, A1 = 24, 25, 26  # end of a step that is not taken, in radians and seconds
# The matrix of a step, in radians and steps: what starts as a unit of angle, and of velocity.
ANGLE_OF_ANGLE, VELOCITY_OF_ANGLE, ANGLE_OF_VELOCITY, VELOCITY_OF_VELOCITY = 27, 28, 29, 30
# What observables share: the angle at a turn, potentials at both ends, which lanes are chosen and
# their list; see `lane_flight.make_survey`.
TURN, P0, P1, CHOSEN, LIST = 31, 32, 33, 34, 35
# How many blocks are in use, in the first number of its row.
BLOCKS = 36
ROWS = 37

# Rows of the step's table: for each kick cosine and sine of the drive's turn since the start of the
# step, for each drift its reach and what it leaves of the velocity.
DRIFT_TIME, LEFT, COS, SIN = 0, 1, 2, 3
TABLE_ROWS = 4

# The halt of a lane that waits for its impact to be located.
WAITS = -1.0

# Impacts are gathered until so many can be located together.
IMPACTS = 16
# Rows of the impacts' workspace, in units of the step: both ends of the full step, its quintic's
# coefficients, the wall, laws and the drive's phase.
IX0, IV0, IA0, IX1, IV1, IA1 = 0, 1, 2, 3, 4, 5
IB, IC2, IC3, IC4, IC5 = 6, 7, 8, 9, 10
IWALL, IFAR, IG, ISCALE, IPHASE, ITURN, IDRAG, INEAR = 11, 12, 13, 14, 15, 16, 17, 18
# The search: bracket and share of the step; then the motion at that share, and what is missing.
ILOW, IHIGH, IU = 19, 20, 21
IX, IV, IS, IF, IDRIVEN, IWORK, ILOSS, IMISS, DONE = 22, 23, 24, 25, 26, 27, 28, 29, 30
IMPACT_ROWS = 31
# What is noted of an impact; the rest is found.
NOTED_ROWS = INEAR + 1
