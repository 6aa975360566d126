/* The benchmark's integrator: the classical Runge-Kutta method with a fixed step. */
#ifndef SIM_HAL_RTHS_RUNGE_KUTTA_H
#define SIM_HAL_RTHS_RUNGE_KUTTA_H

namespace berth::rths
{

/* `derivative(state, time since the step's begin in s)` returns a state. */
template <class State, class Derivative>
State runge_kutta_step(const State &state, double step_s, const Derivative &derivative)
{
    const State k1 = derivative(state, 0.0);
    const State k2 = derivative(State(state + 0.5 * step_s * k1), 0.5 * step_s);
    const State k3 = derivative(State(state + 0.5 * step_s * k2), 0.5 * step_s);
    const State k4 = derivative(State(state + step_s * k3), step_s);
    return state + step_s / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
}

} // namespace berth::rths

#endif
