/* The unit of a key, which ends its name. */
#ifndef HAL_RIG_UNITS_H
#define HAL_RIG_UNITS_H

#include <string>
#include <string_view>

namespace berth
{

/* As in the name: "N_s_per_m"; "1" for a plain number. */
std::string_view unit_of(std::string_view key);

/* As people write it: "N s/m"; empty for a plain number. */
std::string unit_text(std::string_view key);

} // namespace berth

#endif
