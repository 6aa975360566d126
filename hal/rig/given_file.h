/* What a rig file says of its own values: stated, or assumed by whoever printed it. For the reader of rig files. */
#ifndef HAL_RIG_GIVEN_FILE_H
#define HAL_RIG_GIVEN_FILE_H

#include <string>
#include <vector>

#include "given.h"
#include "toml_file.h"

namespace berth
{

/* Every key that has a place was stated. */
void note_given(rig &rig, const key_places &places);

/* `assumed = ["limits", "sensor.delay_ms"]`: sections and keys that stand there and count as not stated. Throws
 * input_error. */
std::vector<std::string> read_assumed(const toml::node &node, const std::string &where);

} // namespace berth

#endif
