#include "compensated_report.h"

#include <cstdio>

#include "../../firmware/compensation/compensation.h"
#include "../compensated.h"
#include "../run_advice.h"
#include "../schedule.h"
#include "../stability/arm_loop.h"
#include "../stability/compensation_states.h"
#include "../stability/loop_timeline.h"
#include "../verdict_words.h"
#include "gains_report.h"
#include "json_or_null.h"
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

std::string source_words(const rig &rig, bool is_measured)
{
    if (is_measured) {
        return "growth of runs of 20 s without noise, as this compensation with these effects has no eigenvalues";
    }
    const bool is_compensated = compensation_is_on(&rig.firmware);
    return std::string("eigenvalues of the loop") +
           (rig.firmware.arm.kind != ARM_NONE ? " of the whole arm where it starts" : "") +
           (is_compensated ? " with its compensation" : "");
}

/* Of an arm only what its eigenvalues tell. */
void refuse_arm_without_eigenvalues(const rig &rig)
{
    if (is_time_varying(rig) || !compensation_is_linear(rig)) {
        refuse_arm(rig);
    }
}

/* Of an unstable run that was too short for a decrement, how its height changed. */
nlohmann::json growth_json(const stability_verdict &verdict, const growth_prediction &predicted)
{
    return verdict.growth      ? nlohmann::json(verdict.growth->growth_per_s)
           : verdict.is_stable ? or_null(predicted.growth_per_s)
                               : nlohmann::json();
}

/* With small motions as every command has them; else each loop of a schedule by its run. */
growth_predictor predictor_of(const rig_arguments &arguments)
{
    if (!arguments.amplitude_m) {
        return predict_unscheduled;
    }
    return [amplitude_m = arguments.amplitude_m](const rig &at) { return predict_compensated(at, amplitude_m); };
}

/* The loop that decides. */
scheduled_loop worst_loop(const rig &stated, const rig_arguments &arguments)
{
    return has_schedule(stated)
               ? worst_of_schedule(stated,
                                   [&](const rig &at) { return predict_compensated(at, arguments.amplitude_m); })
               : scheduled_loop{0.0, stated, predictor_of(arguments)(stated)};
}

/* The schedule, and what makes it stable. */
void complete(stability_verdict &verdict, const rig &stated, const growth_prediction &predicted,
              const rig_arguments &arguments)
{
    if (!predicted.schedule.empty()) {
        verdict.because = schedule_words(predicted) + ": " + verdict.because;
    }
    add_caveat_of_run(verdict, stated);
    if (verdict.is_stable == std::optional<bool>(false) && verdict.advice.empty() && !arguments.amplitude_m) {
        verdict.advice = advice_text(is_told_by_runs(stated) ? advise_by_runs(stated) : advise(stated));
    }
}

void print_advice(const stability_verdict &verdict)
{
    if (!verdict.advice.empty()) {
        std::printf("  %-14s %s\n", "advice", verdict.advice.c_str());
    }
}

} // namespace

int answer_compensated_growth(const rig &stated, const rig_arguments &arguments)
{
    refuse_arm(stated);
    const scheduled_loop worst = worst_loop(stated, arguments);
    const rig &rig = worst.rig;
    stability_verdict verdict = verdict_by_runs(rig, arguments.amplitude_m);
    complete(verdict, stated, worst.prediction, arguments);
    const stability_margin margin =
        touches_nothing(rig) ? margin_of(rig) : margin_of_compensated(rig, arguments.amplitude_m);
    if (arguments.json) {
        nlohmann::json json = answer_json(stated, verdict, margin);
        json.update({{"rig", rig.name},
                     {"eigenvalues", nullptr},
                     {"spectral_radius", nullptr},
                     {"growth_per_s", growth_json(verdict, worst.prediction)},
                     {"prediction", prediction_json(worst.prediction)},
                     {"source", source_words(rig, true)}});
        print_json(json);
        return check_exit_code(arguments, verdict, margin);
    }
    print_assumptions(rig);
    std::printf("%s: %s, %s\n", rig.name.c_str(), verdict_name(verdict.kind), verdict.because.c_str());
    std::printf("  %-14s %s\n", "source", source_words(rig, true).c_str());
    print_caveat(verdict);
    print_delay_budget(stated);
    print_margin(margin);
    print_advice(verdict);
    return check_exit_code(arguments, verdict, margin);
}

int answer_compensated_limits(const rig &stated, const rig_arguments &arguments)
{
    refuse_arm_without_eigenvalues(stated);
    const scheduled_loop worst = worst_loop(stated, arguments);
    std::vector<std::string> varies;
    rig rig = worst.rig;
    if (is_time_varying(rig)) {
        varies = what_varies(rig, load_wake_histogram(rig));
        rig = without_variation(rig);
    }
    const compensated_growth own = growth_of_compensated(rig, arguments.amplitude_m);
    stability_verdict verdict = verdict_by_runs(worst.rig, arguments.amplitude_m);
    complete(verdict, stated, worst.prediction, arguments);
    verdict.because += left_out_words(varies);
    std::vector<std::string> without = std::move(varies);
    if (!own.is_measured) {
        const std::vector<std::string> small = left_out(rig, 0.0);
        without.insert(without.end(), small.begin(), small.end());
    }
    const std::vector<compensated_limit> limits = limits_of_compensated(rig, arguments.amplitude_m);
    const stability_margin margin = touches_nothing(rig) ? margin_of(rig) : margin_of_compensated(rig, own, limits);
    if (arguments.json) {
        nlohmann::json json = answer_json(stated, verdict, margin);
        json.update({{"rig", rig.name},
                     {"growth_per_s", growth_json(verdict, worst.prediction)},
                     {"prediction", prediction_json(worst.prediction)},
                     {"source", source_words(rig, own.is_measured)},
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
    std::printf("  %-14s %s%s\n", "source", source_words(rig, own.is_measured).c_str(),
                compensation_is_on(&rig.firmware) ? "; the firmware goes on with what it was told" : "");
    for (const std::string &effect : without) {
        std::printf("  left out: %s\n", effect.c_str());
    }
    print_caveat(verdict);
    print_delay_budget(stated);
    print_margin(margin);
    print_advice(verdict);
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
