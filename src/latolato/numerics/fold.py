"""Folds a drive and a restoring law into the trajectory of one ball, with walls and rest.

The trajectory is a hybrid system with the modes flight, stuck (Coulomb friction holds the ball)
and rest on either wall. Steps end at every event: a wall, a zero of the velocity when the drag is
not smooth there, the end of a drive's smooth stretch, a velocity kick.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from latolato.numerics.bounce import hop, meet_wall
from latolato.numerics.engine.swing import SHORTEST, tension_at
from latolato.numerics.flight import (
    ANGLE,
    SHORTEST_REST,
    Law,
    Method,
    Part,
    Point,
    follow_ledger,
    make_flight,
    prepare,
    write_contact,
    write_ledger,
)
from latolato.numerics.records import (
    ANGLE_1,
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
    SIGN_1,
    SLACK_FIRST,
    SLACK_TOTAL,
    STEPS,
    STRETCH,
    STUCK,
    T_BASE,
    TOTAL_STEPS,
    UNSETTLED,
    VELOCITY_1,
    WORK,
)
from latolato.numerics.rest import make_resting
from latolato.numerics.tangent import clear_matrix, make_tangent, write_matrix
from latolato.numerics.watch import BLIND, Hooks, make_watch
from latolato.observables import Segment
from latolato.physics.contacts import BOTTOM, RELEASE, REST, TOP, wall_saltation
from latolato.physics.damping import drag
from latolato.physics.pendulum import SLOPES

# A step is cut here when the acceleration changes sign beside a wall, so that a dip in between
# is seen by one of its parts.
_PARTS = 0.25


def make_trajectory(
    acceleration: Callable[..., float],
    restoring: Callable[..., float],
    potential: Callable[..., float],
    compile_part: Part | None = None,
    hooks: tuple[Hooks, ...] = BLIND,
) -> Callable[..., int]:
    """Return the function that carries one ball's state on; see `latolato.simulate`.

    `hooks` are the formulas of observables, from `latolato.numerics.watch.hooks_of`.

    The returned function updates `state` and `counters` in place, writes samples and contacts,
    and returns the number of contact rows written. It stops at `stop`, after `most_steps` steps
    or when the contact table is full, and can be called again to go on.
    """
    force, advance, step_by, locate, leave, turn, follow_slack = make_flight(
        acceleration, restoring, compile_part
    )
    find_release, held_slack = make_resting(acceleration, restoring, compile_part)
    watch = make_watch(hooks, compile_part)
    watch_step, watches = watch.step, bool(hooks[0])
    watch_tangent, follows_tangent = watch.tangent, bool(hooks[4])
    tangent, slope = make_tangent(acceleration, restoring, compile_part), SLOPES[restoring]

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
        body = bodies[0]
        gravity, h = settings.gravity, settings.step
        low, high = settings.low, settings.high
        inertia = body.inertia
        nonlinear = body.quadratic > 0.0 or body.coulomb > 0.0
        follows_tension = settings.follows_tension != 0
        follows_ledger = settings.follows_ledger != 0
        stiffness = gravity * body.coupling
        pull, sag = math.inf, settings.sag
        strongest = (gravity + settings.lift_bound) * body.coupling
        full, jacobian = tables[0], space[MATRIX]
        prepare(Method(full, kicks, drifts, nodes), h, body.rate)
        method = Method(tables[1], kicks, drifts, nodes)

        t_base, angle, velocity = state[T_BASE], state[ANGLE_1], state[VELOCITY_1]
        work, damped, lost = state[WORK], state[DAMPED], state[IMPACT]
        captured, noise = state[CAPTURED], state[NOISE]
        mode, stretch, sample = counters[MODE], counters[STRETCH], counters[SAMPLE]
        kicked, n, sign = counters[KICKED], counters[STEPS], float(counters[SIGN_1])
        table_of_contacts = (contact_times, contact_kinds, contact_values)
        rows, room = 0, len(contact_times) - 4
        t = t_base + n * h
        law = Law(gravity, body, stretches[stretch])
        a, driven, lift = force(t, angle, sign, law)
        done = 0

        if mode == UNSETTLED:
            # Whether the ball rests, sticks, strikes or flies at time zero.
            mode = FLIGHT
            energy = inertia * (0.5 * velocity * velocity + stiffness * potential(angle))
            state[FIRST_ENERGY] = state[LARGEST_ENERGY] = energy
            pull = body.coupling * restoring(angle)
            free = -(gravity + lift) * pull
            side = -1.0 if angle <= low else (1.0 if angle >= high else 0.0)
            if side != 0.0 and velocity * side >= 0.0:
                before = velocity
                velocity, impact, caught, rests = meet_wall(
                    velocity, -free * side, settings.restitution, settings.rest_speed,
                    body.coulomb,
                )  # fmt: skip
                lost, captured = inertia * impact, inertia * caught
                if rests:
                    mode = REST_LOW if side < 0.0 else REST_HIGH
                if before != 0.0:
                    kind = REST if rests and impact == 0.0 else (BOTTOM if side < 0.0 else TOP)
                    rows = write_contact(*table_of_contacts, rows, t, kind, before, velocity)
                sign = -side
            elif velocity == 0.0 and abs(free) <= body.coulomb and body.coulomb > 0.0:
                mode = STUCK
            elif velocity == 0.0:
                sign = math.copysign(1.0, free)
            a, driven, lift = force(t, angle, sign, law)
        pull = tension_at(angle, velocity, lift, gravity, body.coupling)

        while t < stop and done < most_steps and rows < room:
            done += 1
            goal, at_stretch, at_kick = stop, False, False
            if stretch + 1 < len(starts) and starts[stretch + 1] <= goal:
                goal, at_stretch = starts[stretch + 1], True
            if kicked < len(kick_times) and kick_times[kicked] <= goal:
                at_stretch = at_stretch and kick_times[kicked] == goal
                goal, at_kick = kick_times[kicked], True

            if mode != FLIGHT:
                release = find_release(mode, t, goal, angle, settings, body, law.p)
                until = min(release, goal)
                while sample < len(sample_times) and sample_times[sample] < until:
                    samples[0, sample], samples[1, sample] = angle, 0.0
                    write_ledger(samples, sample, work, damped, lost, captured, noise, mode)
                    sample += 1
                if follows_tension:
                    state[SLACK_FIRST], state[SLACK_TOTAL] = held_slack(
                        state[SLACK_FIRST], state[SLACK_TOTAL], t, until, angle, settings, law
                    )
                if watches:
                    e = stiffness * potential(angle)
                    held = Segment(t, until, angle, angle, 0.0, 0.0, 0.0, 0.0, e, e, 0.0, 0.0, 1.0)
                    watch_step(acc, column, columns, held)
                if follows_tangent:  # the place is the wall's, or stays; the velocity is zero
                    kept = 1.0 if mode == STUCK else 0.0
                    write_matrix(jacobian, 0, (kept, 0.0, 0.0, 0.0))
                    watch_tangent(acc, column, columns, 2, until - t, -math.inf, jacobian)
                t_base, n, t = until, 0, until
                if release <= goal:
                    if mode == STUCK:
                        free = -(gravity + acceleration(t, law.p)) * restoring(angle)
                        sign = math.copysign(1.0, free)
                    else:
                        sign = 1.0 if mode == REST_LOW else -1.0
                        rows = write_contact(*table_of_contacts, rows, t, RELEASE, 0.0, 0.0)
                    mode = FLIGHT
                    a, driven, lift = force(t, angle, sign, law)
                    pull = tension_at(angle, velocity, lift, gravity, body.coupling)
            elif goal > t:
                point = Point(t, angle, velocity, a, driven, lift)
                hs, whole = h, True
                reaches_goal = t_base + (n + 1) * h >= goal - 1e-9 * h
                side = -1.0 if angle <= low else (1.0 if angle >= high else 0.0)
                small, back = 0.0, 0.0
                if velocity * side < 0.0 < a * side:
                    small, back = hop(velocity, abs(a), body.coulomb)
                if small >= goal - t:
                    small = 0.0
                if reaches_goal:
                    hs, whole = goal - t, False
                    x, v, dw, dd, a1, driven1, lift1 = step_by(hs, point, sign, method, law)
                else:
                    x, v, dw, dd, a1, driven1, lift1 = advance(point, sign, full, law)

                # A step beside a wall within which the force changes sign is taken in parts.
                reach = (abs(velocity) + abs(v)) * hs
                if (
                    small == 0.0
                    and a * a1 < 0.0
                    and (min(angle, x) - low < reach or high - max(angle, x) < reach)
                ):
                    hs, whole, reaches_goal = hs * _PARTS, False, False
                    x, v, dw, dd, a1, driven1, lift1 = step_by(hs, point, sign, method, law)

                turned = nonlinear and v * sign < 0.0 and small == 0.0
                if turned:
                    hs, whole, reaches_goal = turn(hs, point, sign, method, law), False, False
                    hs = max(hs, SHORTEST * t)
                    x, v, dw, dd, a1, driven1, lift1 = step_by(hs, point, sign, method, law)

                wall, far = 0.0, 0.0
                if small > 0.0:
                    wall, far = angle, side
                elif x <= low:
                    wall, far = low, -1.0
                elif x >= high:
                    wall, far = high, 1.0
                elif velocity < 0.0 < v and min(angle, x) - max(-velocity, v) * hs <= low:
                    wall, far = low, -1.0
                elif v < 0.0 < velocity and max(angle, x) + max(velocity, -v) * hs >= high:
                    wall, far = high, 1.0
                hit = far != 0.0 and (small > 0.0 or (x - wall) * far >= 0.0)
                if far != 0.0 and not hit:  # a valley between the ends: look at its bottom
                    s = turn(hs, point, sign, method, law)
                    xs, vs, _, _, _, _, _ = step_by(s, point, sign, method, law)
                    if abs(xs - wall) < 1e-9:
                        counters[GRAZES] += 1
                    if (xs - wall) * far > 0.0:
                        hs, x, v, hit = s, xs, vs, True
                if hit:
                    whole, reaches_goal, turned = False, False, False
                    begin, seen = 0.0, True
                    if small == 0.0 and side == far:
                        begin = leave(ANGLE, wall, far, hs, point, sign, method, law)
                        seen = begin > 0.0
                    if small > 0.0:
                        hs, v, dw, dd = small, far * back, 0.0, 0.5 * (velocity**2 - back**2)
                        a1, driven1, lift1 = force(t + hs, wall, sign, law)
                    elif seen:
                        guess = hs - (x - wall) / v if v != 0.0 else 0.5 * hs
                        hs = locate(ANGLE, wall, begin, hs, guess, point, sign, method, law)
                        x, v, dw, dd, a1, driven1, lift1 = step_by(hs, point, sign, method, law)
                        v = far * abs(v)  # rounding may turn a grazing velocity round
                    else:  # nothing moves that could be seen: go on resting
                        counters[GRAZES] += 1
                        hs = min(hs, max(hs * _PARTS / 16.0, SHORTEST_REST * h))
                        v, dw, dd, hit = 0.0, 0.0, 0.0, False
                        captured += 0.5 * inertia * velocity * velocity
                        mode = REST_LOW if far < 0.0 else REST_HIGH
                        if rows > 0 and contact_kinds[rows - 1] == RELEASE:
                            rows -= 1
                        else:
                            rows = write_contact(*table_of_contacts, rows, t, REST, 0.0, 0.0)
                        a1, driven1, lift1 = force(t + hs, wall, sign, law)
                    x = wall

                t_new = goal if reaches_goal else t + hs
                if whole:
                    t_new = t_base + (n + 1) * h
                while sample < len(sample_times) and sample_times[sample] < t_new:
                    s = sample_times[sample] - t
                    xs, vs, dws, dds, _, _, _ = step_by(s, point, sign, method, law)
                    if hit and (xs - wall) * far > 0.0:
                        xs = wall  # by a rounding
                    samples[0, sample], samples[1, sample] = xs, vs
                    write_ledger(
                        samples, sample, work + inertia * dws, damped + inertia * dds, lost,
                        captured, noise, FLIGHT,
                    )  # fmt: skip
                    sample += 1

                if follows_tension:
                    end_pull = tension_at(x, v, lift1, gravity, body.coupling)
                    margin = sag * (velocity * velocity + v * v + strongest)
                    if max(pull, end_pull) < -margin:
                        state[SLACK_TOTAL] += t_new - t
                        if math.isnan(state[SLACK_FIRST]):
                            state[SLACK_FIRST] = t
                    elif min(pull, end_pull) < margin:
                        state[SLACK_FIRST], state[SLACK_TOTAL] = follow_slack(
                            state[SLACK_FIRST], state[SLACK_TOTAL], t_new - t, end_pull, point,
                            sign, method, law,
                        )  # fmt: skip
                    pull = end_pull

                if watches:
                    slowing = drag(velocity, sign, body.rate, body.quadratic, 0.0)
                    slowing1 = drag(v, sign, body.rate, body.quadratic, 0.0)
                    segment = Segment(
                        t, t_new, angle, x, velocity, v, a - slowing, a1 - slowing1,
                        0.5 * velocity * velocity + stiffness * potential(angle),
                        0.5 * v * v + stiffness * potential(x),
                        velocity * (driven - slowing - body.coulomb * sign),
                        v * (driven1 - slowing1 - body.coulomb * sign), 0.0,
                    )  # fmt: skip
                    watch_step(acc, column, columns, segment)
                if follows_tangent:
                    spread = -body.rate * hs - 2.0 * body.quadratic * abs(x - angle)
                    if mode != FLIGHT:
                        clear_matrix(jacobian, 2)
                        spread = -math.inf
                    elif whole:
                        write_matrix(jacobian, 0, tangent(point, sign, full, law))
                    else:
                        prepare(method, hs, body.rate)
                        write_matrix(jacobian, 0, tangent(point, sign, method.table, law))
                    watch_tangent(acc, column, columns, 2, hs, spread, jacobian)
                angle, velocity, a, driven, lift = x, v, a1, driven1, lift1
                work += inertia * dw
                damped += inertia * dd
                if follows_ledger:
                    energy = inertia * (0.5 * velocity * velocity + stiffness * potential(angle))
                    follow_ledger(state, energy, work + noise - damped - lost - captured)
                if whole:
                    n += 1
                else:
                    t_base, n = t_new, 0
                t = t_new

                if turned:
                    velocity = 0.0
                    free = -(gravity + lift) * body.coupling * restoring(angle)
                    if abs(free) <= body.coulomb:
                        mode = STUCK
                    else:
                        sign = -sign if free == 0.0 else math.copysign(1.0, free)
                        a, driven, lift = force(t, angle, sign, law)
                    if follows_tangent:
                        ratio = 0.0 if mode == STUCK else a / a1
                        write_matrix(jacobian, 0, (1.0, 0.0, 0.0, ratio))
                        spread = math.log(ratio) if ratio > 0.0 else -math.inf
                        watch_tangent(acc, column, columns, 2, 0.0, spread, jacobian)
                if hit:
                    free = (gravity + lift) * body.coupling * restoring(angle) * far
                    velocity, impact, caught, rests = meet_wall(
                        velocity, free, settings.restitution, settings.rest_speed, body.coulomb
                    )
                    captures = rests and impact == 0.0
                    kind = REST if captures else (BOTTOM if far < 0.0 else TOP)
                    rows = write_contact(*table_of_contacts, rows, t, kind, v, velocity)
                    if rests:
                        mode = REST_LOW if far < 0.0 else REST_HIGH
                        if not captures:
                            rows = write_contact(*table_of_contacts, rows, t, REST, 0.0, 0.0)
                    lost += inertia * impact
                    captured += inertia * caught
                    before = a1 - drag(v, sign, body.rate, body.quadratic, 0.0)
                    sign = -far
                    a, driven, lift = force(t, angle, sign, law)
                    pull = tension_at(angle, velocity, lift, gravity, body.coupling)
                    if follows_tangent:
                        clear_matrix(jacobian, 2)
                        spread = -math.inf
                        if not rests and v != 0.0:
                            after = a - drag(velocity, sign, body.rate, body.quadratic, 0.0)
                            write_matrix(jacobian, 0, wall_saltation(v, velocity, before, after))
                            e = settings.restitution
                            spread = 2.0 * math.log(e) if e > 0.0 else -math.inf
                        watch_tangent(acc, column, columns, 2, 0.0, spread, jacobian)

            if t >= goal and (at_stretch or at_kick):
                given = 0.0
                if at_stretch:
                    stretch += 1
                    law = Law(gravity, body, stretches[stretch])
                    given = -jumps[stretch] * body.coupling * restoring(angle)
                    work += inertia * given * (velocity + 0.5 * given)
                    velocity += given
                if at_kick:
                    more = kicks_given[0, kicked]
                    kicked += 1
                    noise += inertia * more * (velocity + 0.5 * more)
                    velocity += more
                    given += more
                if follows_tangent and at_stretch:
                    bend = -jumps[stretch] * body.coupling * slope(angle)
                    write_matrix(jacobian, 0, (1.0, 0.0, bend, 1.0))
                    watch_tangent(acc, column, columns, 2, 0.0, 0.0, jacobian)
                a, driven, lift = force(t, angle, sign, law)
                if given != 0.0:
                    side = 0.0
                    if angle <= low and velocity < 0.0:
                        side = -1.0
                    elif angle >= high and velocity > 0.0:
                        side = 1.0
                    if side != 0.0:
                        before = velocity
                        a0 = a - drag(velocity, sign, body.rate, body.quadratic, 0.0)
                        free = (gravity + lift) * body.coupling * restoring(angle) * side
                        velocity, impact, caught, rests = meet_wall(
                            velocity, free, settings.restitution, settings.rest_speed,
                            body.coulomb,
                        )  # fmt: skip
                        lost += inertia * impact
                        captured += inertia * caught
                        if velocity != 0.0 or mode == FLIGHT:
                            kind = REST if rests else (BOTTOM if side < 0.0 else TOP)
                            rows = write_contact(
                                *table_of_contacts, rows, t, kind, before, velocity
                            )
                        mode = FLIGHT
                        if rests:
                            mode = REST_LOW if side < 0.0 else REST_HIGH
                    elif mode in (REST_LOW, REST_HIGH):
                        rows = write_contact(*table_of_contacts, rows, t, RELEASE, 0.0, velocity)
                        mode = FLIGHT
                    else:
                        mode = FLIGHT
                    if velocity != 0.0:
                        sign = math.copysign(1.0, velocity)
                    a, driven, lift = force(t, angle, sign, law)
                    if follows_tangent and side != 0.0:
                        clear_matrix(jacobian, 2)
                        spread = -math.inf
                        if velocity != 0.0:
                            after = a - drag(velocity, sign, body.rate, body.quadratic, 0.0)
                            matrix = wall_saltation(before, velocity, a0, after)
                            write_matrix(jacobian, 0, matrix)
                            spread = 2.0 * math.log(settings.restitution)
                        watch_tangent(acc, column, columns, 2, 0.0, spread, jacobian)
                pull = tension_at(angle, velocity, lift, gravity, body.coupling)
                t_base, n = t, 0

        if t >= stop:
            while sample < len(sample_times) and sample_times[sample] <= stop:
                samples[0, sample], samples[1, sample] = angle, velocity
                write_ledger(samples, sample, work, damped, lost, captured, noise, mode)
                sample += 1

        state[T_BASE], state[ANGLE_1], state[VELOCITY_1] = t_base, angle, velocity
        state[WORK], state[DAMPED], state[IMPACT] = work, damped, lost
        state[CAPTURED], state[NOISE] = captured, noise
        counters[MODE], counters[STRETCH], counters[SAMPLE] = mode, stretch, sample
        counters[KICKED], counters[STEPS], counters[SIGN_1] = kicked, n, int(sign)
        counters[CONTACT] += rows
        counters[TOTAL_STEPS] += done
        return rows

    return trajectory
