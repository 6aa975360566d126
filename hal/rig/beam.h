/* A gripped object that is a beam: what the loop feels of it, mode by mode. */
#ifndef HAL_RIG_BEAM_H
#define HAL_RIG_BEAM_H

#include <optional>
#include <string_view>

#include "rig.h"

namespace berth
{

/* A key that counts for a beam alone, and one whose value follows from the beam. */
bool belongs_to_beam(std::string_view path);
bool follows_from_beam(std::string_view path);

/* Checks the beam of a rig that has one, and derives its modes where it is another beam than before: what was
 * changed since then in the object's mass, damping or stiffness stays, and is so in all modes. */
std::optional<rig_error> complete_beam(rig &rig);

/* Mode `i`, from 0, of the object as it is now; its wave number is left out. */
beam_mode object_mode(const object_rig &object, std::int64_t i);

/* All of them: one where it is no beam. */
std::vector<beam_mode> object_modes(const object_rig &object);

/* Throws input_error for a beam of several modes: what reckons with an object of one degree of freedom alone. */
void refuse_beam(const rig &rig);

} // namespace berth

#endif
