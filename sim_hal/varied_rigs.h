/* Growth of many rigs that differ from one in the values of a few keys, without reading a file for each. */
#ifndef SIM_HAL_VARIED_RIGS_H
#define SIM_HAL_VARIED_RIGS_H

#include <string>
#include <vector>

#include "../hal/rig/rig.h"
#include "stability/spectrum.h"

namespace berth
{

/* Eigenvalues of the loop that decides: of a schedule the worst one, of a tool the one in contact, of effects of
 * size the equivalent at the usual amplitude. Throws input_error where a loop has none: it changes from tick to
 * tick. */
spectrum deciding_spectrum(const rig &of);

/* Keys of such a rig may be set one after the other, as `--set` does. With an arm, a beam or further axes some
 * values follow from others as the file is read: such a rig has to be read anew. */
bool is_settable(const rig &of);

struct varied_growth {
    std::vector<double> growth_per_s; /* of each rig; NaN: it was refused */
    std::vector<double> spectral_radius;
    std::vector<std::string> refusal; /* of each rig, one line; empty: none */
};

/* `values`: of each rig, one row of a value for each key; the keys are numbers of a rig file. The same bits as
 * reading each rig with these settings and asking for its spectrum. Throws input_error for a key that is unknown,
 * and for a rig that is not settable. */
varied_growth growth_of_varied(const rig &base, const std::vector<std::string> &keys, const double *values,
                               std::size_t rigs);

} // namespace berth

#endif
