"""Folds a drive into the trajectory of two balls that collide, rest on each other and part.

In flight each ball is advanced by itself; what couples them is the separation
``angle_1 - angle_2``, which stays between the contact separations. In lasting contact both swing
as one body, an equivalent pendulum of its own, until the contact force would pull. A ball that
Coulomb friction holds has the sign 0.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from latolato.numerics.bounce import hop
from latolato.numerics.engine.swing import SHORTEST, tension_at
from latolato.numerics.flight import (
    ANGLE,
    SHORTEST_REST,
    VELOCITY,
    Method,
    Part,
    follow_ledger,
    make_flight,
    prepare,
    write_ledger,
)
from latolato.numerics.pair_flight import (
    FORCE,
    GAIN,
    JOINT,
    LIFT,
    LOSS,
    STUCK,
    Pair,
    V,
    X,
    add_slack,
    make_pair_flight,
    point_of,
    write_pair_contact,
)
from latolato.numerics.pair_step import make_pair_step
from latolato.numerics.pair_tangent import make_pair_tangent
from latolato.numerics.records import (
    ANGLE_1,
    ANGLE_2,
    CAPTURED,
    CONTACT,
    DAMPED,
    FIRST_ENERGY,
    FLIGHT,
    GRAZES,
    IMPACT,
    KICKED,
    LARGEST_ENERGY,
    MATRIX,
    MODE,
    NOISE,
    REST_HIGH,
    REST_LOW,
    SAMPLE,
    STEPS,
    STRETCH,
    T_BASE,
    TOTAL_STEPS,
    UNSETTLED,
    VELOCITY_1,
    VELOCITY_2,
    WORK,
)
from latolato.numerics.watch import BLIND, Hooks, make_watch
from latolato.physics.contacts import BOTTOM, RELEASE, REST, TOP

_PARTS = 0.25  # see `latolato.numerics.fold`
# Of a step within which the balls part too little to be seen: as long they stay together.
_HOLD = _PARTS / 16.0
# The rounding of a separation, per sum of the angles' sizes and a few rad.
_ROUNDING = 1e-15


def make_pair_trajectory(
    acceleration: Callable[..., float],
    restoring: Callable[..., float],
    potential: Callable[..., float],
    compile_part: Part | None = None,
    hooks: tuple[Hooks, ...] = BLIND,
) -> Callable[..., int]:
    """Return the function that carries the state of two balls on.

    Arguments and effects are those of `latolato.numerics.fold.make_trajectory`; `bodies` holds
    both balls and the body they form at the bottom and at the top.
    """
    flight = make_flight(acceleration, restoring, compile_part)
    watch = make_watch(hooks, compile_part)
    watches = bool(hooks[0])
    follows_tangent = bool(hooks[4])
    deviate = make_pair_tangent(acceleration, restoring, watch.tangent, compile_part)
    fly, turn_back, move_jointly, unite, collide, jump = deviate
    pair_flight = make_pair_flight(flight, acceleration, restoring, compile_part)
    (
        _, go, go_by, both, locate_gap, leave_gap, parting, strike, settle_signs, join, split,
        joint_margin, joint_pulls, dip,
    ) = pair_flight  # fmt: skip
    (
        notice, slowed, energy_of, laws_of, part_at, first_turning, wall_met, sample_flight,
        sample_joint, note_slack, shove, halt,
    ) = make_pair_step(
        flight, pair_flight, acceleration, restoring, potential, watch.step, compile_part
    )  # fmt: skip
    turn = flight.turn

    def trajectory(
        state: Any,
        counters: Any,
        settings_row: Any,
        bodies: Any,
        stretches: Any,
        starts: Any,
        jumps: Any,
        kick_times: Any,
        kicks_given: Any,
        tables: Any,
        space: Any,
        kicks: Any,
        drifts: Any,
        nodes: Any,
        sample_times: Any,
        samples: Any,
        contact_times: Any,
        contact_kinds: Any,
        contact_values: Any,
        stop: float,
        most_steps: int,
        acc: Any,
        column: int,
        columns: int,
    ) -> int:
        settings = settings_row[0]
        g, h = settings.gravity, settings.step
        low, high = settings.low, settings.high
        q, r, w, signs, jacobian = space[0], space[1], space[2], space[3, 0], space[MATRIX]
        for i in range(3):
            signs[i] = 0.0
            for j in range(7):
                q[i, j] = r[i, j] = w[i, j] = 0.0
        nonlinear = False
        rubs = bodies[0].coulomb > 0.0 or bodies[1].coulomb > 0.0
        for i in range(2):
            nonlinear = nonlinear or bodies[i].quadratic > 0.0 or bodies[i].coulomb > 0.0
            prepare(Method(tables[i], kicks, drifts, nodes), h, bodies[i].rate)
        share = bodies[0].inertia / (bodies[0].inertia + bodies[1].inertia)
        methods = (
            Method(tables[3], kicks, drifts, nodes),
            Method(tables[4], kicks, drifts, nodes),
            Method(tables[5], kicks, drifts, nodes),
        )

        t_base, n = state[T_BASE], counters[STEPS]
        q[0, X], q[0, V], q[1, X], q[1, V] = (
            state[ANGLE_1], state[VELOCITY_1], state[ANGLE_2], state[VELOCITY_2],
        )  # fmt: skip
        work, damped, lost = state[WORK], state[DAMPED], state[IMPACT]
        captured, noise = state[CAPTURED], state[NOISE]
        mode, stretch, sample = counters[MODE], counters[STRETCH], counters[SAMPLE]
        kicked = counters[KICKED]
        table_of_contacts = (contact_times, contact_kinds, contact_values)
        rows, room = 0, len(contact_times) - 4
        t = t_base + n * h
        p = stretches[stretch]
        pair = Pair(signs, laws_of(g, bodies, p), methods)
        done = 0
        # Which contact the balls are just leaving: their distance from it may be rounding.
        leaving = 0.0
        far = -1.0 if mode == REST_LOW else 1.0
        strikes = False
        # Until when the balls stay together though a pull may part them too little to be seen.
        held_until = t
        follows_ledger = settings.follows_ledger != 0

        if mode == UNSETTLED:
            mode = FLIGHT
            state[FIRST_ENERGY] = state[LARGEST_ENERGY] = energy_of(q, bodies, g)
            gap = q[0, X] - q[1, X]
            if gap <= low + 1e-12 or gap >= high - 1e-12:
                far = -1.0 if gap <= low + 1e-12 else 1.0
                leaving = far
                strikes = (q[0, V] - q[1, V]) * far >= 0.0
            settle_signs(t, q, pair)
        else:
            settle_signs(t, q, pair)
            if mode == FLIGHT:
                gap = q[0, X] - q[1, X]
                leaving = -1.0 if gap <= low + 1e-12 else (1.0 if gap >= high - 1e-12 else 0.0)
                if (q[0, V] - q[1, V]) * leaving > 0.0:
                    leaving = 0.0

        while strikes or t < held_until or (t < stop and done < most_steps and rows < room):
            done += 1
            if settings.mirrored != 0:  # an unstable symmetry would be lost to roundings
                x, v = 0.5 * (q[0, X] - q[1, X]), 0.5 * (q[0, V] - q[1, V])
                q[0, X], q[0, V], q[1, X], q[1, V] = x, v, -x, -v
            if strikes:
                strikes = False
                before = (q[0, V], q[1, V])
                forces = (
                    slowed(q[0, FORCE], q[0, V], signs[0], bodies[0]),
                    slowed(q[1, FORCE], q[1, V], signs[1], bodies[1]),
                )
                impact, caught, rests = strike(far, t, q, settings, pair)
                lost += impact
                captured += caught
                after = (q[0, V], q[1, V])
                captures = rests and impact == 0.0
                if before[0] != before[1] or t > 0.0:
                    kind = REST if captures else (BOTTOM if far < 0.0 else TOP)
                    rows = write_pair_contact(*table_of_contacts, rows, t, kind, before, after)
                    if rests and not captures:
                        rows = write_pair_contact(*table_of_contacts, rows, t, REST, after, after)
                settle_signs(t, q, pair)
                leaving = far
                if rests:
                    mode = REST_LOW if far < 0.0 else REST_HIGH
                if follows_tangent and (rests or before[0] == before[1]):
                    unite(acc, column, columns, jacobian, share)
                elif follows_tangent:
                    e = settings.restitution
                    collide(acc, column, columns, jacobian, share, e, before, forces, q, pair)
                continue

            goal, at_stretch, at_kick = stop, False, False
            if stretch + 1 < len(starts) and starts[stretch + 1] <= goal:
                goal, at_stretch = starts[stretch + 1], True
            if kicked < len(kick_times) and kick_times[kicked] <= goal:
                at_stretch = at_stretch and kick_times[kicked] == goal
                goal, at_kick = kick_times[kicked], True
            hs = h
            t_new = t_base + (n + 1) * h
            reaches_goal = t_new >= goal - 1e-9 * h
            if reaches_goal:
                hs, t_new = goal - t, goal

            if hs > 0.0 and mode != FLIGHT:
                gap = low if far < 0.0 else high
                offset = settings.offset_low if far < 0.0 else settings.offset_high
                law = pair.laws[2] if far < 0.0 else pair.laws[3]
                inertia = law.body.inertia
                join(t, q, offset, law, pair)
                parts, held = False, held_until > t
                if held and held_until < t_new:
                    hs, t_new, reaches_goal = held_until - t, held_until, False
                margin = joint_margin(hs, far, offset, gap, t, q, r, w, law, pair)
                turned = nonlinear and r[JOINT, V] * signs[JOINT] < 0.0
                if turned:
                    hs = turn(hs, point_of(t, q, JOINT), signs[JOINT], methods[JOINT], law)
                    hs = max(hs, SHORTEST * t)
                    margin = joint_margin(hs, far, offset, gap, t, q, r, w, law, pair)
                end = hs
                if held:
                    margin = 0.0
                elif margin >= 0.0:
                    end = dip(hs, margin, far, offset, gap, t, q, r, w, law, pair)
                    margin = margin if end == hs else -1.0
                if margin < 0.0:
                    hs = part_at(end, far, offset, gap, t, q, r, w, law, pair)
                    parts, turned = True, False
                if parts or turned:
                    reaches_goal = False
                    t_new = t + hs
                whole = not (parts or turned or held or reaches_goal)
                if sample < len(sample_times) and sample_times[sample] < t_new:
                    sample = sample_joint(
                        sample, sample_times, samples, t, t_new, q, r, w, offset, gap, law, pair,
                        (work, damped, lost, captured, noise), mode,
                    )  # fmt: skip
                go_by(hs, JOINT, t, q, r, signs[JOINT], methods[JOINT], law)
                if follows_tangent:
                    move_jointly(
                        acc, column, columns, jacobian, hs, t, q, r, share, turned, law, pair
                    )
                work += inertia * r[JOINT, GAIN]
                damped += inertia * r[JOINT, LOSS]
                begin_1, begin_2 = joint_pulls(t, q, gap, pair)
                if watches:
                    end_velocity = 0.0 if turned else r[JOINT, V]
                    split(r[JOINT, X], end_velocity, offset, gap, w)
                    a0 = slowed(q[JOINT, FORCE], q[JOINT, V], signs[JOINT], law.body)
                    a1 = slowed(r[JOINT, FORCE], end_velocity, signs[JOINT], law.body)
                    for i in range(2):
                        notice(acc, column, columns, t, t_new, q, w, a0, a1, i, pair.laws[i], 1.0)
                split(r[JOINT, X], 0.0 if turned else r[JOINT, V], offset, gap, q)
                end_1, end_2 = joint_pulls(t_new, q, gap, pair)
                add_slack(state, 0, begin_1, end_1, t, t_new)
                add_slack(state, 1, begin_2, end_2, t, t_new)
                if follows_ledger:
                    gained = work + noise - damped - lost - captured
                    follow_ledger(state, energy_of(q, bodies, g), gained)
                if whole:
                    n += 1
                else:
                    t_base, n = t_new, 0
                t = t_new
                # Friction may have let go of both together: then they move on as one.
                slips = signs[JOINT] == STUCK and parting(far, t, q, pair) <= 0.0
                if parts and not slips:
                    mode = FLIGHT
                    leaving = far
                    now = (q[0, V], q[1, V])
                    rows = write_pair_contact(*table_of_contacts, rows, t, RELEASE, now, now)
                settle_signs(t, q, pair)
            elif hs > 0.0:
                regular = not reaches_goal
                if regular:
                    for i in range(2):
                        go(i, t, q, r, signs[i], tables[i], pair.laws[i])
                else:
                    both(hs, t, q, r, pair)
                gap, end_gap = q[0, X] - q[1, X], r[0, X] - r[1, X]
                rate, end_rate = q[0, V] - q[1, V], r[0, V] - r[1, V]
                pull, end_pull = q[0, FORCE] - q[1, FORCE], r[0, FORCE] - r[1, FORCE]
                small = 0.0
                if leaving != 0.0 and rate * leaving < 0.0:
                    small, _ = hop(rate, -parting(leaving, t, q, pair), 0.0)
                    slowest = min(abs(q[0, V]), abs(q[1, V]))
                    if small >= goal - t or (rubs and slowest < 100.0 * abs(rate)):
                        small = 0.0
                reach = (abs(rate) + abs(end_rate)) * hs
                near = min(gap, end_gap) - low < reach or high - max(gap, end_gap) < reach
                # From touch without any rate the first dip has no sign that the ends would show.
                level = leaving != 0.0 and rate == 0.0
                if small == 0.0 and ((near and pull * end_pull < 0.0) or level):
                    hs *= _PARTS / 16.0 if level else _PARTS
                    regular, reaches_goal = False, False
                    both(hs, t, q, r, pair)

                # Zeros of a velocity under drag that is not smooth there, and friction's end.
                turning = -1
                if nonlinear and small == 0.0:
                    for i in range(2):
                        if turning < 0 and (signs[i] == STUCK or r[i, V] * signs[i] < 0.0):
                            hs, turning = first_turning(hs, t, q, r, pair)
                    if turning >= 0:
                        regular, reaches_goal = False, False

                end_gap, end_rate = r[0, X] - r[1, X], r[0, V] - r[1, V]
                known = leaving if small > 0.0 else 0.0
                wall, toward = wall_met(known, gap, rate, end_gap, end_rate, hs, low, high)
                beyond = small > 0.0 or (end_gap - wall) * toward >= 0.0
                if toward != 0.0 and not beyond:  # a valley between the ends
                    s = locate_gap(VELOCITY, 0.0, 0.0, hs, t, q, r, pair)
                    both(s, t, q, r, pair)
                    depth = (r[0, X] - r[1, X] - wall) * toward
                    beyond = depth > 0.0
                    if abs(depth) < 1e-9:
                        counters[GRAZES] += 1
                    if beyond:
                        hs = s
                    else:
                        both(hs, t, q, r, pair)
                rests_on, grazes = False, False
                if toward != 0.0 and beyond:
                    far = toward
                    begin = 0.0
                    if leaving == far and small == 0.0:
                        begin = leave_gap(wall, far, hs, t, q, r, pair)
                        grazes = begin == 0.0
                if grazes:  # nothing moves apart that could be seen: do the balls begin to part?
                    both(hs, t, q, r, pair)
                    end_gap, end_rate = r[0, X] - r[1, X], r[0, V] - r[1, V]
                    tiny = _ROUNDING * (abs(r[0, X]) + abs(r[1, X]) + 10.0)
                    rests_on = end_rate * far >= 0.0 or abs(end_gap - wall) > tiny
                if rests_on:  # no: they stay together, for a short time without a question
                    counters[GRAZES] += 1
                    captured += halt(q, bodies)
                    if follows_tangent:
                        unite(acc, column, columns, jacobian, share)
                    mode, leaving = (REST_LOW if far < 0.0 else REST_HIGH), 0.0
                    held_until = min(t + max(_HOLD * hs, SHORTEST_REST * h, SHORTEST * t), goal)
                    if rows > 0 and contact_kinds[rows - 1] == RELEASE:
                        rows -= 1
                    else:
                        now = (q[0, V], q[1, V])
                        rows = write_pair_contact(*table_of_contacts, rows, t, REST, now, now)
                    settle_signs(t, q, pair)
                    t_base, n = t, 0
                    continue
                if toward != 0.0 and beyond and not grazes:
                    regular, reaches_goal, turning = False, False, -1
                    strikes = True
                    if small > 0.0:
                        hs = small
                        both(hs, t, q, r, pair)
                        i1, i2 = bodies[0].inertia, bodies[1].inertia
                        change = (r[0, V] - r[1, V] + rate) / (i1 + i2)
                        r[0, V] -= change * i2
                        r[1, V] += change * i1
                    else:
                        hs = locate_gap(ANGLE, wall, begin, hs, t, q, r, pair)
                        both(hs, t, q, r, pair)
                    shift = 0.5 * (r[0, X] - r[1, X] - wall)
                    r[0, X] -= shift
                    r[1, X] += shift
                if not regular:
                    t_new = goal if reaches_goal else t + hs

                if sample < len(sample_times) and sample_times[sample] < t_new:
                    sample = sample_flight(
                        sample, sample_times, samples, t, t_new, q, w, pair,
                        (work, damped, lost, captured, noise),
                    )  # fmt: skip

                if watches:
                    for i in range(2):
                        a0 = slowed(q[i, FORCE], q[i, V], signs[i], bodies[i])
                        a1 = slowed(r[i, FORCE], r[i, V], signs[i], bodies[i])
                        held = 1.0 if signs[i] == STUCK else 0.0
                        notice(acc, column, columns, t, t_new, q, r, a0, a1, i, pair.laws[i], held)
                if follows_tangent:
                    fly(acc, column, columns, jacobian, hs, t, q, r, pair)
                    for i in range(2):
                        if i == turning:
                            turn_back(acc, column, columns, jacobian, t + hs, r, i, pair)

                for i in range(2):
                    k = bodies[i].coupling
                    end_pull = tension_at(r[i, X], r[i, V], r[i, LIFT], g, k)
                    smaller = min(end_pull, tension_at(q[i, X], q[i, V], q[i, LIFT], g, k))
                    largest = q[i, V] ** 2 + r[i, V] ** 2 + (g + settings.lift_bound) * k
                    if signs[i] == STUCK or smaller < settings.sag * largest:
                        note_slack(
                            state, i, t, t_new, q, r, end_pull, signs[i], methods[i], pair.laws[i]
                        )
                    work += bodies[i].inertia * r[i, GAIN]
                    damped += bodies[i].inertia * r[i, LOSS]
                    for j in range(5):
                        q[i, j] = r[i, j]
                if follows_ledger:
                    gained = work + noise - damped - lost - captured
                    follow_ledger(state, energy_of(q, bodies, g), gained)
                if regular:
                    n += 1
                else:
                    t_base, n = t_new, 0
                t = t_new
                if not strikes:
                    leaving = far if grazes else 0.0
                if turning >= 0:
                    q[turning, V] = 0.0
                    settle_signs(t, q, pair)

            if t >= goal and (at_stretch or at_kick) and not strikes:
                given = False
                for i in range(2):
                    pushed = jumps[stretch + 1] if at_stretch else 0.0
                    thrown = kicks_given[i, kicked] if at_kick else 0.0
                    worked, shaken, is_moved = shove(i, q, pushed, thrown, bodies)
                    work, noise, given = work + worked, noise + shaken, given or is_moved
                if at_stretch:
                    if follows_tangent:
                        jump(acc, column, columns, jacobian, jumps[stretch + 1], q, pair)
                    stretch += 1
                    p = stretches[stretch]
                    pair = Pair(signs, laws_of(g, bodies, p), methods)
                if at_kick:
                    kicked += 1
                gap = q[0, X] - q[1, X]
                rate = q[0, V] - q[1, V]
                touches = mode != FLIGHT or leaving != 0.0
                if given and touches and rate * far > 0.0:
                    strikes = True
                    mode = FLIGHT
                elif given and mode != FLIGHT and rate * far < 0.0:
                    mode, leaving = FLIGHT, far
                    now = (q[0, V], q[1, V])
                    rows = write_pair_contact(*table_of_contacts, rows, t, RELEASE, now, now)
                settle_signs(t, q, pair)
                t_base, n = t, 0

        if t >= stop:
            while sample < len(sample_times) and sample_times[sample] <= stop:
                for i in range(2):
                    samples[2 * i, sample] = q[i, X]
                    samples[2 * i + 1, sample] = q[i, V]
                write_ledger(samples, sample, work, damped, lost, captured, noise, mode)
                sample += 1

        state[T_BASE] = t_base
        state[ANGLE_1], state[VELOCITY_1] = q[0, X], q[0, V]
        state[ANGLE_2], state[VELOCITY_2] = q[1, X], q[1, V]
        state[WORK], state[DAMPED], state[IMPACT] = work, damped, lost
        state[CAPTURED], state[NOISE] = captured, noise
        counters[MODE], counters[STRETCH], counters[SAMPLE] = mode, stretch, sample
        counters[KICKED], counters[STEPS] = kicked, n
        counters[CONTACT] += rows
        counters[TOTAL_STEPS] += done
        return rows

    return trajectory
