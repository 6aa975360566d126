/* Times an arm's step.
 *
 *   arm_bench time ARM SAMPLES     a JSON object: ns, median and p99.9, in turns; of all, and of the least of each
 * tick arm_bench step ARM STEPS       so many steps and nothing else, to be counted from outside
 */
#include <cstdlib>

#include "../../firmware/arm/integrators.h"
#include "../../hal/rig/arm_file.h"
#include "timed.h"

namespace
{

template <class Space>
struct own_arm {
    berth::chain<Space> chain;
    berth::chain_state<Space> state;
    berth::chain_input<Space> input{};

    explicit own_arm(const arm_config &config)
        : chain(berth::make_chain<Space>(config)), state(berth::state_at_start<Space>(config))
    {
        for (int i = 0; i < chain.joint_count; i++) {
            state.link_rad()(i) = state.motor_rad()(i) = 0.3 + 0.1 * i;
            state.link_rate()(i) = 0.05 * (i + 1);
        }
        input.command_rad = state.motor_rad();
        input.tool.force.setConstant(3.0);
    }
    void step(arm_integrator integrator) { state = berth::advanced(chain, state, input, integrator, 2.5e-3, 0.0); }
    double dynamics() const
    {
        const berth::joint_drive drive = {berth::joint_vector::Constant(1.0), berth::joint_vector::Zero()};
        return berth::forward_dynamics(chain, state, drive, input).link_rad_per_s2(0);
    }
};

template <class Space>
int time_steps(const arm_config &config, int samples)
{
    timed euler{"semi_implicit_euler"};
    timed rk4{"rk4"};
    timed midpoint{"implicit_midpoint"};
    timed dynamics{"forward_dynamics"};
    volatile double kept = 0.0;
    for (int pass = 0; pass < passes; pass++) {
        own_arm<Space> arm(config);
        for (std::size_t i = 0; i < static_cast<std::size_t>(samples); i++) {
            euler.once(i, [&] { arm.step(ARM_SEMI_IMPLICIT_EULER); });
            rk4.once(i, [&] { arm.step(ARM_RK4); });
            midpoint.once(i, [&] { arm.step(ARM_IMPLICIT_MIDPOINT); });
            dynamics.once(i, [&] { kept = arm.dynamics(); });
        }
    }
    (void)kept;
    print_timed({&euler, &rk4, &midpoint, &dynamics});
    return 0;
}

template <class Space>
int count_steps(const arm_config &config, int steps)
{
    own_arm<Space> arm(config);
    for (int i = 0; i < steps; i++) {
        arm.step(ARM_IMPLICIT_MIDPOINT);
    }
    return arm.state.values.allFinite() ? 0 : 1;
}

} // namespace

int main(int argc, char **argv)
{
    if (argc != 4) {
        std::fprintf(stderr, "usage: arm_bench time|step ARM COUNT\n");
        return 2;
    }
    const arm_config config = berth::load_arm(argv[2]).config;
    const bool is_planar = config.kind == ARM_PLANAR;
    const int count = static_cast<int>(std::strtol(argv[3], nullptr, 10));
    if (std::string(argv[1]) == "step") {
        return is_planar ? count_steps<berth::plane>(config, count) : count_steps<berth::space>(config, count);
    }
    return is_planar ? time_steps<berth::plane>(config, count) : time_steps<berth::space>(config, count);
}
