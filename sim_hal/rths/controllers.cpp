#include <array>

#include "../../hal/rig/rig_file.h"
#include "controller.h"
#include "firmware_controller.h"

namespace berth::rths
{

namespace
{

/* (b1 s + b0) / (s + a0) by Tustin's rule. */
class first_order
{
  public:
    first_order(double b1, double b0, double a0)
    {
        const double c = 2.0 * rate_Hz;
        now_ = (b1 * c + b0) / (c + a0);
        before_ = (b0 - b1 * c) / (c + a0);
        back_ = (c - a0) / (c + a0);
    }

    double step(double input)
    {
        output_ = now_ * input + before_ * input_before_ + back_ * output_;
        input_before_ = input;
        return output_;
    }

  private:
    double now_;
    double before_;
    double back_;
    double input_before_ = 0.0;
    double output_ = 0.0;
};

/* The benchmark's example. */
class pi_controller : public controller
{
  public:
    controller_output step(const controller_input &input) override
    {
        const double wanted_m = lead_.step(input.target_m);
        return {pi_.step(wanted_m - input.measured_m), input.late_N};
    }

  private:
    first_order lead_{50.83, 8570.4, 8570.4};
    first_order pi_{2.0, 95.0, 0.0};
};

/* The actuator that moves nothing (a spring of 1 N/m, no mass), inverted: a polynomial of third order, derivatives
 * of the target by backward differences. That it knows nothing of the specimen, nor of the command's gain, is what
 * the row of the table is about. */
class third_order_inverse : public controller
{
  public:
    third_order_inverse()
    {
        /* The figures of that model, rounded as its authors round them. */
        constexpr double valve_gain = 2.13e13;
        constexpr double valve_rate_per_s = 425.0;
        constexpr double valve_spring_per_s2 = 1e5;
        constexpr double leakage_per_s = 3.3;
        constexpr double spring_N_per_m = 1.0;
        constexpr double rate_term_N_per_m = spring_N_per_m + 4.23e6;
        /* (s^2 + b1 s + b2) ((k + a2) s + a3 k) x + a1b0 x = a1b0 u */
        const double rest = leakage_per_s * spring_N_per_m;
        weights_ = {(valve_spring_per_s2 * rest + valve_gain) / valve_gain,
                    (valve_spring_per_s2 * rate_term_N_per_m + valve_rate_per_s * rest) / valve_gain,
                    (valve_rate_per_s * rate_term_N_per_m + rest) / valve_gain, rate_term_N_per_m / valve_gain};
    }

    controller_output step(const controller_input &input) override
    {
        double derivative = input.target_m;
        double command_m = weights_[0] * derivative;
        for (std::size_t order = 1; order < weights_.size(); order++) {
            const double before = before_[order - 1];
            before_[order - 1] = derivative;
            derivative = (derivative - before) * rate_Hz;
            command_m += weights_[order] * derivative;
        }
        return {command_m, input.late_N};
    }

  private:
    std::array<double, 4> weights_{};
    std::array<double, 3> before_{};
};

} // namespace

std::vector<std::string> controller_names()
{
    return {"pi", "inverse", "firmware", "firmware-late"};
}

std::unique_ptr<controller> make_controller(const std::string &name, const known_beforehand &known)
{
    if (name == "pi") {
        return std::make_unique<pi_controller>();
    }
    if (name == "inverse") {
        return std::make_unique<third_order_inverse>();
    }
    if (name == "firmware" || name == "firmware-late") { /* late: the frame gets the force as the benchmark has it */
        return std::make_unique<firmware_controller>(known, name == "firmware");
    }
    throw input_error(name + ": no such controller");
}

} // namespace berth::rths
