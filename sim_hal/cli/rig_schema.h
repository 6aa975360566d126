/* The JSON schema of rig files (draft 2020-12), made from the tables that read them. Each key has its description,
 * unit, section, range, default and permitted words. */
#ifndef SIM_HAL_CLI_RIG_SCHEMA_H
#define SIM_HAL_CLI_RIG_SCHEMA_H

#include <string>

namespace berth
{

/* Where `berth init` puts it, beside the rig file that names it. */
constexpr const char *rig_schema_file = "berth-rig.schema.json";

/* Indented, with a line's end. */
std::string rig_schema_text();

} // namespace berth

#endif
