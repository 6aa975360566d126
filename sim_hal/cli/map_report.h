/* What a map amounts to, for a program and for a person. */
#ifndef SIM_HAL_CLI_MAP_REPORT_H
#define SIM_HAL_CLI_MAP_REPORT_H

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "../stability/varying_map.h"
#include "map_csv.h"
#include "map_request.h"
#include "robot_choice.h"

namespace berth
{

/* What is to be computed. All but `varying` are of the loop that does not change from tick to tick. */
struct map_job {
    chosen_rig chosen;
    map_request request;
    std::optional<map_request> lower_end; /* of the dead times that the robot preset reports, if they are a range */
    std::optional<map_request> varying;   /* if the loop changes: at the upper end */
    wake_histogram histogram;
    std::int64_t ticks = 0;
    double run_s = 0.0;   /* greater than 0: each point is run for so long, there are no eigenvalues */
    bool bounces = false; /* a tool in contact: `request` holds it there, and each point also plays a bounce */
};

/* A line for each thing that its values know nothing of. */
std::vector<std::string> left_out_of_map(const map_job &job);

/* For a program. */
nlohmann::json as_json(const map_job &job, const map_summary &sums);

/* For a person; `json` from as_json(), with compute_s. */
void print_map_summary(const map_request &request, const map_summary &sums, const nlohmann::json &json);

} // namespace berth

#endif
