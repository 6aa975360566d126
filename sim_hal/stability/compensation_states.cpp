#include "compensation_states.h"

#include "../../hal/rig/rig_file.h"

namespace berth
{

namespace
{

/* Newest first. */
void add_ring(std::vector<double *> &places, double *ring, std::uint32_t size, std::uint32_t newest,
              std::uint32_t count)
{
    for (std::uint32_t i = 0; i < count; i++) {
        places.push_back(&ring[(newest + size - i) % size]);
    }
}

/* What this hardware has: the others would be modes that never move. */
void add_twin(std::vector<double *> &places, hardware_twin &twin)
{
    const hardware_model &m = twin.model;
    const bool is_there[TWIN_STATES] = {true,
                                        true,
                                        m.low_pass_order > 0,
                                        m.low_pass_order > 1,
                                        m.robot_w_rad_per_s > 0.0,
                                        m.robot_w_rad_per_s > 0.0,
                                        m.robot_lag_ms > 0.0,
                                        m.sensor_lag_ms > 0.0};
    for (int i = 0; i < TWIN_STATES; i++) {
        if (is_there[i]) {
            places.push_back(&twin.state[i]);
        }
    }
    places.push_back(&twin.position_m);
    if (m.holds) {
        places.push_back(&twin.before_m);
    }
    add_ring(places, twin.samples_N, TWIN_TICKS_MAX, twin.newest, twin.delay_ticks);
}

} // namespace

void check_compensation_is_linear(const rig &rig)
{
    if (rig.firmware.identification.enabled) {
        throw input_error(
            "identification.enabled: a model that is identified while the loop runs has no eigenvalues; "
            "look at the growth that `berth run` measures, or set it to false");
    }
    if (rig.firmware.passivity.action != PASSIVITY_OFF) {
        throw input_error("passivity.action: a passivity controller has no eigenvalues; look at the growth that "
                          "`berth run` measures, or set it to off");
    }
}

void refuse_compensation(const rig &rig)
{
    if (compensation_is_on(&rig.firmware)) {
        throw input_error(
            "compensation is on (extrapolation, prediction, dissipation or passivity): `berth eigen` and "
            "`berth map` know such loops, limits and Lyapunov exponents do not");
    }
}

compensation_states::compensation_states(const app_config &config)
{
    static const manipulator resting{};
    compensation_start(&started_, &config, &resting);
}

std::vector<double *> compensation_states::places(compensation &units) const
{
    std::vector<double *> places;
    extrapolation &e = units.extrapolation;
    if (e.order > 0) {
        const auto oldest = static_cast<std::uint32_t>(e.order * e.delay_ticks) + 1;
        add_ring(places, e.past_m, EXTRAPOLATION_TICKS_MAX, e.newest, oldest);
    }
    if (units.prediction.enabled) {
        add_twin(places, units.prediction.twin);
        places.push_back(&units.prediction.fed_back_N);
    }
    return places;
}

Eigen::VectorXd compensation_states::values_at(const std::vector<double *> &places)
{
    Eigen::VectorXd values(static_cast<Eigen::Index>(places.size()));
    for (std::size_t i = 0; i < places.size(); i++) {
        values(static_cast<Eigen::Index>(i)) = *places[i];
    }
    return values;
}

compensation compensation_states::in_state(const Eigen::Ref<const Eigen::VectorXd> &state,
                                           const manipulator &manipulator) const
{
    compensation units = started_;
    units.manipulator = &manipulator;
    units.prediction.manipulator = &manipulator;
    const std::vector<double *> to = places(units);
    for (std::size_t i = 0; i < to.size(); i++) {
        *to[i] = state(static_cast<Eigen::Index>(i));
    }
    return units;
}

} // namespace berth
