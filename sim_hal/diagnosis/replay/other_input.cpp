#include "other_input.h"

namespace berth
{

double rms_of_other_input(block block, const record &recorded, const record &other, const rig &rig,
                          const sample_events &events)
{
    block_model as_recorded(block, recorded, rig, events, held_out_parts::none);
    block_model as_other(block, other, rig, events, held_out_parts::none);
    std::vector<double> error;
    std::vector<double> other_error;
    as_recorded.error(rig, error);
    as_other.error(rig, other_error);
    for (std::size_t n = 0; n < error.size(); n++) {
        error[n] -= other_error[n];
    }
    return rms_of(error, as_recorded.uses(), row_use::fit);
}

} // namespace berth
