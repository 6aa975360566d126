#include <algorithm>
#include <array>
#include <cmath>
#include <type_traits>

#include "exponential.h"
#include "generator.h"
#include "solver.h"

namespace berth
{

namespace
{

/* Of object, low-pass and transfer behaviour. */
constexpr int base_state_count = second_position;

/* Room for no more than the rows need. */
template <int rows>
using state_of = std::conditional_t<(rows > plant_state_count), beam_state, plant_state>;

/* state(t + dt) = columns * (state, u, u', 1), with only the first `rows` states in use. */
template <int rows>
struct transition {
    std::int64_t duration_ns = -1;
    double columns[rows + plant_input_count][rows];
};

template <int rows>
class exact_steps
{
  public:
    exact_steps(const plant &plant, contact_mode mode) : generator_(smallest_generator(plant, mode)) {}

    template <typename state_type>
    void advance(state_type &state, const reference_line &line, std::int64_t duration_ns)
    {
        const transition<rows> &step = for_duration(duration_ns);
        double in[rows + plant_input_count];
        for (int i = 0; i < rows; i++) {
            in[i] = state(i);
        }
        in[rows] = line.position_m;
        in[rows + 1] = line.velocity_m_per_s;
        in[rows + 2] = 1.0;
        double out[rows] = {};
        for (int column = 0; column < rows + plant_input_count; column++) {
            for (int row = 0; row < rows; row++) {
                out[row] += step.columns[column][row] * in[column];
            }
        }
        for (int i = 0; i < rows; i++) {
            state(i) = out[i];
        }
    }

  private:
    /* A regular run has few durations that come again and again, halves of contact steps included; jitter makes new
     * ones all the time. */
    const transition<rows> &for_duration(std::int64_t duration_ns)
    {
        for (transition<rows> &known : known_) {
            if (known.duration_ns == duration_ns) {
                return known;
            }
        }
        transition<rows> &made = known_[next_];
        next_ = (next_ + 1) % known_.size();
        const Eigen::MatrixXd e = balanced_exponential(generator_ * (static_cast<double>(duration_ns) * 1e-9));
        const Eigen::Index inputs = e.cols() - plant_input_count;
        made.duration_ns = duration_ns;
        for (int row = 0; row < rows; row++) {
            for (int column = 0; column < rows; column++) {
                made.columns[column][row] = e(row, column);
            }
            for (int input = 0; input < plant_input_count; input++) {
                made.columns[rows + input][row] = e(row, inputs + input);
            }
        }
        return made;
    }

    /* Without the states that no effect uses. */
    static Eigen::MatrixXd smallest_generator(const plant &plant, contact_mode mode)
    {
        const Eigen::MatrixXd full = make_generator<state_of<rows>>(plant, mode);
        constexpr int full_states = state_of<rows>::RowsAtCompileTime;
        constexpr int states = std::max<int>(rows, base_state_count);
        Eigen::MatrixXd a = Eigen::MatrixXd::Zero(states + plant_input_count, states + plant_input_count);
        a.topLeftCorner(states, states) = full.topLeftCorner(states, states);
        a.topRightCorner(states, plant_input_count) = full.block(0, full_states, states, plant_input_count);
        a.bottomRightCorner(plant_input_count, plant_input_count) =
            full.bottomRightCorner<plant_input_count, plant_input_count>();
        return a;
    }

    Eigen::MatrixXd generator_;
    std::array<transition<rows>, 64> known_{};
    std::size_t next_ = 0;
};

/* Rows: 4 without the robot's transfer behaviour, else 6; all of a plant_state with linear effects, and of a
 * beam_state with further modes. */
template <int rows>
class linear_solver final : public solver
{
  public:
    explicit linear_solver(const plant &plant) : steps_(plant, contact_mode::attached) {}

    void advance(beam_state &state, const reference_line &line, std::int64_t duration_ns) override
    {
        steps_.advance(state, line, duration_ns);
    }

  private:
    exact_steps<rows> steps_;
};

template <int rows>
class contact_solver final : public solver
{
  public:
    contact_solver(const rig &rig, const plant &plant)
        : plant_(plant), free_(plant_, contact_mode::free), attached_(plant_, contact_mode::attached),
          step_ns_(std::llround(rig.solver.contact_step_us * 1e3))
    {
    }

    void advance(beam_state &full, const reference_line &line, std::int64_t duration_ns) override
    {
        rows_in_use state =
            full.template head<rows>(); /* a tick has a hundred steps: to copy what is not in use takes long */
        reference_line here = line;
        std::int64_t left_ns = duration_ns;
        while (left_ns > 0) {
            const std::int64_t step_ns = std::min(step_ns_, left_ns);
            substep(state, here, step_ns);
            left_ns -= step_ns;
            here.position_m =
                line.position_m + line.velocity_m_per_s * static_cast<double>(duration_ns - left_ns) * 1e-9;
        }
        full.template head<rows>() = state;
    }

  private:
    using rows_in_use = Eigen::Matrix<double, rows, 1>;

    /* Exact within a mode. A step in which the mode changes is halved until the change lies in the last nanosecond:
     * what is left of it there, the wrong mode for so short a time, is all the error there is. */
    void substep(rows_in_use &state, const reference_line &line, std::int64_t step_ns)
    {
        const contact_mode before = plant_.mode(state);
        rows_in_use tried = state;
        (before == contact_mode::free ? free_ : attached_).advance(tried, line, step_ns);
        if (step_ns == 1 || plant_.mode(tried) == before) {
            state = tried;
            return;
        }
        const std::int64_t half_ns = step_ns / 2;
        const double middle_m = line.position_m + line.velocity_m_per_s * static_cast<double>(half_ns) * 1e-9;
        substep(state, line, half_ns);
        substep(state, {middle_m, line.velocity_m_per_s}, step_ns - half_ns);
    }

    plant plant_;
    exact_steps<rows> free_;
    exact_steps<rows> attached_;
    std::int64_t step_ns_;
};

template <int rows>
std::unique_ptr<solver> make(const rig &rig, const plant &plant)
{
    if (rig.object.kind == object_kind::contact) {
        return std::make_unique<contact_solver<rows>>(rig, plant);
    }
    return std::make_unique<linear_solver<rows>>(plant);
}

} // namespace

std::unique_ptr<solver> make_fast_solver(const rig &rig, const plant &plant)
{
    if (plant.further_mode_count > 0) {
        return std::make_unique<linear_solver<beam_state_count>>(plant);
    }
    if (plant.has_linear_effects()) {
        return make<plant_state_count>(rig, plant);
    }
    return rig.has_transfer_behaviour() ? make<base_state_count>(rig, plant) : make<4>(rig, plant);
}

} // namespace berth
