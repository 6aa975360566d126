/* The columns of a CSV file as the signals of a record, and what can be wrong with them. */
#ifndef SIM_HAL_DIAGNOSIS_RECORD_RECORD_COLUMNS_H
#define SIM_HAL_DIAGNOSIS_RECORD_RECORD_COLUMNS_H

#include "record.h"
#include "record_table.h"

namespace berth
{

struct signal_member {
    std::string_view name;
    std::string_view unit;
    std::vector<double> record::*member;
    bool is_output; /* of a block */
};

constexpr signal_member signal_members[] = {
    {"t_s", "s", &record::time_s, false},
    {"operator_force_N", "N", &record::operator_force_N, false},
    {"operator_position_m", "m", &record::operator_position_m, false},
    {"operator_velocity_m_per_s", "m_per_s", &record::operator_velocity_m_per_s, false},
    {"command_position_m", "m", &record::command_position_m, true},
    {"robot_position_m", "m", &record::robot_position_m, true},
    {"force_N", "N", &record::force_N, true},
};

/* Where the signal stands in a file: as the rig file says, or under its own name. */
signal_source source_of(const rig &rig, std::string_view signal);

/* As it stands in the rig file. */
std::string mapping_of(const signal_source &source);

/* Takes the signals, and notes what a reader should know. Throws input_error with file, line and column. */
void take_columns(record &made, const record_table &table, const rig &rig);

/* Every output must change. `place`: begins the message. Throws input_error. */
void check_outputs(const record &made, const std::string &place);

/* Something must drive the manipulator; notes an operator who does nothing. */
void check_operator(record &made, const std::string &place);

} // namespace berth

#endif
