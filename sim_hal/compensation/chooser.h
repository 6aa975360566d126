/* Which compensation suits a rig: every method on the rig as it is told, and on rigs that are somewhat different
 * while the loop still believes what it was told. */
#ifndef SIM_HAL_COMPENSATION_CHOOSER_H
#define SIM_HAL_COMPENSATION_CHOOSER_H

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "dissipator.h"
#include "trial.h"

namespace berth
{

/* A way to compensate: keys of a rig file and their values, "prediction.enabled=true". */
struct method {
    std::string name;
    std::vector<std::string> settings;
};

/* How the rig may differ from what the loop was told. */
struct difference {
    std::string name;
    std::vector<std::string> settings;
};

struct method_verdict {
    berth::method method;
    std::vector<trial_result> trials; /* by difference */
    bool is_robust;                   /* ran and stayed bounded in each */
    double error;                     /* on the rig as it is told */
    double worst_error;
    std::size_t worst; /* the difference with it; of a method that is not robust, the first that broke it */
};

struct choice_request {
    berth::rig rig;
    double dead_time_share = 0.3;
    double stiffness_share = 0.5;
    double mass_share = 0.2;
    std::optional<double> noise_N; /* of the trial with noise, one standard deviation; else ten times the rig's */
    double duration_s = 10.0;
    loop_margin margin{5.0, 0.0}; /* that the dissipator is designed for */
};

struct choice {
    std::vector<difference> differences; /* the first is none */
    std::vector<std::string> impossible; /* differences that no such rig may have */
    std::vector<method_verdict> methods; /* robust ones first, by rising worst error */

    const method_verdict *recommended() const { return methods.front().is_robust ? &methods.front() : nullptr; }
};

/* `tried` is called now and then with the share that is done. Throws input_error for a rig that has compensation. */
choice choose_compensation(const choice_request &request, const std::function<void(double)> &tried = {});

/* A change of the rig with which there would be something to recommend: "robot.dead_time_ms from 17.5 to 8.75". */
struct helpful_change {
    std::string key;
    double from;
    double to;
    berth::method method;
};
std::vector<helpful_change> what_would_help(const choice_request &request);

} // namespace berth

#endif
