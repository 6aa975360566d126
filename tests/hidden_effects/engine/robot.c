/* The robot: reference line to position. */
#include "plant.h"

double reference_at(const struct loop *l, double t)
{
    if (l->count == 0) {
        return l->passed_m;
    }
    const struct knot *k = &l->knots[l->first];
    if (t <= k->begin_s) {
        return l->passed_m;
    }
    const double share = (t - k->begin_s) / (k->end_s - k->begin_s);
    return l->passed_m + (k->position_m - l->passed_m) * (share < 1.0 ? share : 1.0);
}

/* Velocity limit: 0 follows, +-1 slews. Integral action that was not told of the limit goes on summing the error. */
static void limit_velocity(const struct truth *p, struct memory *m, int *mode, double before_m, double u, double h)
{
    const double error_before_m = before_m - m->limited_m;
    double wound = 0.0;
    if (p->robot_windup_per_s > 0.0) {
        m->windup_m_s += h * (error_before_m - m->windup_m_s / p->robot_windup_leak_s);
        wound = p->robot_windup_per_s * m->windup_m_s;
    }
    const double wish_m = u + wound - m->limited_m, reach_m = p->robot_velocity_limit_m_per_s * h;
    *mode = wish_m > reach_m ? 1 : wish_m < -reach_m ? -1 : 0;
    m->limited_m += clamp(wish_m, -reach_m, reach_m);
}

/* Acceleration limit, on the setpoints that the lines run between: what the reference does, and on top what can be
 * braked away until the gap is closed. A drive that limits its velocity too plans its way with both, as profile
 * generators do. Integral action that was not told of the limit shifts the goal. */
double limit_acceleration(const struct truth *p, struct memory *m, double goal_m)
{
    const double h = p->period_s, change = p->robot_acceleration_limit_m_per_s2 * h;
    const double behind_m = m->goal_m - m->profiled_m;
    double wish = (goal_m - m->profiled_m) / h; /* there at the end of the period */
    if (fabs(behind_m) > change * h) {
        const double gap_m = behind_m + p->robot_windup_per_s * m->profiled_windup_m_s;
        const double closing = sqrt(2.0 * change / h * fabs(gap_m) + 0.25 * change * change) - 0.5 * change;
        wish = (goal_m - m->goal_m) / h + (gap_m < 0.0 ? -closing : closing);
    }
    m->profiled_windup_m_s += h * (behind_m - m->profiled_windup_m_s / p->robot_windup_leak_s);
    wish = clamp(wish, -p->robot_velocity_limit_m_per_s, p->robot_velocity_limit_m_per_s);
    m->profiled_m_per_s = clamp(wish, m->profiled_m_per_s - change, m->profiled_m_per_s + change);
    m->profiled_m += m->profiled_m_per_s * h;
    m->goal_m = goal_m;
    return m->profiled_m;
}

/* First-order lag, exact for an input on a straight line. */
static double lag(double y, double from, double to, double tau, double h)
{
    const double slope = (to - from) / h, decay = exp(-h / tau);
    return to - slope * tau + (y - from + slope * tau) * decay;
}

static void resonate(const struct truth *p, struct memory *m, double from, double to, double h)
{
    const double w = p->robot_resonance_rad_per_s, z = p->robot_resonance_damping;
    double r = m->resonant_m, v = m->resonant_m_per_s, k[4][2];
    for (int i = 0; i < 4; i++) {
        const double c = i == 0 ? 0.0 : i == 3 ? 1.0 : 0.5;
        const double ri = r + (i ? c * h * k[i - 1][0] : 0.0), vi = v + (i ? c * h * k[i - 1][1] : 0.0);
        k[i][0] = vi;
        k[i][1] = w * w * (from + c * (to - from) - ri) - 2.0 * z * w * vi;
    }
    m->resonant_m = r + h / 6.0 * (k[0][0] + 2.0 * k[1][0] + 2.0 * k[2][0] + k[3][0]);
    m->resonant_m_per_s = v + h / 6.0 * (k[0][1] + 2.0 * k[1][1] + 2.0 * k[2][1] + k[3][1]);
}

double with_periodic_error(const struct truth *p, double r)
{
    return r + p->robot_periodic_m * sin(2.0 * M_PI * r / p->robot_pitch_m + p->robot_periodic_rad);
}

void move_robot(const struct loop *l, struct memory *m, struct modes *modes, double h)
{
    const struct truth *p = l->p;
    const double t = l->t + h, before_m = m->reference_m;
    double u = reference_at(l, t);
    u *= p->robot_gain * (1.0 + p->robot_gain_drift_per_s * since_start(t));
    u -= p->robot_curvature_per_m2 * u * u * u;
    m->reference_m = u;
    double from = before_m;
    if (p->robot_velocity_limit_m_per_s < 1e8 && p->robot_acceleration_limit_m_per_s2 >= 1e8) {
        from = m->limited_m;
        limit_velocity(p, m, &modes->limiter, before_m, u, h);
        u = m->limited_m;
    }
    const double tau = p->robot_lag_s + p->robot_lag_drift * since_start(t);
    if (tau > 0.0) {
        const double lagged_from = m->lagged_m;
        m->lagged_m = lag(m->lagged_m, from, u, tau, h);
        from = lagged_from;
        u = m->lagged_m;
    }
    if (p->robot_resonance_rad_per_s > 0.0) {
        const double resonant_from = m->resonant_m;
        resonate(p, m, from, u, h);
        from = resonant_from;
        u = m->resonant_m;
    }
    if (p->robot_hysteresis_m != 0.0) {
        const int direction = u > from ? 1 : u < from ? -1 : 0;
        m->hysteresis = dahl(m->hysteresis, u - from, p->robot_hysteresis_length_m, direction);
        u -= p->robot_hysteresis_m * m->hysteresis;
    }
    if (p->robot_backlash_m > 0.0) {
        const double half = 0.5 * p->robot_backlash_m;
        const double play = clamp(m->play_m, u - half, u + half);
        modes->play = play > m->play_m ? 1 : play < m->play_m ? -1 : 0;
        m->play_m = u = play;
    }
    m->robot_m = with_periodic_error(p, u);
}
