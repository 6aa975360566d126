/* What model and motion answer together once a rig has run; and running one in virtual time. */
#ifndef SIM_HAL_RUN_ANSWER_H
#define SIM_HAL_RUN_ANSWER_H

#include <string>
#include <vector>

#include "../firmware/recorder.h"
#include "answer.h"

namespace berth
{

struct run_answer {
    growth_prediction predicted;
    stability_margin margin; /* empty of a loop that is not stable */
    stability_verdict verdict;
};

/* `obstacles`: what kept a loop that never ran from running, see obstacles_of(); else empty. */
run_answer answer_of_run(const rig &rig, const motion_evidence &evidence, const std::string &obstacles,
                         answer_scope scope = answer_scope::whole);

struct played_run {
    std::vector<tick_record> ticks; /* all of them, from the first on */
    motion_evidence evidence;
    run_answer answer;
};

/* Firmware and simulated rig until the supervisor stops. `log_path`: ULog; empty: none. Throws input_error. */
played_run play(const rig &rig, const std::string &log_path = {}, answer_scope scope = answer_scope::whole);

} // namespace berth

#endif
