#include "compensation_choice.h"

#include <algorithm>
#include <string_view>

#include "../../hal/rig/names.h"
#include "../../hal/rig/rig_file.h"

namespace berth
{

namespace
{

struct named_settings {
    std::string_view name;
    std::vector<std::string_view> settings;
};

const named_settings choices[] = {
    {"extrapolation-1", {"extrapolation.order=1"}},
    {"extrapolation-2", {"extrapolation.order=2"}},
    {"extrapolation-3", {"extrapolation.order=3"}},
    {"fixed-inverse",
     {"adaptive_inverse.enabled=true", "adaptive_inverse.tolerance=0", "adaptive_inverse.gain_tolerance=0"}},
    {"adaptive-inverse", {"adaptive_inverse.enabled=true"}},
    {"force-lead", {"force_lead.enabled=true"}},
    {"prediction", {"prediction.enabled=true"}},
    {"identification", {"prediction.enabled=true", "identification.enabled=true"}},
    {"passivity", {"passivity.action=damping"}},
    {"tank", {"passivity.action=tank"}},
};

} // namespace

std::string compensation_names()
{
    std::string names;
    for (const named_settings &known : choices) {
        names += (names.empty() ? "" : ", ") + std::string(known.name);
    }
    return names;
}

bool is_compensation(const std::string &name)
{
    return std::any_of(std::begin(choices), std::end(choices),
                       [&](const named_settings &known) { return known.name == name; });
}

std::string compensation_for_rig(const std::string &name)
{
    return name + ": is a compensation and no rig; give --with once for each: --with " + name;
}

std::vector<std::string> compensation_settings(const std::vector<std::string> &names)
{
    std::vector<std::string> settings;
    for (const std::string &name : names) {
        const auto found = std::find_if(std::begin(choices), std::end(choices),
                                        [&](const named_settings &known) { return known.name == name; });
        if (found == std::end(choices)) {
            std::vector<std::string> known;
            for (const named_settings &one : choices) {
                known.emplace_back(one.name);
            }
            throw input_error("--with " + name + ": there is no such compensation; there are " +
                              compensation_names() + did_you_mean(known, name));
        }
        settings.insert(settings.end(), found->settings.begin(), found->settings.end());
    }
    return settings;
}

} // namespace berth
