/* A measured record: what went into the blocks of the loop and what came out, at a constant rate. */
#ifndef SIM_HAL_DIAGNOSIS_RECORD_RECORD_H
#define SIM_HAL_DIAGNOSIS_RECORD_RECORD_H

#include <algorithm>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "../../../firmware/recorder.h"
#include "../../../hal/rig/rig.h"

namespace berth
{

/* Rows from `begin` up to `end` follow each other one period apart. */
struct record_segment {
    std::size_t begin;
    std::size_t end;
    std::optional<double> stands_m{}; /* where the robot stands as it begins, if not on its setpoint */
};

inline constexpr int pushes_a_row = 8;

/* Row n: at t_n the operator's values and the newest force count, and act until t_(n+1); command_position_m is the
 * setpoint sent at t_n, robot_position_m where the robot is then. A signal that was not recorded is empty. */
struct record {
    std::string path;
    std::string hash;          /* of the file's bytes as they are stored */
    std::uint64_t content = 0; /* hash of the signals: the same measurement, whatever the file around it */
    long header_line = 0;      /* of the file, where the columns are named; 0: a log */
    double period_s = 0.0;
    double time_origin_s = 0.0; /* from here on counts what drifts: start of the run, or of the file */
    std::vector<double> time_s;
    std::vector<double> operator_force_N;
    std::vector<double> operator_position_m;
    std::vector<double> operator_velocity_m_per_s;
    bool is_velocity_derived = false; /* the operator's, from its position */
    std::vector<double> command_position_m;
    std::vector<double> robot_position_m;
    std::vector<double> force_N;
    /* Operator less measured force in the middle of each of `pushes_a_row` parts of a row, where it moves between
     * the rows; empty: it is held over each. */
    std::vector<double> push_within_rows_N;
    /* Of a measured motion that stands for the command, see measured_motion.h; empty: setpoints drive the robot. */
    std::vector<double> bend_m_per_s2;
    std::vector<record_segment> segments;
    std::vector<std::uint8_t> filled; /* rows that were missing: what drives a block is guessed, nothing compared */
    double command_guess_rms_m = 0.0; /* how far off these commands would be, judged by rows that are there */
    bool is_from_this_firmware = false; /* then the command must replay exactly */
    std::vector<std::string> notes;     /* what a reader should know of the data */

    std::size_t size() const { return time_s.size(); }
    bool is_filled(std::size_t row) const { return !filled.empty() && filled[row] != 0; }
    /* One of its signals without the rows that were missing. */
    std::vector<double> known(const std::vector<double> &signal) const;
    bool moves_as_measured() const { return !bend_m_per_s2.empty(); }
    bool has_operator() const { return !operator_force_N.empty() || !operator_position_m.empty(); }
};

/* Rows that are marked. */
inline std::size_t count_of(const std::vector<std::uint8_t> &rows)
{
    return static_cast<std::size_t>(std::count(rows.begin(), rows.end(), std::uint8_t{1}));
}

/* All but the time. */
inline constexpr std::vector<double> record::*record_signals[] = {
    &record::operator_force_N,   &record::operator_position_m, &record::operator_velocity_m_per_s,
    &record::command_position_m, &record::robot_position_m,    &record::force_N};

/* The record up to this row. */
record first_rows(const record &whole, std::size_t rows);

/* Makes a record of the ticks of a loop, one after another: the rows in which it ran. */
class record_of_ticks
{
  public:
    /* `rig`: of the loop. */
    explicit record_of_ticks(const rig &rig);

    void add(const tick_record &tick);

    /* Throws input_error where there is too little, or the rate is not that of `wanted`. */
    record finish(const rig &wanted, bool may_be_still);

    record made; /* so far */

  private:
    bool is_force_;
    bool is_late_; /* the robot's report */
    bool is_compensated_;
    bool is_limited_ = false; /* by the firmware, in some tick */
    bool was_running_ = false;
    double label_ = 0.0;
    std::vector<double> labels_;
};

/* Reads a log of `berth run` or a CSV file (also .gz), its columns named as the members above or as `rig.signals`
 * says. The rate must be that of the rig, if that is given one. Unless it may be a standstill, every output must
 * change. Throws input_error.
 */
record read_record(const std::string &path, const rig &rig, bool may_be_still = false);

} // namespace berth

#endif
