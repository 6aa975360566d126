/* The command line of a program that runs the loop on real hardware. */
#ifndef HAL_LINUX_OPTIONS_H
#define HAL_LINUX_OPTIONS_H

#include <string>
#include <vector>

#include "log_rotation.h"

namespace berth
{

struct target_options {
    std::string rig;
    std::string log_path;
    log_rotation rotation;
    std::vector<std::string> overrides;
    std::string jitter_path;  /* empty: none */
    std::string live_address; /* of `berth live`; empty: none */
    std::string stage;        /* of commissioning; empty: none */
    std::string record_path;  /* of its stages; empty: LOG's folder, commissioning.json */
    double ramp_s = 60.0;
    bool check_only = false;
    bool without_realtime = false;
    bool without_buses = false;
    bool until_stopped = false;
    bool is_done = false; /* help or version: it has been printed */
};

/* Throws input_error. */
target_options parse_options(int argc, char **argv);

} // namespace berth

#endif
