/* What a rig states, and what the program assumes because nobody stated it. */
#ifndef HAL_RIG_GIVEN_H
#define HAL_RIG_GIVEN_H

#include <string>
#include <string_view>
#include <vector>

#include "rig.h"

namespace berth
{

/* The value of this key was stated. Paths that are no key of the table are passed over. */
void set_given(rig &rig, std::string_view path, bool is_given);
bool is_given(const rig &rig, std::string_view path);

/* It states a robot, and neither a manipulator nor an object: what is recorded of it may be diagnosed, and no loop
 * runs with it. Its setpoints may be known ahead, so that it may be less late than one in a loop. */
bool is_robot_alone(const rig &rig);

/* At least one key of this section was stated. */
bool states_section(const rig &rig, std::string_view section);

/* What a printed configuration says of a key: "given: ", "assumed: ", or nothing where no assumption is made. */
std::string_view given_mark(const rig &rig, std::string_view path);

/* What is assumed: a section that states nothing by its name, of others the keys. */
std::vector<std::string> assumed_names(const rig &rig);

/* The list as text, as logs hold it, and back. False: a name is none of a key or section, and was passed over. */
std::string assumed_text(const rig &rig);
bool set_assumed(rig &rig, std::string_view text);

/* The answer hangs on object, manipulator and the robot's dead time: a rig that takes their values without a word is
 * refused. `origin`: the rig's file in the message. Throws input_error. */
void refuse_unstated(const rig &rig, const std::string &origin);

} // namespace berth

#endif
