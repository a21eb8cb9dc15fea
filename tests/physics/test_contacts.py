"""Contact of the balls: where they touch, what an impact keeps, what it costs, what is refused."""

import math

import mpmath as mp
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

import latolato as ll
from latolato.core.errors import InputError
from latolato.numerics.wall_contact import hop, wall_contact
from latolato.physics.contacts import contact_separation, pair_impact, wall_impact

speeds = st.floats(-30.0, 30.0)
inertias = st.floats(1e-3, 10.0)
restitutions = st.floats(0.0, 1.0)


def energy(w1, w2, i1, i2):
    return 0.5 * i1 * w1 * w1 + 0.5 * i2 * w2 * w2


@given(w1=speeds, w2=speeds, i1=inertias, i2=inertias, e=restitutions)
def test_impact_keeps_angular_momentum_for_every_restitution(w1, w2, i1, i2, e):
    v1, v2 = pair_impact(w1, w2, i1, i2, e)
    size = i1 * abs(w1) + i2 * abs(w2) + 1e-300
    assert abs(i1 * v1 + i2 * v2 - i1 * w1 - i2 * w2) <= 1e-14 * size


@given(w1=speeds, w2=speeds, i1=inertias, i2=inertias, e=restitutions)
def test_impact_returns_restitution_times_the_approach(w1, w2, i1, i2, e):
    v1, v2 = pair_impact(w1, w2, i1, i2, e)
    assert v1 - v2 == pytest.approx(-e * (w1 - w2), abs=1e-13 * (abs(w1) + abs(w2) + 1e-300))


@given(w1=speeds, w2=speeds, i1=inertias, i2=inertias, e=restitutions)
def test_impact_loses_what_the_formula_says(w1, w2, i1, i2, e):
    v1, v2 = pair_impact(w1, w2, i1, i2, e)
    loss = energy(w1, w2, i1, i2) - energy(v1, v2, i1, i2)
    formula = 0.5 * (1.0 - e * e) * i1 * i2 / (i1 + i2) * (w1 - w2) ** 2
    assert loss == pytest.approx(formula, abs=1e-13 * (energy(w1, w2, i1, i2) + 1e-300))


@given(w1=speeds, w2=speeds, i=inertias)
def test_equal_balls_exchange_velocities_in_an_elastic_impact(w1, w2, i):
    size = abs(w1) + abs(w2)
    assert pair_impact(w1, w2, i, i, 1.0) == pytest.approx((w2, w1), abs=1e-14 * size + 1e-300)


@given(w=speeds, i=inertias, e=restitutions)
def test_mirrored_balls_meet_a_wall(w, i, e):
    v1, v2 = pair_impact(w, -w, i, i, e)
    assert v1 == pytest.approx(wall_impact(w, e), abs=1e-14 * abs(w) + 1e-300)
    assert v2 == -v1


@given(w1=speeds, w2=speeds, i=inertias, e=restitutions)
def test_heavy_ball_is_a_wall_to_a_light_one(w1, w2, i, e):
    v1, v2 = pair_impact(w1, w2, i, 1e12 * i, e)
    size = abs(w1) + abs(w2) + 1e-300
    assert v2 == pytest.approx(w2, abs=1e-11 * size)
    assert v1 == pytest.approx(w2 - e * (w1 - w2), abs=1e-11 * size)


@given(length=st.floats(0.05, 3.0), share=st.just(0.0) | st.floats(1e-9, 0.999))
def test_equal_balls_touch_at_twice_the_contact_angle(length, share):
    radius = share * length
    ball = ll.Ball(length=length, mass=0.3, radius=radius)
    toy = ll.LatoLato(length=length, mass=0.3, radius=radius)
    separation = contact_separation(ball, ball)
    assert separation == pytest.approx(2.0 * math.asin(radius / length), rel=1e-13)
    assert separation == pytest.approx(2.0 * toy.contact_angle_low, rel=1e-13)
    assert toy.contact_angle_low + toy.contact_angle_high == pytest.approx(math.pi, rel=1e-15)


def distance_to_rod(ball, rod, cosine):
    """Return how far a ball's centre is from a rod of a given length, the angle between known."""
    foot = min(max(ball.length * cosine, 0.0), rod)
    return math.sqrt(max(ball.length**2 + foot**2 - 2.0 * ball.length * foot * cosine, 0.0))


@given(
    l1=st.floats(0.2, 2.0),
    l2=st.floats(0.2, 2.0),
    r1=st.just(0.0) | st.floats(0.001, 0.5),
    r2=st.floats(0.001, 0.5),
)
def test_balls_touch_where_their_distance_is_the_sum_of_the_radii(l1, l2, r1, r2):
    assume(r1 < l1 and r2 < l2)
    right, left = ll.Ball(length=l1, mass=1, radius=r1), ll.Ball(length=l2, mass=1, radius=r2)
    try:
        separation = contact_separation(right, left)
    except ValueError as error:
        cosine = (l1**2 + l2**2 - (r1 + r2) ** 2) / (2.0 * l1 * l2)
        never = abs(l1 - l2) >= r1 + r2
        too_large = cosine <= -1.0 + 1e-15
        hidden = any(
            distance_to_rod(ball, other.length, cosine) < ball.radius * (1.0 + 1e-9)
            for ball, other in ((right, left), (left, right))
        )
        assert never or too_large or hidden, error  # noqa: PT017 - which refusal, if any
        return
    assert separation == contact_separation(left, right)
    with mp.workdps(30):
        a, b, s = mp.mpf(l1), mp.mpf(l2), mp.mpf(separation)
        distance = mp.sqrt(a * a + b * b - 2 * a * b * mp.cos(s))
        assert float(distance / (mp.mpf(r1) + mp.mpf(r2)) - 1) == pytest.approx(0.0, abs=1e-10)
    # Neither rod is inside the other's ball when the balls meet.
    for ball, other in ((right, left), (left, right)):
        far = distance_to_rod(ball, other.length, math.cos(separation))
        assert far >= ball.radius * (1.0 - 1e-9) - 1e-9


def test_swapping_unequal_balls_of_equal_length_changes_nothing():
    # asin(0.5) = 0.5236 exceeds Theta = 0.5215: the small ball's rod would hit the large ball.
    small, large = (ll.Ball(length=1.0, mass=1.0, radius=r) for r in (0.015625, 0.5))
    for right, left in ((small, large), (large, small)):
        with pytest.raises(ValueError, match="rod or string would hit"):
            contact_separation(right, left)


def test_nearly_touching_geometry_keeps_its_digits():
    # arccos would lose half of them: lengths differ by the sum of the radii less 1e-9.
    right = ll.Ball(length=1.0, mass=1, radius=0.05)
    left = ll.Ball(length=0.9 + 1e-9, mass=1, radius=1e-12)
    with pytest.raises(ValueError, match="never meet"):
        contact_separation(right, left)
    left = ll.Ball(length=1.0 - 1e-5, mass=1, radius=1e-12)
    right = ll.Ball(length=1.0, mass=1, radius=1.0000001e-5)
    with mp.workdps(40):
        a, b = mp.mpf(right.length), mp.mpf(left.length)
        reach = mp.mpf(right.radius) + mp.mpf(left.radius)
        exact = mp.acos((a * a + b * b - reach**2) / (2 * a * b))
    assert contact_separation(right, left) == pytest.approx(float(exact), rel=1e-9)


class TestRefusals:
    def pair(self, l1, l2, r1, r2):
        return ll.BallPair(
            right=ll.Ball(length=l1, mass=1.0, radius=r1),
            left=ll.Ball(length=l2, mass=1.0, radius=r2),
        )

    def test_balls_that_never_meet(self):
        with pytest.raises(ValueError, match=r"never meet.*1 and 0\.7.*0\.1 and 0\.1"):
            self.pair(1.0, 0.7, 0.1, 0.1)

    def test_balls_that_just_never_meet(self):
        # The second ones differ by 0.2 but for rounding.
        for lengths in ((1.0, 0.75, 0.125, 0.125), (1.0, 1.2, 0.1, 0.1)):
            with pytest.raises(ValueError, match="never meet"):
                self.pair(*lengths)

    def test_rod_that_hits_the_shorter_ball_first(self):
        # asin(0.3/0.7) = 0.443 > Theta = acos((1 + 0.49 - 0.16^... )/1.4) of these balls.
        with pytest.raises(ValueError, match="right rod or string would hit the left ball"):
            self.pair(1.0, 0.7, 0.01, 0.3)

    def test_shorter_rod_that_hits_the_longer_ball_first(self):
        # asin(0.5/1.05) = 0.4963 > Theta = 0.4903: the rod of length 1 reaches beyond the tangent
        # point at sqrt(1.05^2 - 0.5^2) = 0.923. One that ends before it is fine.
        for one, hit, lengths in (
            ("right", "left", (1.0, 1.05, 0.0, 0.5)),
            ("left", "right", (1.05, 1.0, 0.5, 0.0)),
        ):
            with pytest.raises(ValueError, match=f"{one} rod or string would hit the {hit} ball"):
                self.pair(*lengths)
        assert self.pair(0.9, 1.05, 0.0, 0.5).contact_separation > 0.0

    def test_swapping_the_balls_changes_nothing(self):
        with pytest.raises(ValueError, match="left rod or string would hit the right ball"):
            self.pair(0.7, 1.0, 0.3, 0.01)

    def test_equal_balls_of_any_radius_below_the_length_are_fine(self):
        for radius in (0.0, 0.5, 0.99):
            assert self.pair(1.0, 1.0, radius, radius).contact_separation == pytest.approx(
                2.0 * math.asin(radius), rel=1e-12
            )

    @pytest.mark.parametrize("radius", [-0.1, 0.4, 0.5, math.nan, math.inf])
    def test_radius_outside_its_range(self, radius):
        with pytest.raises(ValueError, match="radius must"):
            ll.LatoLato(length=0.4, mass=1.0, radius=radius)
        with pytest.raises(ValueError, match="radius must"):
            ll.Ball(length=0.4, mass=1.0, radius=radius)

    def test_message_names_value_rule_and_length(self):
        with pytest.raises(
            ValueError, match=r"radius must lie in \[0, length\), got 0.5; give less than 0.4"
        ):
            ll.LatoLato(length=0.4, mass=1.0, radius=0.5)

    def test_ball_that_is_no_ball(self):
        with pytest.raises(InputError, match="left must be a Ball, got 3"):
            ll.BallPair(right=ll.Ball(length=1.0, mass=1.0), left=3)


class TestMeetWall:
    def test_slow_impact_is_captured_and_its_energy_booked(self):
        after, loss, captured, rests = wall_contact(-1e-7, -1.0, 0.9, 1e-6, 0.0)
        assert (after, loss, rests) == (0.0, 0.0, True)
        assert captured == pytest.approx(0.5e-14)

    def test_slow_elastic_impact_bounces(self):
        after, loss, captured, rests = wall_contact(-1e-7, -1.0, 1.0, 1e-6, 0.0)
        assert (after, loss, captured, rests) == (1e-7, 0.0, 0.0, False)

    def test_zero_speed_rests_even_when_elastic(self):
        assert wall_contact(0.0, -1.0, 1.0, 1e-6, 0.0) == (0.0, 0.0, 0.0, True)

    def test_nothing_rests_on_a_wall_that_it_accelerates_away_from(self):
        assert wall_contact(-1e-7, 1.0, 0.9, 1e-6, 0.0)[3] is False
        assert wall_contact(0.0, 1.0, 0.9, 1e-6, 0.0)[3] is False

    def test_plastic_impact_rests_and_books_an_impact_loss(self):
        after, loss, captured, rests = wall_contact(-2.0, -1.0, 0.0, 1e-6, 0.0)
        assert abs(after) == 0.0
        assert (loss, captured, rests) == (2.0, 0.0, True)

    def test_friction_holds_what_pulls_weakly(self):
        assert wall_contact(0.0, 0.5, 1.0, 1e-6, 0.6)[3] is True

    @given(v=speeds, outward=speeds, e=restitutions, rest=st.floats(0.0, 1e-3))
    def test_losses_are_the_missing_energy(self, v, outward, e, rest):
        after, loss, captured, rests = wall_contact(v, outward, e, rest, 0.0)
        assert loss >= 0.0
        assert captured >= 0.0
        assert loss + captured + 0.5 * after**2 == pytest.approx(0.5 * v * v, rel=1e-14)
        assert not rests or after == 0.0


class TestHop:
    def test_up_and_down_are_two_parabolas(self):
        # 1e-9 rad/s against 2 rad/s^2 is 0.5 ns and 2.5e-19 rad; down with 0.5 rad/s^2 it is half
        # as fast and takes 1 ns.
        assert hop(1e-9, 2.0, 0.75) == pytest.approx((1.5e-9, 0.5e-9), rel=1e-15)

    def test_a_ball_that_friction_holds_at_the_top_does_not_come_back(self):
        assert hop(1e-9, 1.0, 0.8) == (0.0, 0.0)

    def test_a_hop_of_which_the_angle_has_digits_is_flown(self):
        assert hop(1e-3, 1.0, 0.0) == (0.0, 0.0)

    def test_nothing_comes_back_without_a_pull(self):
        assert hop(1e-9, -1.0, 0.0) == (0.0, 0.0)
