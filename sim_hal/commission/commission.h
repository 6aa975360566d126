/* Commissioning on a PC: one stage after the other, on the simulated rig or from a log of the target. */
#ifndef SIM_HAL_COMMISSION_COMMISSION_H
#define SIM_HAL_COMMISSION_COMMISSION_H

#include <functional>
#include <string>
#include <vector>

#include "judge.h"

namespace berth
{

/* Rigs of a stage: `given` is the file; `told` has what earlier stages measured and what the stage changes;
 * `hardware` is what is behind the wires of the simulated rig. */
struct stage_rigs {
    rig given;
    rig told;
    rig hardware;
};

/* Loads the rig with further overrides behind those of the command line. */
using rig_loader = std::function<rig(const std::vector<std::string> &overrides)>;

struct stage_request {
    berth::stage stage = stage::watch;
    rig_loader load;
    std::vector<std::string> hardware;        /* overrides that the hardware alone has */
    std::vector<std::array<double, 3>> poses; /* tare: where gravity points; empty: as in the rig file */
    std::vector<std::string> logs;            /* of the target, one a pose; empty: the rig is simulated */
    std::string folder;                       /* for the logs of the simulated rig */
    stage_settings settings;
    double margin = 0.01;                              /* damping ratio */
    std::function<void(const std::string &)> progress; /* of the diagnosis; may be empty */
};

/* Runs or reads the stage and judges it. The entry lacks only its time and configuration. Throws input_error. */
stage_entry commission_stage(const stage_request &request, const commissioning &record);

} // namespace berth

#endif
