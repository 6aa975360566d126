#include <cstdio>
#include <nlohmann/json.hpp>

#include "../../hal/rig/units.h"
#include "../diagnosis/diagnosis.h"
#include "commands.h"

namespace berth
{

int effects_command(bool json)
{
    nlohmann::json all = nlohmann::json::array();
    for (const effect &known : effect_library()) {
        nlohmann::json parameters = nlohmann::json::array();
        for (const effect_parameter &parameter : known.parameters) {
            const rig_key *const key = find_key(parameter.key);
            parameters.push_back({{"key", parameter.key},
                                  {"unit", unit_of(parameter.key)},
                                  {"meaning", key->meaning},
                                  {"low", parameter.low},
                                  {"high", parameter.high}});
        }
        all.push_back({{"effect", known.name},
                       {"physics", known.physics},
                       {"source", known.source},
                       {"parameters", parameters}});
    }
    if (json) {
        print_json(all);
        return 0;
    }
    for (const auto &known : all) {
        std::printf("%s\n  %s\n  source: %s\n", known["effect"].get<std::string>().c_str(),
                    known["physics"].get<std::string>().c_str(), known["source"].get<std::string>().c_str());
        for (const auto &parameter : known["parameters"]) {
            std::printf("  %-45s %s\n", parameter["key"].get<std::string>().c_str(),
                        parameter["meaning"].get<std::string>().c_str());
        }
    }
    return 0;
}

} // namespace berth
