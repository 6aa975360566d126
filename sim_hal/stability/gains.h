/* What helps most: what becomes of the loop when one thing of the rig changes by a share. */
#ifndef SIM_HAL_STABILITY_GAINS_H
#define SIM_HAL_STABILITY_GAINS_H

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "../../hal/rig/rig.h"
#include "limits.h"
#include "physical_parameter.h"
#include "spectrum.h"

namespace berth
{

/* The mode of the largest |z| decides whether the loop is stable, and how fast its motion decays. */
struct loop_quality {
    berth::mode mode;
    std::string mode_name;
    std::optional<double> margin; /* modulus margin; of a stable loop */
    int force_age_ticks;
};

/* `rig` is linear. Nothing where a spring softens to nothing. */
std::optional<loop_quality> quality_of(const rig &rig);

struct changed_loop {
    double value; /* of the parameter */
    loop_quality quality;
};

struct parameter_gain {
    std::string_view key;             /* of the rig file */
    double value;                     /* the rig's own */
    delays_stay delays;               /* where it is the rate */
    std::optional<changed_loop> less; /* nothing: no rig may have it */
    std::optional<changed_loop> more;

    /* The one whose motion decays faster, and the one with the larger margin; nullptr: neither may be, or is stable.
     */
    const changed_loop *decaying_faster() const;
    const changed_loop *with_more_margin() const;
};

/* Of the rate, with delays that stay as long and with delays that stay as many ticks, and of every physical
 * parameter, each multiplied by 1 - share and 1 + share: exact eigenvalues, not slopes. What the rig has at 0
 * changes by the share of a usual size. A period is a whole number of nanoseconds, and one that the profile of the
 * robot channel has room for: a rate changes to the nearest that has one. share: 0 to 1, both excluded. */
std::vector<parameter_gain> find_gains(const rig &rig, double share, const linear_view &linear = as_it_is);

/* By falling decay, and by falling margin. */
void rank_by_decay(std::vector<parameter_gain> &gains);
void rank_by_margin(std::vector<parameter_gain> &gains);

} // namespace berth

#endif
