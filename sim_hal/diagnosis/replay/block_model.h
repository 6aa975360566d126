/* One block of the loop over one record: its error as a function of the rig. */
#ifndef SIM_HAL_DIAGNOSIS_REPLAY_BLOCK_MODEL_H
#define SIM_HAL_DIAGNOSIS_REPLAY_BLOCK_MODEL_H

#include <array>
#include <string_view>
#include <vector>

#include "../../effects/effect.h"
#include "../noise/noise.h"
#include "../record/record.h"
#include "replay.h"

namespace berth
{

/* Operator and force to command; command to robot position; command through the robot to force. */
enum class block { manipulator, robot, force };

constexpr std::string_view block_names[] = {"manipulator", "robot", "force"};
constexpr std::string_view block_units[] = {"m", "m", "N"};

/* rms of the rounding to a step of the wire, in the block's unit: nothing is known better. */
double resolution_rms(block block);

/* Of windows of a manipulator without a spring, in each of which its acceleration shows above the noise of the
 * positions; rows_max at most. */
std::size_t rows_that_show_acceleration(const record &record, std::size_t rows_max);

/* The record has what goes in and what comes out. */
bool can_replay(const record &record, block block);

/* Effects of the block `effect` show in `block`. Without a measured robot position the force has to tell of the
 * robot, too. */
bool acts_in(const effect &effect, block block, const record &record, const rig &rig);

/* Which parts of a record fits do not see: contiguous ones, spread over it. */
enum class held_out_parts { none, two_tenths, odd, even };

class block_model
{
  public:
    block_model(block block, const record &record, const rig &base, const sample_events &events,
                held_out_parts held_out);

    /* Measured less simulated, one a row, in m or N; rows not in use have 0. */
    void error(const rig &rig, std::vector<double> &error);

    /* The same of a rig hardly beside the last one of error(): a manipulator's windows start from the states found
     * there, and what other starts would change is taken out as it was there (Kaufman's approximation of variable
     * projection, BIT 1975). */
    void error_beside(const rig &rig, std::vector<double> &error);

    const std::vector<double> &measured() const;

    /* rms of the rounding to the step in which it was measured. */
    double rounding_rms() const { return rounding_rms_; }
    /* The same, with the noise, where coarse steps of the column that drives the block leave more open; else 0. */
    double open_by_input_rms() const { return open_by_input_rms_; }
    void leave_open(double rms) { open_by_input_rms_ = rms; }
    /* Of rows that are missing, three or more one after the other, what drives the block is put in so coarsely that
     * it may show beside this noise, and there are too many to wait until it is over. */
    bool compares_guesses(const rig &rig, double noise_rms) const;

    /* Rows of a window in which a wrong force shows as one bow: of a manipulator without a spring; else 1. */
    double rows_per_fact() const { return rows_per_fact_; }
    const std::vector<row_use> &uses() const { return uses_; }
    void use(std::vector<row_use> uses) { uses_ = std::move(uses); }

    /* Of an error as error() makes it, by tenths of the record; and holds out two other tenths than the fourth and
     * the eighth, of a model that was made with two_tenths. */
    std::array<double, 10> mean_squares_of_tenths(const std::vector<double> &error) const;
    void hold_out(const std::array<std::size_t, 2> &tenths);
    const std::array<std::size_t, 2> &held_out() const { return tenths_; }
    const sample_events &events() const { return events_; }
    /* The events are others than in the replay before. */
    void forget_motion() { motion_keys_.clear(); }
    const record &data() const { return record_; }
    block which() const { return block_; }
    /* Some part begins in motion and is too short to leave out of it what the sensor's spring rings. */
    bool rings_on() const { return rings_on_; }
    const robot_motion &motion() const { return motion_; } /* of the last replay; block::robot, block::force */

    /* Replaces a further force in the block by what it does to the output, row by row: the position of the
     * manipulator, less what a start differs; the force after low-pass and delay. */
    void respond_to_force(const rig &rig, std::vector<double> &force_N) const;

  private:
    std::size_t part_of(std::size_t row, std::size_t segment) const;
    std::size_t until_play_is_crossed(const record_segment &segment) const;
    std::vector<std::size_t> rows_to_settle(const rig &base);
    std::size_t rows_to_forget(const rig &base) const;
    void divide(held_out_parts held_out, std::size_t length);
    void add_windows(const record_segment &segment, std::size_t length);
    void replay_motion(const rig &rig);
    void compare(const std::vector<double> &simulated, std::vector<double> &error) const;
    void replay_windows(const rig &rig, std::vector<double> &error);
    std::vector<Eigen::Vector2d> remove_starts(const rig &rig, std::vector<double> &error) const;
    void follow_starts(const rig &rig, const std::vector<Eigen::Vector2d> &starts,
                       const std::vector<std::size_t> &open, const std::vector<double> &at_start);
    std::vector<std::size_t> all_windows() const;
    std::vector<double> squares_of_windows(const std::vector<double> &error) const;
    std::vector<Eigen::Vector2d> remove_followed(std::vector<double> &error,
                                                 const std::vector<std::size_t> &windows) const;
    void move_manipulator(const rig &rig, std::vector<double> &force_N) const;
    void pass_sensor(const rig &rig, std::vector<double> &force_N) const;

    block block_;
    const record &record_;
    const sample_events &events_;
    std::vector<std::size_t> rows_to_settle_; /* by segment */
    std::size_t rows_to_forget_ = 0;
    bool rings_on_ = false;
    std::vector<row_use> uses_;
    std::array<std::size_t, 2> tenths_{3, 7}; /* held out, of two_tenths */
    double play_m_ = 0.0;                     /* of the robot, or the width of its dead band */
    std::size_t window_length_ = 0;
    std::vector<record_segment> windows_; /* manipulator: parts that each start anew, from these states */
    std::vector<Eigen::Vector2d> starts_;
    double range_m_ = 0.0;                        /* of the command */
    std::vector<Eigen::Vector2d> found_starts_;   /* of the last error(); empty: they were not followed */
    std::array<std::vector<double>, 2> followed_; /* of the replay, by position and velocity of its window's start */
    robot_motion motion_;
    std::vector<double> motion_keys_; /* what motion_ was made for */
    std::vector<double> simulated_;
    double rows_per_fact_ = 1.0;
    double rounding_rms_ = 0.0;
    double open_by_input_rms_ = 0.0;
};

} // namespace berth

#endif
