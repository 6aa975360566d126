/* Columns that a logger wrote some rows late. A late force column looks like a sensor's delay to the force, but the
 * firmware felt the force in time, so the manipulator tells the two apart; a late column of the robot's position
 * looks like a longer dead time, of which the force knows nothing. Named only where two blocks say so. */
#ifndef SIM_HAL_DIAGNOSIS_LATE_COLUMNS_H
#define SIM_HAL_DIAGNOSIS_LATE_COLUMNS_H

#include <string_view>
#include <vector>

#include "record/request_records.h"

namespace berth
{

struct late_column {
    const effect *told_as; /* log.force_late and the like: no physics, so not of the library */
    std::string_view signal;
    berth::block block; /* whose output it is */
    int rows;           /* less than 0: early */
    double uncertain_rows;
    double delta_bic;
    part_rms fit_rms;                 /* before: as logged; retuned: the same, the base fitted */
    part_rms held_out_rms;            /* of the validation record, else of the record */
    double gain, gain_low, gain_high; /* share by which the square of that error falls, with its interval of 95 % */
};

/* Finds them, and moves them into their rows in all records. */
std::vector<late_column> put_late_columns_in_place(records_of_request &records);

/* Names them in their blocks, and where to say it in the rig file. */
void tell_late_columns(diagnosis &result, const std::vector<late_column> &late);

} // namespace berth

#endif
