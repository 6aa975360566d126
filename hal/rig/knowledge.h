/* What a rig file says about its values: how well they are known, and where a record keeps the signals. */
#ifndef HAL_RIG_KNOWLEDGE_H
#define HAL_RIG_KNOWLEDGE_H

#include <sstream>

#include "toml_file.h"

namespace berth
{

/* One line of [tolerances]. */
void set_tolerance(rig &rig, const std::string &path, const toml::node &share, const std::string &where);

/* mass_kg = { value = 100, tolerance = 0.05 }: keeps the tolerance and returns the value. */
const toml::node &split_tolerance(rig &rig, const std::string &path, const toml::node &node,
                                  const std::string &where);

/* One line of [signals]. */
void read_signal(rig &rig, const std::string &name, const toml::node &node, const std::string &where);

/* Both sections as TOML. */
void print_knowledge(const rig &rig, std::ostringstream &text);

} // namespace berth

#endif
