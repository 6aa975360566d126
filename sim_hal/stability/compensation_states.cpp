#include "compensation_states.h"

#include "../../hal/rig/rig_file.h"

namespace berth
{

namespace
{

/* Newest first. */
void add_past(std::vector<double *> &places, past &of, std::uint32_t ticks)
{
    for (std::uint32_t i = 0; i < ticks; i++) {
        places.push_back(&of.values[(of.newest + PAST_TICKS - i) % PAST_TICKS]);
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
    add_past(places, twin.samples_N, twin.delay_ticks);
}

bool adapts(const adaptive_inverse_config &inverse)
{
    return inverse.enabled && (inverse.tolerance > 0.0 || inverse.gain_tolerance > 0.0);
}

} // namespace

bool compensation_is_linear(const rig &rig)
{
    return !rig.firmware.identification.enabled && !adapts(rig.firmware.adaptive_inverse) &&
           rig.firmware.passivity.action == PASSIVITY_OFF;
}

void check_compensation_is_linear(const rig &rig)
{
    if (rig.firmware.identification.enabled) {
        throw input_error(
            "identification.enabled: a model that is identified while the loop runs has no eigenvalues; "
            "look at the growth that `berth run` measures, or set it to false");
    }
    if (adapts(rig.firmware.adaptive_inverse)) {
        throw input_error(
            "adaptive_inverse.tolerance: an inverse that adapts has no eigenvalues; look at the growth that "
            "`berth run` measures, or set it and adaptive_inverse.gain_tolerance to 0");
    }
    if (rig.firmware.passivity.action != PASSIVITY_OFF) {
        throw input_error("passivity.action: a passivity controller has no eigenvalues; look at the growth that "
                          "`berth run` measures, or set it to off");
    }
}

void refuse_compensation(const rig &rig)
{
    if (compensation_is_on(&rig.firmware)) {
        throw input_error("compensation is on (extrapolation, adaptive inverse, force lead, prediction, dissipation "
                          "or passivity), and a loop that changes from tick to tick has no exponent with it: "
                          "`berth limits` leaves the change out, `berth run` measures the growth with it");
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
        add_past(places, e.past_m, oldest);
    }
    if (units.config->adaptive_inverse.enabled) {
        places.insert(places.end(), {&units.inverse.before_m[0], &units.inverse.before_m[1]});
    }
    if (units.config->force_lead.enabled) {
        force_lead &lead = units.lead;
        add_past(places, lead.model_N, static_cast<std::uint32_t>(lead.settings.age_ticks) + 1);
        places.push_back(&units.velocity_m_per_s);
        if (lead.error_share < 1.0) {
            places.push_back(&lead.fed_back_N);
        }
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
    units.lead.is_filled = 1;
    const std::vector<double *> to = places(units);
    for (std::size_t i = 0; i < to.size(); i++) {
        *to[i] = state(static_cast<Eigen::Index>(i));
    }
    return units;
}

} // namespace berth
