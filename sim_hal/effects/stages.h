/* Where an effect can act. A stage lives for one run over one record, and is called once a tick or once a sub-step.
 */
#ifndef SIM_HAL_EFFECTS_STAGES_H
#define SIM_HAL_EFFECTS_STAGES_H

#include <algorithm>
#include <array>
#include <memory>
#include <vector>

namespace berth
{

/* Setpoints as the robot takes them, once a tick. */
class setpoint_stage
{
  public:
    virtual ~setpoint_stage() = default;
    virtual void start(double setpoint_m) = 0;
    virtual double take(double setpoint_m) = 0;
    virtual std::unique_ptr<setpoint_stage> copy() const = 0; /* with all that it remembers */
};

/* A signal on its way through the hardware, straight within a sub-step: the robot's position in m, the force in N.
 */
class motion_stage
{
  public:
    virtual ~motion_stage() = default;
    virtual void start(double value) = 0;
    /* The same of one that may stand elsewhere: it was seen at `seen`. */
    virtual void start_seen(double value, double) { start(value); }
    virtual double advance(double value, double step_s) = 0;

    /* Where it turned off a straight line on the last step: by how much it passed beside that line on average. */
    virtual double bulge() const { return 0.0; }

    /* What it makes of a value depends on the way there. */
    virtual bool has_memory() const { return true; }

    /* The signal jumps to `value`. */
    virtual double jump(double value) { return advance(value, 0.0); }
};

/* A body, at the end of a sub-step as it would be without this force. */
struct body_motion {
    double position_m;
    double deflection_m; /* of its spring: of the manipulator x - x_op, of the object x */
    double velocity_m_per_s;
    double velocity_before_m_per_s; /* at the start of the sub-step */
    double time_s;
    double velocity_per_force; /* what 1 N over the sub-step adds to the velocity, m/(s N) */
};

/* A step of a further force that is linear: what it keeps and the force over the step, N, of what it kept before the
 * step and the body's velocity without it, m/s. By columns. */
struct linear_law {
    static constexpr std::size_t kept = 4;
    std::array<std::array<double, kept + 1>, kept + 1> column{};
};

/* A further force on a body, against its motion where it is positive. */
class force_stage
{
  public:
    virtual ~force_stage() = default;
    virtual void start(const body_motion &) {}
    virtual double force_N(const body_motion &motion, double step_s) = 0;

    /* Whether it would change so much over the next `way_m` that shorter steps are worth it. */
    virtual bool is_abrupt(double) const { return false; }

    /* It depends on the body's velocity alone, starts from zeros at rest, and has a law. */
    virtual bool is_linear() const { return false; }
    virtual linear_law law(double /* step_s */, double /* velocity_per_force */) const { return {}; }
};

inline bool any_is_abrupt(const std::vector<std::unique_ptr<force_stage>> &forces, double way_m)
{
    return std::any_of(forces.begin(), forces.end(), [&](const auto &force) { return force->is_abrupt(way_m); });
}

/* Samples of the force as they leave the sensor, once a tick. */
class sample_stage
{
  public:
    virtual ~sample_stage() = default;
    virtual double take(double force_N, double time_s) = 0;
};

} // namespace berth

#endif
