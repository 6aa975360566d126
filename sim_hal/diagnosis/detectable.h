/* How small an effect a record would have shown. */
#ifndef SIM_HAL_DIAGNOSIS_DETECTABLE_H
#define SIM_HAL_DIAGNOSIS_DETECTABLE_H

#include <optional>

#include "search/search.h"

namespace berth
{

struct effect_value {
    std::string_view key;
    double value;
};

struct detectable_size {
    const berth::effect *effect;
    std::string_view key;             /* of the parameter that says how large it is */
    std::optional<double> value;      /* of that key; nothing: this record shows no size of it */
    double given;                     /* what the rig file says */
    std::vector<effect_value> others; /* the effect's other parameters, where it shows best */
    berth::rig rig;                   /* with the effect in that size */
};

/* White sum of squares, beyond all that re-tuned parameters make up for, from which on an effect with so many
 * parameters of its own is accepted in 19 of 20 records. `cost`: of the model without it, over so many rows. */
double square_to_be_seen(double cost, std::size_t rows, std::size_t parameters);

/* Every effect that acts in the block of the model; `base` is the model that was enough. A size is found where the
 * response to it, projected on what the base cannot make up for, reaches square_to_be_seen(). */
std::vector<detectable_size> find_detectable(block_model &model, const noise_model &noise, const fit_result &base,
                                             const rig &given, const search_options &options);

} // namespace berth

#endif
