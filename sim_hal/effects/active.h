/* The stages of the effects that a rig has. */
#ifndef SIM_HAL_EFFECTS_ACTIVE_H
#define SIM_HAL_EFFECTS_ACTIVE_H

#include <string>

#include "effect.h"

namespace berth
{

/* In the order of the library. `hook`: one of effect's on_ members. `block`: only of this one; empty: of any. */
template <typename stage>
std::vector<std::unique_ptr<stage>> active_stages(const rig &rig,
                                                  std::unique_ptr<stage> (*effect::*hook)(const berth::rig &),
                                                  std::string_view block = {})
{
    std::vector<std::unique_ptr<stage>> stages;
    for (const effect &known : effect_library()) {
        if (known.*hook != nullptr && is_active(known, rig) && (block.empty() || known.block() == block)) {
            if (auto made = (known.*hook)(rig)) {
                stages.push_back(std::move(made));
            }
        }
    }
    return stages;
}

/* The rig has an effect between the robot's reference and the force that the sensor samples that the plant's
 * equations do not have. */
bool has_hardware_effects(const rig &rig);
bool is_hardware_effect(const effect &effect);

/* Names of the effects that the rig has, of those that are asked for; with commas between. */
std::string effect_names(const rig &rig, bool (*is_asked_for)(const effect &));

/* The keys of those effects that are not 0; with commas between. */
std::string effect_keys_of(const rig &rig, bool (*is_asked_for)(const effect &));

/* Small motions do not have it as it is: they would grow or swing by their size, or change as they go on. */
bool is_beyond_small_motion(const effect &effect);

/* A swing of an arm with the object's own modes does not have it. */
bool is_beyond_free_swing(const effect &effect);

/* The rig has a further force on its "object" or "manipulator". */
inline bool has_body_effects(const rig &rig, std::string_view block)
{
    return !active_stages(rig, &effect::on_body, block).empty();
}

/* A robot that lags has a position controller, and a limit of its velocity is one of what that controller asks for:
 * tau r' = u - r within |r'| <= V. Without a lag the limit is on the reference: see velocity_follower. With a limit
 * of the acceleration beside it, both are on the setpoints that the reference runs between. */
bool saturates_in_lag(const rig &rig);
bool limits_reference(const rig &rig);

/* Gain of the loop by the effects that are one; 1 without. */
double gain_when_small(const rig &rig);

/* A line for each effect of the rig that eigenvalues, exponents and maps of small motions leave out, and why. */
std::vector<std::string> left_out_when_small(const rig &rig);

/* A line for each effect of the rig that the reduction of an arm or a beam leaves out, by its keys. */
std::vector<std::string> left_out_of_reduction(const rig &rig);

/* A line for each effect that changes the loop for as long as it runs. */
std::vector<std::string> taken_as_at_the_start(const rig &rig);

/* The same rig without the effects but those that decide what is lost, and when. */
rig without_effects_on_signals(const rig &original);

/* Value of a key that an effect brings along. */
double value_of_effect(const rig &rig, std::string_view key);

} // namespace berth

#endif
