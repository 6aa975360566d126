#include "ode.h"

#include <algorithm>
#include <string>

#ifdef BERTH_WITH_SUNDIALS

#include <cvode/cvode.h>
#include <nvector/nvector_serial.h>
#include <sunnonlinsol/sunnonlinsol_fixedpoint.h>

#include "sundials_context.h"

namespace berth
{

namespace
{

void require_done(int flag, const char *what)
{
    if (flag < 0) {
        throw input_error(std::string("CVODE: ") + what + " failed with " + std::to_string(flag) +
                          "; are there extreme values in the arm or the rig?");
    }
}

} // namespace

struct ode_solver::parts {
    berth::ode ode;
    SUNContext context = nullptr;
    N_Vector vector = nullptr;
    N_Vector tolerances = nullptr;
    void *memory = nullptr;
    SUNNonlinearSolver iteration = nullptr;

    ~parts()
    {
        CVodeFree(&memory);
        SUNNonlinSolFree(iteration);
        N_VDestroy(tolerances);
        N_VDestroy(vector);
        SUNContext_Free(&context);
    }

    static Eigen::Map<Eigen::VectorXd> state_of(N_Vector vector)
    {
        return {NV_DATA_S(vector), static_cast<Eigen::Index>(NV_LENGTH_S(vector))};
    }
    static int rate(double time_s, N_Vector state, N_Vector rate, void *self)
    {
        state_of(rate) = static_cast<const parts *>(self)->ode.rate(time_s, state_of(state));
        return 0;
    }
    /* Returns CVode's flag. */
    int go(double to_s, double &reached_s)
    {
        long taken = 0;
        require_done(CVodeGetNumSteps(memory, &taken), "CVodeGetNumSteps");
        require_done(CVodeSetMaxNumSteps(memory, std::max(1L, ode.steps_max - taken)), "CVodeSetMaxNumSteps");
        const int flag = CVode(memory, to_s, vector, &reached_s, CV_NORMAL);
        if (flag == CV_TOO_MUCH_WORK) {
            throw not_solved("CVODE: more than " + std::to_string(ode.steps_max) +
                             " steps; are there extreme values in the arm or the rig?");
        }
        if (flag < 0) {
            throw not_solved("CVODE: failed with " + std::to_string(flag) +
                             "; are there extreme values in the arm or the rig?");
        }
        return flag;
    }
    static int event(double time_s, N_Vector state, double *value, void *self)
    {
        *value = static_cast<const parts *>(self)->ode.event(time_s, state_of(state));
        return 0;
    }
};

ode_solver::ode_solver(berth::ode ode, double relative_tolerance, const Eigen::VectorXd &absolute_tolerances)
    : parts_(std::make_unique<parts>())
{
    parts &p = *parts_;
    p.ode = std::move(ode);
    require_done(create_context(&p.context), "SUNContext_Create");
    p.vector = N_VNew_Serial(absolute_tolerances.size(), p.context);
    p.tolerances = N_VClone(p.vector);
    N_VConst(0.0, p.vector);
    parts::state_of(p.tolerances) = absolute_tolerances;
    p.memory = CVodeCreate(CV_ADAMS, p.context);
    require_done(keep_quiet(p.memory), "CVodeSetErrFile"); /* require_done() reports errors */
    require_done(CVodeInit(p.memory, parts::rate, 0.0, p.vector), "CVodeInit");
    require_done(CVodeSVtolerances(p.memory, relative_tolerance, p.tolerances), "CVodeSVtolerances");
    p.iteration = SUNNonlinSol_FixedPoint(p.vector, 0, p.context);
    require_done(CVodeSetNonlinearSolver(p.memory, p.iteration), "CVodeSetNonlinearSolver");
    require_done(CVodeSetUserData(p.memory, &p), "CVodeSetUserData");
    if (p.ode.event) {
        require_done(CVodeRootInit(p.memory, 1, parts::event), "CVodeRootInit");
    }
}

double ode_solver::advance(Eigen::VectorXd &state, double from_s, double to_s, const std::vector<double> &outputs_s,
                           const std::function<void(double, const Eigen::VectorXd &)> &tell)
{
    parts &p = *parts_;
    parts::state_of(p.vector) = state;
    require_done(CVodeReInit(p.memory, from_s, p.vector), "CVodeReInit");
    require_done(CVodeSetStopTime(p.memory, to_s), "CVodeSetStopTime");
    double reached_s = from_s;
    int flag = CV_SUCCESS;
    for (const double output_s : outputs_s) {
        if (output_s <= from_s || output_s >= to_s) {
            continue;
        }
        flag = p.go(output_s, reached_s);
        if (flag == CV_ROOT_RETURN) {
            break;
        }
        tell(reached_s, parts::state_of(p.vector));
    }
    if (flag != CV_ROOT_RETURN) {
        p.go(to_s, reached_s);
    }
    state = parts::state_of(p.vector);
    return reached_s;
}

#else

namespace berth
{

struct ode_solver::parts {
};

ode_solver::ode_solver(ode, double, const Eigen::VectorXd &)
{
    throw input_error("this program was built without SUNDIALS; ask one that was, such as the host's");
}

double ode_solver::advance(Eigen::VectorXd &, double, double to_s, const std::vector<double> &,
                           const std::function<void(double, const Eigen::VectorXd &)> &)
{
    return to_s;
}

#endif

ode_solver::~ode_solver() = default;

} // namespace berth
