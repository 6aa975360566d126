/* What may be missing, as JSON. */
#ifndef SIM_HAL_CLI_JSON_OR_NULL_H
#define SIM_HAL_CLI_JSON_OR_NULL_H

#include <nlohmann/json.hpp>
#include <optional>

namespace berth
{

/* Nothing is null. */
template <typename T>
nlohmann::json or_null(const std::optional<T> &value)
{
    return value ? nlohmann::json(*value) : nlohmann::json();
}

} // namespace berth

#endif
