#include <algorithm>
#include <array>
#include <cmath>

#include "by_step.h"
#include "effects.h"

namespace berth
{

namespace
{

/* Exact over a sub-step in which the object moves evenly: y = x2 - x is a damped oscillator that the object's
 * acceleration, an impulse at the start of the step, drives. */
class hanging_mass final : public force_stage
{
  public:
    hanging_mass(double mass_kg, double frequency_Hz, double damping_ratio)
        : mass_kg_(mass_kg), w_(2.0 * 3.14159265358979323846 * frequency_Hz), z_(damping_ratio)
    {
    }
    void start(const body_motion &motion) override { before_m_per_s_ = motion.velocity_m_per_s; }
    double force_N(const body_motion &motion, double step_s) override
    {
        const transition &a = transitions_.at(step_s, [this](double h) { return transition_over(h); });
        /* The force slows the object that kicks: force = from + by kick, kick = free + slowed force. */
        const double spring = -mass_kg_ * w_ * w_;
        const double damper = -mass_kg_ * 2.0 * z_ * w_;
        const double free = before_m_per_s_ - motion.velocity_m_per_s;
        const double slowed = motion.velocity_per_force;
        const double end_N =
            spring * (a[0] * offset_m_ + a[1] * rate_m_per_s_) + damper * (a[2] * offset_m_ + a[3] * rate_m_per_s_);
        const double from_N = 0.5 * (force_N_ + end_N);
        const double by = 0.25 * (spring * a[1] + damper * (a[3] + 1.0));
        const double kick = (free + slowed * from_N) / (1.0 - slowed * by);
        before_m_per_s_ -= kick;
        const double rate = rate_m_per_s_ + 0.5 * kick;
        const double next_m = a[0] * offset_m_ + a[1] * rate;
        rate_m_per_s_ = a[2] * offset_m_ + a[3] * rate + 0.5 * kick;
        offset_m_ = next_m;
        const double before_N = force_N_;
        force_N_ = spring * offset_m_ + damper * rate_m_per_s_;
        return 0.5 * (before_N + force_N_); /* over the step */
    }
    bool is_linear() const override { return true; }
    linear_law law(double step_s, double velocity_per_force) const override
    {
        linear_law made;
        for (std::size_t i = 0; i < made.column.size(); i++) {
            std::array<double, linear_law::kept + 1> unit{};
            unit[i] = 1.0;
            hanging_mass mass = *this;
            mass.offset_m_ = unit[0];
            mass.rate_m_per_s_ = unit[1];
            mass.before_m_per_s_ = unit[2];
            mass.force_N_ = unit[3];
            const double over_step_N = mass.force_N({0.0, 0.0, unit[4], 0.0, 0.0, velocity_per_force}, step_s);
            made.column[i] = {mass.offset_m_, mass.rate_m_per_s_, mass.before_m_per_s_, mass.force_N_, over_step_N};
        }
        return made;
    }

  private:
    using transition = std::array<double, 4>;

    transition transition_over(double step_s) const
    {
        const double decay = std::exp(-z_ * w_ * step_s);
        const double under = 1.0 - z_ * z_;
        const double wd = w_ * std::sqrt(std::max(1e-12, std::abs(under)));
        const double c = under > 0.0 ? std::cos(wd * step_s) : std::cosh(wd * step_s);
        const double s = (under > 0.0 ? std::sin(wd * step_s) : std::sinh(wd * step_s)) / wd;
        return {decay * (c + z_ * w_ * s), decay * s, -decay * w_ * w_ * s, decay * (c - z_ * w_ * s)};
    }

    double mass_kg_;
    double w_;
    double z_;
    by_step<transition> transitions_;
    double offset_m_ = 0.0;
    double rate_m_per_s_ = 0.0;
    double before_m_per_s_ = 0.0;
    double force_N_ = 0.0; /* at the end of the last step */
};

} // namespace

effect object_second_mode()
{
    effect made;
    made.name = "object.second_mode";
    made.physics = "A further mass hangs on the object: m2 x2'' + d2 (x2' - x') + k2 (x2 - x) = 0.";
    made.source = "the next mode of a flexible appendage";
    made.calibration = {28, "tap the object, and record how it rings"};
    made.parameters = {{"object.second_mass_kg", 0.0, 1e9, "m2 of a further mass on the object; 0: none"},
                       {"object.second_frequency_Hz", 0.05, 200.0, "frequency of the further mass by itself"},
                       {"object.second_damping_ratio", 0.0, 1.0, "damping ratio of the further mass by itself"}};
    made.is_seen = [](const rig &fitted, const record_scales &scales) {
        /* Five periods: what is slower is no mode of this record. */
        return value_of(fitted, "object.second_frequency_Hz") * scales.duration_s > 5.0;
    };
    made.sizes = 2; /* without a frequency it is mass of the object */
    made.starts = [](const rig &base, const record_scales &scales) {
        std::vector<effect_values> all;
        for (const double frequency_Hz : {1.0, 1.6, 2.5, 4.0, 6.3, 10.0, 16.0, scales.residual_frequency_Hz}) {
            if (frequency_Hz > 0.05) {
                all.push_back({0.05 * base.object.mass_kg, frequency_Hz, 0.02});
                all.push_back({0.05 * base.object.mass_kg, frequency_Hz, 0.1});
            }
        }
        return all;
    };
    made.on_body = [](const rig &rig) -> std::unique_ptr<force_stage> {
        return std::make_unique<hanging_mass>(value_of(rig, "object.second_mass_kg"),
                                              value_of(rig, "object.second_frequency_Hz"),
                                              value_of(rig, "object.second_damping_ratio"));
    };
    made.is_proportional = true;
    made.when_small = small_motion::in_the_equations;
    return made;
}

} // namespace berth
