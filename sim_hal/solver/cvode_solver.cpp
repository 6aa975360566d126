#include <cvode/cvode.h>
#include <nvector/nvector_serial.h>
#include <sunnonlinsol/sunnonlinsol_fixedpoint.h>

#include <string>

#include "../../hal/rig/rig_file.h"
#include "solver.h"
#include "sundials_context.h"

namespace berth
{

namespace
{

void require(int flag, const char *what)
{
    if (flag < 0) {
        throw input_error(std::string("solver.kind = \"cvode\": ") + what + " failed with " + std::to_string(flag) +
                          "; loosen solver.relative_tolerance, look for extreme values in the rig, or use \"fast\"");
    }
}

class cvode_solver final : public solver
{
  public:
    cvode_solver(const rig &rig, const plant &plant) : plant_(plant)
    {
        require(create_context(&context_), "SUNContext_Create");
        vector_ = N_VNew_Serial(plant_.state_count(), context_);
        N_VConst(0.0, vector_);
        memory_ = CVodeCreate(CV_ADAMS, context_);
        require(keep_quiet(memory_), "CVodeSetErrFile"); /* require() reports errors */
        require(CVodeInit(memory_, right_hand_side, 0.0, vector_), "CVodeInit");
        /* None of the states is held to more than the others when it passes through zero. */
        tolerances_ = N_VClone(vector_);
        values_of(tolerances_) =
            rig.solver.absolute_tolerance_m * plant_.natural_scales<beam_state>().head(plant_.state_count());
        require(CVodeSVtolerances(memory_, rig.solver.relative_tolerance, tolerances_), "CVodeSVtolerances");
        iteration_ = SUNNonlinSol_FixedPoint(vector_, 0, context_);
        require(CVodeSetNonlinearSolver(memory_, iteration_), "CVodeSetNonlinearSolver");
        require(CVodeSetUserData(memory_, this), "CVodeSetUserData");
        require(CVodeSetMaxNumSteps(memory_, 1000000), "CVodeSetMaxNumSteps");
    }

    cvode_solver(const cvode_solver &) = delete;
    cvode_solver &operator=(const cvode_solver &) = delete;

    ~cvode_solver() override
    {
        CVodeFree(&memory_);
        SUNNonlinSolFree(iteration_);
        N_VDestroy(tolerances_);
        N_VDestroy(vector_);
        SUNContext_Free(&context_);
    }

    void advance(beam_state &state, const reference_line &line, std::int64_t duration_ns) override
    {
        const double end_s = static_cast<double>(duration_ns) * 1e-9;
        line_ = line;
        values_of(vector_) = state.head(plant_.state_count());
        require(CVodeReInit(memory_, 0.0, vector_), "CVodeReInit");
        require(CVodeSetStopTime(memory_, end_s), "CVodeSetStopTime");
        double reached_s = 0.0;
        require(CVode(memory_, end_s, vector_, &reached_s, CV_NORMAL), "CVode");
        state.head(plant_.state_count()) = values_of(vector_);
    }

  private:
    static Eigen::Map<Eigen::VectorXd> values_of(N_Vector vector)
    {
        return {NV_DATA_S(vector), static_cast<Eigen::Index>(NV_LENGTH_S(vector))};
    }

    static int right_hand_side(double time_s, N_Vector state, N_Vector rate, void *self)
    {
        const auto &solver = *static_cast<const cvode_solver *>(self);
        const reference_line &start = solver.line_;
        const reference_line now{start.position_m + start.velocity_m_per_s * time_s, start.velocity_m_per_s};
        if (solver.plant_.further_mode_count > 0) {
            beam_state all = beam_state::Zero();
            all.head(solver.plant_.state_count()) = values_of(state);
            values_of(rate) = solver.plant_.derivative(all, now).head(solver.plant_.state_count());
        } else {
            using plain = Eigen::Map<plant_state>;
            plain(NV_DATA_S(rate)) = solver.plant_.derivative(plant_state(plain(NV_DATA_S(state))), now);
        }
        return 0;
    }

    plant plant_;
    reference_line line_;
    SUNContext context_ = nullptr;
    N_Vector vector_ = nullptr;
    N_Vector tolerances_ = nullptr;
    void *memory_ = nullptr;
    SUNNonlinearSolver iteration_ = nullptr;
};

} // namespace

std::unique_ptr<solver> make_cvode_solver(const rig &rig, const plant &plant)
{
    return std::make_unique<cvode_solver>(rig, plant);
}

} // namespace berth
