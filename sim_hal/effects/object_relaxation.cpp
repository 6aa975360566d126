#include <array>
#include <cmath>

#include "by_step.h"
#include "effects.h"

namespace berth
{

namespace
{

/* A spring and a damper in a row, z' = kR x' - z/tau, exact over a sub-step over which the object moves evenly. The
 * object's velocity is the mean of the sub-step, which the element itself lowers. */
class maxwell_element final : public force_stage
{
  public:
    maxwell_element(double stiffness_N_per_m, double time_s) : stiffness_N_per_m_(stiffness_N_per_m), time_s_(time_s)
    {
    }
    void start(const body_motion &motion) override { before_m_per_s_ = motion.velocity_m_per_s; }
    double force_N(const body_motion &motion, double step_s) override
    {
        const double decay = decay_.at(step_s, [this](double h) { return std::exp(-h / time_s_); });
        const double kept = (1.0 - decay) * time_s_ / step_s; /* of z, on average over the step */
        const double damping = stiffness_N_per_m_ * time_s_;  /* of a steady motion, N s/m */
        const double steady = damping * (1.0 - kept);
        const double alone_m_per_s = 0.5 * (before_m_per_s_ + motion.velocity_m_per_s);
        const double slows = 0.5 * motion.velocity_per_force;
        const double over_step_N = (kept * force_N_ + steady * alone_m_per_s) / (1.0 + steady * slows);
        const double mean_m_per_s = alone_m_per_s - slows * over_step_N;
        before_m_per_s_ = motion.velocity_m_per_s - motion.velocity_per_force * over_step_N;
        force_N_ = decay * force_N_ + damping * (1.0 - decay) * mean_m_per_s;
        return over_step_N;
    }
    bool is_linear() const override { return true; }
    linear_law law(double step_s, double velocity_per_force) const override
    {
        linear_law made;
        for (std::size_t i = 0; i < made.column.size(); i++) {
            maxwell_element element = *this;
            element.force_N_ = i == 0 ? 1.0 : 0.0;
            element.before_m_per_s_ = i == 1 ? 1.0 : 0.0;
            const double velocity = i == linear_law::kept ? 1.0 : 0.0;
            const double over_step_N = element.force_N({0.0, 0.0, velocity, 0.0, 0.0, velocity_per_force}, step_s);
            made.column[i] = {element.force_N_, element.before_m_per_s_, 0.0, 0.0, over_step_N};
        }
        return made;
    }

  private:
    double stiffness_N_per_m_;
    double time_s_;
    by_step<double> decay_;
    double before_m_per_s_ = 0.0;
    double force_N_ = 0.0; /* z */
};

} // namespace

effect object_relaxation()
{
    effect made;
    made.name = "object.relaxation";
    made.physics =
        "A spring and a damper in a row act beside the object's spring, so that its force settles after it "
        "moved: a further force z, z' = kR x' - z/tau.";
    made.source = "Maxwell 1867; rubber, foam, harnesses";
    made.calibration = {18,
                        "move the object quickly to another place, hold it there, and record how its force settles"};
    made.parameters = {
        {"object.relaxation_stiffness_N_per_m", 0.0, 1e9, "kR of a spring that a damper lets go; 0: none"},
        {"object.relaxation_time_ms", 0.1, 1e6, "tau, over which its force settles"}};
    made.object = object_needed::no_contact;
    made.is_seen = [](const rig &fitted, const record_scales &scales) {
        /* What settles within a few rows is a damper, over the whole record a spring. */
        const double time_s = 1e-3 * value_of(fitted, "object.relaxation_time_ms");
        return time_s > scales.period_s && time_s < scales.duration_s;
    };
    made.sizes = 1;
    made.starts = [](const rig &, const record_scales &scales) {
        std::vector<effect_values> all;
        const double stiffness = 0.1 * scales.force_N / std::max(1e-12, scales.position_m);
        for (const double time_ms : {10.0, 40.0, 160.0, 640.0, 2500.0}) {
            all.push_back({stiffness, time_ms});
        }
        return all;
    };
    made.on_body = [](const rig &rig) -> std::unique_ptr<force_stage> {
        return std::make_unique<maxwell_element>(value_of(rig, "object.relaxation_stiffness_N_per_m"),
                                                 1e-3 * value_of(rig, "object.relaxation_time_ms"));
    };
    made.is_proportional = true;
    made.when_small = small_motion::in_the_equations;
    return made;
}

} // namespace berth
