#include "compensated_report.h"

#include <cstdio>

#include "../compensated.h"
#include "../stability/arm_loop.h"
#include "../verdict_words.h"
#include "gains_report.h"
#include "short_number.h"
#include "verdict_report.h"

namespace berth
{

namespace
{

std::string or_none(const std::optional<double> &value)
{
    return value ? short_number(*value) : "none";
}

const char *source_words(bool is_measured)
{
    return is_measured
               ? "growth of runs of 20 s without noise, as this compensation with these effects has no eigenvalues"
               : "eigenvalues of the loop with its compensation";
}

nlohmann::json growth_json(const stability_verdict &verdict)
{
    return verdict.growth ? nlohmann::json(verdict.growth->growth_per_s) : nlohmann::json();
}

} // namespace

int answer_compensated_growth(const rig &rig, const rig_arguments &arguments)
{
    refuse_arm(rig);
    const stability_verdict verdict = growth_of_compensated(rig, arguments.amplitude_m).verdict;
    const stability_margin margin =
        touches_nothing(rig) ? margin_of(rig) : margin_of_compensated(rig, arguments.amplitude_m);
    if (arguments.json) {
        nlohmann::json json = answer_json(rig, verdict, margin);
        json.update({{"rig", rig.name},
                     {"eigenvalues", nullptr},
                     {"spectral_radius", nullptr},
                     {"growth_per_s", growth_json(verdict)},
                     {"source", source_words(true)}});
        print_json(json);
        return check_exit_code(arguments, verdict, margin);
    }
    print_assumptions(rig);
    std::printf("%s: %s, %s\n", rig.name.c_str(), verdict_name(verdict.kind), verdict.because.c_str());
    std::printf("  %-14s %s\n", "source", source_words(true));
    print_delay_budget(rig);
    print_margin(margin);
    return check_exit_code(arguments, verdict, margin);
}

int answer_compensated_limits(const rig &rig, const rig_arguments &arguments, std::vector<std::string> varies)
{
    refuse_arm(rig);
    const compensated_growth own = growth_of_compensated(rig, arguments.amplitude_m);
    stability_verdict verdict = own.verdict;
    verdict.because += left_out_words(varies);
    std::vector<std::string> without = std::move(varies);
    if (!own.is_measured) {
        const std::vector<std::string> small = left_out(rig, 0.0);
        without.insert(without.end(), small.begin(), small.end());
    }
    const std::vector<compensated_limit> limits = limits_of_compensated(rig, arguments.amplitude_m);
    const stability_margin margin = touches_nothing(rig) ? margin_of(rig) : margin_of_compensated(own, limits);
    if (arguments.json) {
        nlohmann::json json = answer_json(rig, verdict, margin);
        json.update({{"rig", rig.name},
                     {"growth_per_s", growth_json(verdict)},
                     {"source", source_words(own.is_measured)},
                     {"left_out", without}});
        for (const compensated_limit &limit : limits) {
            json["parameters"][std::string(limit.key)] = {
                {"value", limit.value}, {"below", or_null(limit.below)}, {"above", or_null(limit.above)}};
        }
        print_json(json);
        return check_exit_code(arguments, verdict, margin);
    }
    print_assumptions(rig);
    std::printf("%s: %s, %s\n", rig.name.c_str(), verdict_name(verdict.kind), verdict.because.c_str());
    std::printf("  %-14s %s; the firmware goes on with what it was told\n", "source", source_words(own.is_measured));
    for (const std::string &effect : without) {
        std::printf("  left out: %s\n", effect.c_str());
    }
    print_delay_budget(rig);
    print_margin(margin);
    std::printf("  %-32s %12s %25s\n  %-32s %12s %12s %12s\n", "", "", "nearest limit", "parameter", "value",
                "below", "above");
    for (const compensated_limit &limit : limits) {
        std::printf("  %-32s %12s %12s %12s\n", std::string(limit.key).c_str(), short_number(limit.value).c_str(),
                    or_none(limit.below).c_str(), or_none(limit.above).c_str());
    }
    std::printf(
        "none: no limit within a factor of 10 either way. Intervals narrower than 15 %% may be overlooked.\n");
    return check_exit_code(arguments, verdict, margin);
}

} // namespace berth
