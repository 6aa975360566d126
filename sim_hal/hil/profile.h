/* What the operator commands over time: closed forms, or a recorded file. */
#ifndef SIM_HAL_HIL_PROFILE_H
#define SIM_HAL_HIL_PROFILE_H

#include <vector>

#include "../../hal/rig/rig.h"

namespace berth
{

/* `value` is a position in m or a force in N, `rate` its time derivative. */
struct profile_point {
    double value;
    double rate;
};

class profile
{
  public:
    /* Reads the file, if the profile is one. Throws input_error. */
    explicit profile(const rig &rig);

    /* `time_s` counts from the release. */
    profile_point at(double time_s) const;

  private:
    profile_point from_file(double time_s) const;
    profile_point multisine(double time_s) const;

    profile_rig rig_;
    double offset_;
    double amplitude_;
    std::vector<double> times_s_;
    std::vector<double> values_;
    struct tone {
        double frequency_Hz;
        double phase_rad;
    };
    std::vector<tone> tones_;
};

/* Columns `t_s` and `column` (may be empty if there is only one other) of a CSV file with a header; .gz is read
 * through zlib. Throws input_error with file and line. */
struct csv_columns {
    std::vector<double> times_s;
    std::vector<double> values;
    std::vector<int> lines; /* of the file, from 1 on */
};
csv_columns read_csv_columns(const std::string &path, const std::string &column);

} // namespace berth

#endif
