/* What the operator commands over time: closed forms, or a recorded file. */
#ifndef SIM_HAL_HIL_PROFILE_H
#define SIM_HAL_HIL_PROFILE_H

#include <string>
#include <string_view>
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

    /* What a user should know of the file; empty: nothing. */
    const std::string &note() const { return note_; }

  private:
    profile_point from_file(double time_s) const;
    profile_point multisine(double time_s) const;

    profile_rig rig_;
    double offset_;
    double amplitude_;
    std::vector<double> times_s_;
    std::vector<double> values_;
    std::string note_;
    struct tone {
        double frequency_Hz;
        double phase_rad;
    };
    std::vector<tone> tones_;
};

/* Which column of a file is played or simulated, and what its values must be. */
struct file_column {
    std::string name;    /* empty: the only one beside the time */
    std::string_view si; /* unit of `scale` times a value; a scale of 1 or -1 converts none */
    double scale;
    std::string name_key; /* where to say another one: profile.column */
    std::string scale_key;
};

/* A column over time of a CSV file as csv_reader.h has it. The time is `t_s`, or a column such as time_ms that names
 * its unit, or one of stamps; its values must increase. Throws input_error with file and line. */
struct csv_columns {
    std::vector<double> times_s;
    std::vector<double> values; /* not scaled yet */
    std::vector<int> lines;     /* of the file, from 1 on */
    std::string note;           /* what a reader should know; may be empty */
};
csv_columns read_csv_columns(const std::string &path, const file_column &wanted);

} // namespace berth

#endif
